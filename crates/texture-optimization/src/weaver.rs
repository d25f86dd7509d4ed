//! Algorithm 1 at one level. `[Kwatra05 3]`

use selvedge_core::{Domain, Event, Exemplars, Grid, Render, Run, SourceMap, par};

use crate::assignment::{self, Place};
use crate::average::average;
use crate::came::Came;
use crate::control::Wishes;
use crate::error::Error;
use crate::falloff::Falloff;
use crate::gradient;
use crate::level::Level;
use crate::neighborhoods::Neighborhoods;
use crate::optimized::Pulls;
use crate::options::{Options, Search};
use crate::robust;
use crate::schedule::Steps;
use crate::search::{Exact, Found, How, Measure};
use crate::so_far::SoFar;
use crate::stats::{LevelStats, Stats};

/// What a level ends with.
pub(crate) struct Ended {
    pub(crate) x: Grid<f64, 2>,
    /// What `x` is the average of.
    pub(crate) places: Vec<Place>,
    pub(crate) weights: Vec<f64>,
    pub(crate) complete: bool,
}

/// See [`Weaver::finer`].
pub(crate) type Finer<'a> = dyn Fn(SourceMap<2>) -> Result<SourceMap<2>, Error> + 'a;

/// The work at one level.
pub(crate) struct Weaver<'a> {
    options: &'a Options,
    exemplars: &'a Exemplars<2>,
    pub(crate) all: Neighborhoods,
    falloff: Falloff,
    pub(crate) level: Level,
    wishes: Option<&'a Wishes>,
    /// Its number.
    number: usize,
    steps: Steps,
    /// Makes a map of this level one of the output.
    pub(crate) finer: Option<&'a Finer<'a>>,
    run: &'a Run<'a, 2>,
}

impl<'a> Weaver<'a> {
    /// For an output and exemplars of the level's resolution.
    pub(crate) fn new(
        options: &'a Options,
        (exemplars, output): (&'a Exemplars<2>, Domain<2>),
        (level, number, steps): (Level, usize, Steps),
        wishes: Option<&'a Wishes>,
        run: &'a Run<'_, 2>,
    ) -> Self {
        let (all, falloff) = (Neighborhoods::new(output, level.size), Falloff::new(level.size));
        Self { options, exemplars, all, falloff, level, wishes, number, steps, finer: None, run }
    }

    pub(crate) fn pulls<'b>(&'b self, found: &'b [Place], weights: &'b [f64]) -> Pulls<'b> {
        Pulls { exemplars: self.exemplars, all: &self.all, found, weights, falloff: &self.falloff }
    }

    /// Algorithm 1: from a texture with the search, else from random neighborhoods with the average.
    /// `came`: from where its neighborhoods came, if they did.
    pub(crate) fn run(
        &self,
        begun: Option<Grid<f64, 2>>,
        came: Option<Came<'_>>,
        stats: &mut Stats,
    ) -> Result<Ended, Error> {
        let searched = self.searched()?;
        let mut search = Exact::new(searched.as_ref().unwrap_or(self.exemplars), &self.all, self.how(), self.run.simd);
        let mut counts = self.counts();
        let mut weights = vec![1.0; self.all.len()];
        let (mut x, mut places) = match begun {
            Some(x) => (x, None),
            None => {
                let seed = self.run.seed.derive("texture-optimization/level", self.number as u64);
                let places = assignment::random(self.exemplars, &self.all, seed).ok_or_else(|| self.masked())?;
                (self.average((&places, &weights), None)?, Some(places))
            }
        };
        let mut complete = true;
        for iteration in 0..self.options.iterations {
            let found = self.search(&mut search, &x, came.filter(|_| iteration == 0))?;
            if iteration == 0 {
                stats.first.push(robust::mean(&found.distances));
            }
            counts.settled = places.as_ref() == Some(&found.places);
            let is_last = counts.settled || iteration + 1 == self.options.iterations;
            let before = std::mem::replace(&mut weights, robust::weights(&found.distances, self.options.robust));
            self.note(&mut counts, &found, is_last.then_some(&weights));
            stats.distances = Some(self.all.laid(&found.distances)?);
            if counts.settled {
                weights = before;
                break;
            }
            x = self.average((&found.places, &weights), Some(x))?;
            places = Some(found.places);
            complete = !self.run.observer.cancelled();
            if !complete {
                break;
            }
        }
        stats.levels.push(counts);
        Ok(Ended { x, places: places.expect("there is an iteration"), weights, complete })
    }

    /// Channels that are shown, and not followed.
    fn texture(&self) -> usize {
        self.wishes.map_or(self.exemplars.channels(), |wishes| wishes.texture)
    }

    /// Exemplars as the search compares them, where these are others.
    fn searched(&self) -> Result<Option<Exemplars<2>>, Error> {
        let mu = self.options.gradient;
        let searched = (mu != 0.0).then(|| gradient::searched(self.exemplars, self.texture(), mu));
        Ok(searched.transpose()?)
    }

    fn how(&self) -> How {
        How {
            alpha: self.options.complete,
            spread: self.options.spread,
            coherent: self.options.search == Search::Coherent,
            tree: self.options.search == Search::Tree,
            differences: (self.options.gradient != 0.0).then(|| self.texture()),
        }
    }

    /// The E-step: with gradients from what was there, so that their energy cannot rise.
    fn average(
        &self,
        (places, weights): (&[Place], &[f64]),
        before: Option<Grid<f64, 2>>,
    ) -> Result<Grid<f64, 2>, Error> {
        // Neighborhoods of weight 1 weigh 1 together over every sample: at an open edge, where few reach, as in the
        // middle.
        let whole = || -> Vec<f64> {
            let whole = [0, 1].map(|axis| self.all.weighed(axis, &self.falloff));
            self.all.domain.positions().map(|[y, x]| whole[0][y as usize] * whole[1][x as usize]).collect()
        };
        if self.options.gradient != 0.0 {
            let mut x = match before {
                Some(x) => x,
                None => average(self.exemplars, &self.all, places, weights, &self.falloff)?.0,
            };
            let measure = self.measure(self.exemplars, &self.falloff);
            measure.solve(&mut x, (places, weights), (self.wishes, &whole()))?;
            return Ok(x);
        }
        let (mut x, mut votes) = average(self.exemplars, &self.all, places, weights, &self.falloff)?;
        if let Some(wishes) = self.wishes {
            votes.plane_mut(0).iter_mut().zip(whole()).for_each(|(v, sum)| *v /= sum);
            wishes.weigh(&mut x, Some(&votes));
        }
        Ok(x)
    }

    /// Of what is there and what is wanted. `[Kwatra05 4]`
    fn search(&self, exact: &mut Exact<'_>, texture: &Grid<f64, 2>, came: Option<Came<'_>>) -> Result<Found, Error> {
        let mut both;
        let x = match self.wishes {
            Some(wishes) => {
                both = texture.clone();
                wishes.weigh(&mut both, None);
                &both
            }
            None => texture,
        };
        let found = match (self.options.search, came) {
            (Search::Coherent, Some(came)) => came.search((self.exemplars, &self.all, self.number), exact, x)?,
            (Search::Exact | Search::Coherent | Search::Tree, _) => exact.search(x)?,
            (Search::Reference, _) => self.measure(self.exemplars, &self.falloff).search(x, self.options.complete),
        };
        let mut found = found.ok_or_else(|| self.masked())?;
        // The fast search also counts differences that leave a neighborhood.
        if self.wishes.is_some() || self.options.gradient != 0.0 {
            found.distances = self.distances(texture, &found.places)?;
        }
        Ok(found)
    }

    /// How far the texture itself, its first channels, is from what was found: what is wished for, or followed, is no
    /// part of how well a neighborhood fits. `[Kwatra05 3.1]`
    fn distances(&self, x: &Grid<f64, 2>, found: &[Place]) -> Result<Vec<f64>, Error> {
        let weights = self.exemplars.weights().iter().enumerate();
        let weights = weights.map(|(c, &weight)| if c < self.texture() { weight } else { 0 }).collect();
        let texture = self.exemplars.clone().weighing(weights)?;
        let flat = Falloff::flat(self.level.size);
        let falloff = if self.options.search == Search::Reference { &self.falloff } else { &flat };
        let measure = self.measure(&texture, falloff);
        let of = |i: usize| measure.distance(x, (i, found[i]), f64::INFINITY);
        Ok(par::map_indexed(found.len(), of))
    }

    fn measure<'b>(&'b self, exemplars: &'b Exemplars<2>, falloff: &'b Falloff) -> Measure<'b> {
        Measure { exemplars, all: &self.all, falloff, mu: self.options.gradient, texture: self.texture() }
    }

    fn masked(&self) -> Error {
        Error::Masked { level: self.level }
    }

    fn counts(&self) -> LevelStats {
        LevelStats {
            level: self.level,
            neighborhoods: self.all.len() as u64,
            energy: Vec::new(),
            robust: Vec::new(),
            searched: 0,
            rises: 0,
            settled: false,
        }
    }

    /// Counts and tells an iteration, and shows the last of a level, by the weights of its neighborhoods.
    fn note(&self, counts: &mut LevelStats, found: &Found, last: Option<&Vec<f64>>) {
        let energy = robust::energy(&found.distances, self.options.robust);
        // Sums differ in their last bits.
        let rose = counts.robust.last().is_some_and(|&before| before * (1.0 + 1e-12) < energy);
        counts.rises += u32::from(rose);
        counts.robust.push(energy);
        counts.energy.push(robust::mean(&found.distances));
        counts.searched += found.searched as u64;
        let done = self.steps.before + self.steps.each * counts.energy.len() as u64;
        // Squared grey levels, whole ones.
        let energy = counts.energy.last().map(|&energy| (energy + 0.5) as i64);
        let make = || {
            let map = self.pulls(&found.places, last?).map().ok()?;
            match self.finer {
                Some(finer) => finer(map).ok(),
                None => Some(map),
            }
        };
        let so_far = SoFar::new(&make);
        let so_far = last.map(|_| &so_far as &dyn Render<2>);
        self.run.observer.event(&Event { energy, so_far, ..Event::step("optimizing", done, self.steps.of) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Control, Wanted};
    use crate::testing::{exemplars, output};
    use selvedge_core::{Guidance, Guide, Seed};

    /// A wish for one colour everywhere.
    fn wish(exemplars: &Exemplars<2>, output: Domain<2>, lambda: f32) -> Wishes {
        let features = Grid::try_filled(output, exemplars.channels(), 200).unwrap();
        let weight = Grid::try_filled(output, 1, lambda).unwrap();
        let control = Control { wanted: Some(Wanted { features, weight }), ..Control::default() };
        control.wishes(exemplars, output, None).unwrap().unwrap()
    }

    fn with(case: u64, lambda: f32, search: Search, test: impl FnOnce(&Weaver<'_>)) {
        let mut rng = Seed(case).rng();
        let exemplars = exemplars(&mut rng, [14, 17], true);
        let output = output(&mut rng, 8);
        let wishes = wish(&exemplars, output, lambda);
        let options = Options { complete: None, search, ..Options::default() };
        let run = Run::seeded(case);
        let level = (Level { scale: 1, size: 8 }, 0, Steps { before: 0, each: 1, of: 1 });
        test(&Weaver::new(&options, (&exemplars, output), level, Some(&wishes), &run));
    }

    #[test]
    fn a_wish_weighs_the_same_at_edges_as_in_the_middle() {
        for case in 0..20 {
            with(case, 0.25, Search::Exact, |weaver| {
                let places = assignment::random(weaver.exemplars, &weaver.all, Seed(case)).unwrap();
                let weights = vec![1.0; weaver.all.len()];
                let x = weaver.average((&places, &weights), None).unwrap();
                let (texture, _) = average(weaver.exemplars, &weaver.all, &places, &weights, &weaver.falloff).unwrap();
                for (both, texture) in x.samples().iter().zip(texture.samples()) {
                    assert!((both - (texture + 0.25 * 200.0) / 1.25).abs() < 1e-9, "{case}: {both} of {texture}");
                }
            });
        }
    }
    #[test]
    fn how_well_a_neighborhood_fits_is_told_of_the_texture_without_its_wishes() {
        for (case, kind) in [(0, Search::Exact), (1, Search::Reference), (2, Search::Exact), (3, Search::Reference)] {
            with(case, 2.0, kind, |weaver| {
                let places = assignment::random(weaver.exemplars, &weaver.all, Seed(case)).unwrap();
                let weights = vec![1.0; weaver.all.len()];
                let (x, _) = average(weaver.exemplars, &weaver.all, &places, &weights, &weaver.falloff).unwrap();
                let mut exact = Exact::new(weaver.exemplars, &weaver.all, How::default(), weaver.run.simd);
                let found = weaver.search(&mut exact, &x, None).unwrap();
                let flat = Falloff::flat(8);
                let falloff = if kind == Search::Exact { &flat } else { &weaver.falloff };
                for (i, (&place, &distance)) in found.places.iter().zip(&found.distances).enumerate() {
                    let of = (i, place);
                    let own = weaver.measure(weaver.exemplars, falloff).distance(&x, of, f64::INFINITY);
                    assert!((own - distance).abs() < 1e-9, "{case} {i}: {distance}, and {own} by definition");
                }
            });
        }
    }

    /// A guide of noise, followed in a part of the output.
    fn guidance(rng: &mut selvedge_core::Rng, exemplars: &Exemplars<2>, output: Domain<2>, weight: f64) -> Guidance<2> {
        let mut noise = |domain: Domain<2>| {
            let samples = (0..domain.len()).map(|_| rng.below(256) as u8).collect();
            Grid::from_vec(domain, 1, samples).unwrap()
        };
        let maps: Vec<_> =
            exemplars.sources().iter().map(|source| noise(Domain::open(source.domain().shape))).collect();
        let guide = Guide::new(exemplars, &maps, noise(output)).unwrap();
        let asked = output.positions().map(|[y, x]| x < output.shape[1] / 2 || y < 3).collect();
        Guidance { guide: guide.asking(Grid::from_vec(output, 1, asked).unwrap()).unwrap(), weight }
    }

    #[test]
    fn a_guide_is_followed_where_it_is_asked_for_and_found_elsewhere() {
        for case in 0..12 {
            let mut rng = Seed(case).derive("guide", 0).rng();
            let (exemplars, output) = (exemplars(&mut rng, [14, 17], true), output(&mut rng, 8));
            let weight = [0.5, 1.0, 2.0][case as usize % 3];
            let guidance = guidance(&mut rng, &exemplars, output, weight);
            let both = guidance.guide.beside(&exemplars, weight).unwrap();
            let control = Control { guidance: Some(guidance.clone()), ..Control::default() };
            let wishes = control.wishes(&both, output, None).unwrap();
            let search = [Search::Exact, Search::Coherent][case as usize % 2];
            let (options, run) = (Options { complete: None, search, ..Options::default() }, Run::seeded(case));
            let level = (Level { scale: 1, size: 8 }, 0, Steps { before: 0, each: 1, of: 1 });
            let weaver = Weaver::new(&options, (&both, output), level, wishes.as_ref(), &run);
            let places = assignment::random(&both, &weaver.all, Seed(case)).unwrap();
            let x = weaver.average((&places, &vec![1.0; weaver.all.len()]), None).unwrap();
            let mut exact = Exact::new(&both, &weaver.all, How::default(), run.simd);
            let found = weaver.search(&mut exact, &x, None).unwrap();
            // By the definition: the mean over the texture, and `weight` of that over the guide.
            let guide = &guidance.guide;
            let asked = guide.asked().unwrap();
            let known =
                |at: [u32; 2]| if asked.get(0, at) { f64::from(guide.target().get(0, at)) } else { x.get(2, at) };
            let square = |x: f64, there: u8| {
                let by = (x + 0.5).floor() - f64::from(there);
                by * by
            };
            let score = |number: usize, place: Place| {
                let (mut of_texture, mut of_guide) = (0.0, 0.0);
                for by in Domain::open([8, 8]).positions() {
                    let at = [0, 1].map(|a| (weaver.all.first(number)[a] + by[a]) % output.shape[a]);
                    let from = place.sample(&exemplars, by);
                    for (c, &w) in exemplars.weights().iter().enumerate() {
                        let there = exemplars.sources()[place.source as usize].features.get(c, from);
                        of_texture += f64::from(w) * square(x.get(c, at), there);
                    }
                    let there = guide.exemplars().sources()[place.source as usize].features.get(0, from);
                    of_guide += square(known(at), there);
                }
                of_texture / exemplars.weights().iter().map(|&w| f64::from(w)).sum::<f64>() + weight * of_guide
            };
            for number in 0..weaver.all.len() {
                let offered = exemplars.sources().iter().enumerate().flat_map(|(source, s)| {
                    crate::neighborhoods::places(s, 8).map(move |at| Place { source: source as u32, at })
                });
                let least = offered.map(|place| score(number, place)).fold(f64::INFINITY, f64::min);
                assert!((score(number, found.places[number]) - least).abs() < 1e-6, "{case} {number}");
            }
            // What is asked for is known, whatever was voted for.
            for at in output.positions() {
                assert!(!asked.get(0, at) || x.get(2, at) == known(at), "{case} {at:?}");
            }
        }
    }
}
