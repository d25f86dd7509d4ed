//! Which labels could improve a place: all of them, ranked exactly. `[CMS eq. 8]`

use selvedge_core::{Exemplars, Patch, SampleId, SimdLevel, Window, par, reserve, try_vec};
use selvedge_fft_ssd::{Costs, Errors, Options as SearchOptions, Scratch, SsdSearcher, Template};

use crate::boxes::Taps;
use crate::constraint::{Scale, unit};
use crate::error::Error;
use crate::labelling::Labelling;
use crate::options::Options;

/// What no label has.
const NONE: u64 = u64::MAX;

/// Labels whose least total is kept, so that the next best one is not looked for among all.
const BLOCK: usize = 256;

/// Finds labels. One is made for a run; after the first search of a size no large buffer is allocated.
pub(crate) struct Ranking<'a> {
    exemplars: &'a Exemplars<2>,
    /// `S` against what stands, and each `Q` against its `C`.
    searches: Vec<Search<'a>>,
    half: u32,
    candidates: usize,
    apart: u32,
    /// Of all sources, by sample number.
    totals: Vec<u64>,
    /// The least of each block of totals.
    least: Vec<u64>,
}

struct Search<'a> {
    searcher: SsdSearcher<'a, 2>,
    scale: Scale,
    taps: Taps,
    scratch: Scratch,
    costs: Costs<2>,
    /// The template's features and mask.
    features: Vec<u8>,
    mask: Vec<bool>,
    /// Samples of it that are known, and those that stand for nothing that is asked for: they agree with everything.
    known: u64,
    unasked: u64,
}

impl<'a> Ranking<'a> {
    pub(crate) fn new(
        exemplars: &'a Exemplars<2>,
        labelling: &Labelling<'a>,
        options: &Options,
        simd: SimdLevel,
    ) -> Result<Self, Error> {
        let search = SearchOptions { simd, ..SearchOptions::default() };
        let (half, taps) = (options.neighborhood, u64::from(2 * options.neighborhood + 1).pow(2));
        let of = |searcher, scale, taps| Search {
            searcher,
            scale,
            taps,
            scratch: Scratch::new(),
            costs: Costs::new(),
            features: Vec::new(),
            mask: Vec::new(),
            known: 0,
            unasked: 0,
        };
        let own = Scale::new(unit(exemplars), exemplars.weights(), taps);
        let mut searches = vec![of(SsdSearcher::with_options(exemplars, search)?, own, Taps::around(half, 1))];
        for term in &labelling.terms {
            searches.push(of(SsdSearcher::of_guide(&term.constraint.guide, search)?, term.scale, term.taps));
        }
        let (candidates, apart) = (options.candidates as usize, options.apart);
        let totals = try_vec(exemplars.table().len() as usize, NONE)?;
        let least = try_vec(totals.len().div_ceil(BLOCK), NONE)?;
        Ok(Self { exemplars, searches, half, candidates, apart, totals, least })
    }

    /// The best labels for a place, best first; that which stands there is left out.
    ///
    /// `allowed` says by source whether it may be used.
    pub(crate) fn labels(
        &mut self,
        labelling: &Labelling<'_>,
        allowed: &[bool],
        at: [u32; 2],
    ) -> Result<Vec<Patch<2>>, Error> {
        self.template_of_output(labelling, at)?;
        // What stands nowhere has no colour: it is no missing tap, it does not count.
        self.searches[0].scale = self.searches[0].scale.over(self.searches[0].known);
        for (number, term) in labelling.terms.iter().enumerate() {
            let guide = &term.constraint.guide;
            let asked = guide.asked().map(|a| a.samples());
            let target = guide.target();
            self.searches[number + 1].template(
                at,
                target.domain(),
                guide.weights().len(),
                |place, features, stride| {
                    let known = asked.is_none_or(|a| a[place]);
                    (0..guide.weights().len()).for_each(|c| features[c * stride] = target.plane(c)[place]);
                    known
                },
            )?;
            let reached = term.taps.reached(&Window { start: at.map(|p| p as i32), shape: [1, 1] });
            let search = &mut self.searches[number + 1];
            let inside =
                reached.places(target.domain()).enumerate().filter(|(i, place)| place.is_some() && search.is_tap(*i));
            search.unasked = inside.count() as u64 - search.known;
        }
        for search in &mut self.searches {
            search.run()?;
        }
        self.sum(allowed, labelling)?;
        let standing = labelling.map.ids.get(0, at);
        if standing.is_assigned() {
            self.totals[standing.get() as usize] = NONE;
        }
        Ok(self.best(at))
    }

    fn template_of_output(&mut self, labelling: &Labelling<'_>, at: [u32; 2]) -> Result<(), Error> {
        let (exemplars, ids) = (self.exemplars, labelling.map.ids.plane(0));
        debug_assert_eq!(self.searches[0].taps, Taps::around(self.half, 1));
        self.searches[0].template(at, labelling.map.domain(), exemplars.channels(), |place, features, stride| {
            let Some(source) = exemplars.table().source(ids[place]) else { return false };
            let index = (ids[place].get() - exemplars.table().first(source)) as usize;
            let grid = &exemplars.sources()[source].features;
            (0..exemplars.channels()).for_each(|c| features[c * stride] = grid.plane(c)[index]);
            true
        })
    }

    /// `Imprv` of every sample of every source at the place, [`NONE`] where it is not valid.
    fn sum(&mut self, allowed: &[bool], labelling: &Labelling<'_>) -> Result<(), Error> {
        let uses = &labelling.uses;
        let taps = u64::from(2 * self.half + 1).pow(2);
        for (number, source) in self.exemplars.sources().iter().enumerate() {
            let domain = source.domain();
            let first = self.exemplars.table().first(number) as usize;
            let totals = &mut self.totals[first..first + domain.len()];
            if !allowed[number] {
                totals.fill(NONE);
                continue;
            }
            let valid = source.valid.as_deref().map(|v| v.samples());
            let searches: Vec<&Search<'_>> = self.searches.iter().filter(|s| s.known != 0).collect();
            let wide = domain.shape[1] as usize;
            par::for_rows(totals, wide.max(1), |y, row| {
                row.fill(0);
                searches.iter().for_each(|search| search.add_row(number, domain, y, row));
                if !uses.is_off() {
                    let number = |x: usize| first + y * wide + x;
                    row.iter_mut().enumerate().for_each(|(x, to)| *to += taps * uses.scaled_of(number(x)));
                }
                let masked = |x: usize| valid.is_some_and(|v| !v[y * wide + x]);
                let excluded =
                    |x: usize| masked(x) || !labelling.may_show(SampleId::new((first + y * wide + x) as u32));
                if valid.is_some() || labelling.is_masked {
                    row.iter_mut().enumerate().filter(|(x, _)| excluded(*x)).for_each(|(_, to)| *to = NONE);
                }
            });
        }
        Ok(())
    }

    /// The least, then the least of those apart from it, and so on; of equal ones the first.
    fn best(&mut self, at: [u32; 2]) -> Vec<Patch<2>> {
        let totals = &self.totals;
        par::for_rows(&mut self.least, 64, |i, least| {
            let blocks = totals[i * 64 * BLOCK..].chunks(BLOCK);
            least.iter_mut().zip(blocks).for_each(|(least, block)| *least = least_of(block));
        });
        let mut found = Vec::new();
        while found.len() < self.candidates {
            let least = (0..self.least.len()).min_by_key(|&block| self.least[block]);
            let Some(block) = least.filter(|&block| self.least[block] != NONE) else { break };
            let best = self.totals[block * BLOCK..].iter().position(|&total| total == self.least[block]);
            let best = SampleId::new((block * BLOCK + best.unwrap_or(0)) as u32);
            let Some((source, from)) = self.exemplars.locate(best) else { break };
            found.push(Patch { source, offset: [0, 1].map(|a| at[a] as i32 - from[a] as i32) });
            self.exclude(source, from);
        }
        found
    }

    /// Leaves out what is too near to a sample: as the crow flies, the shorter way around.
    fn exclude(&mut self, source: usize, from: [u32; 2]) {
        let domain = self.exemplars.sources()[source].domain();
        let first = self.exemplars.table().first(source) as usize;
        // No sample is farther than a source is long.
        let reach = self.apart.saturating_sub(1).min(domain.shape[0].max(domain.shape[1])) as i32;
        let disc = Window { start: from.map(|p| p as i32 - reach), shape: [2 * reach as u32 + 1; 2] };
        let mut changed = usize::MAX;
        for (place, at) in disc.places(domain).zip(disc.local().positions()) {
            let square: u64 = at.iter().map(|&p| i64::from(p as i32 - reach).pow(2) as u64).sum();
            if let Some(place) = place.filter(|_| square < u64::from(self.apart.max(1)).pow(2)) {
                self.totals[first + place] = NONE;
                let block = (first + place) / BLOCK;
                if block != changed {
                    self.renew(changed);
                    changed = block;
                }
            }
        }
        self.renew(changed);
    }

    /// The least of a block, if there is such a one.
    fn renew(&mut self, block: usize) {
        if let Some(least) = self.least.get_mut(block) {
            let end = self.totals.len().min((block + 1) * BLOCK);
            *least = least_of(&self.totals[block * BLOCK..end]);
        }
    }
}

fn least_of(totals: &[u64]) -> u64 {
    totals.iter().fold(NONE, |least, &total| least.min(total))
}

impl Search<'_> {
    /// What is searched for, around a place; `of` writes a sample's features and answers whether it is known.
    fn template(
        &mut self,
        at: [u32; 2],
        output: selvedge_core::Domain<2>,
        channels: usize,
        of: impl Fn(usize, &mut [u8], usize) -> bool,
    ) -> Result<(), Error> {
        let window = self.taps.reached(&Window { start: at.map(|p| p as i32), shape: [1, 1] });
        let len = window.len();
        self.features.clear();
        self.mask.clear();
        reserve(&mut self.features, len * channels)?;
        reserve(&mut self.mask, len)?;
        self.features.resize(len * channels, 0);
        self.mask.resize(len, false);
        for (i, place) in window.places(output).enumerate() {
            if let Some(place) = place.filter(|_| self.is_tap(i)) {
                self.mask[i] = of(place, &mut self.features[i..], len);
            }
        }
        self.known = self.mask.iter().filter(|&&known| known).count() as u64;
        Ok(())
    }

    /// Whether a sample of the template is a tap, not one between.
    fn is_tap(&self, i: usize) -> bool {
        let (wide, ratio) = ((self.taps.count[1] - 1) * self.taps.ratio + 1, self.taps.ratio);
        let (y, x) = (i as u32 / wide, i as u32 % wide);
        y.is_multiple_of(ratio) && x.is_multiple_of(ratio)
    }

    /// Compares it wherever its middle stands on a valid sample.
    fn run(&mut self) -> Result<(), Error> {
        if self.known == 0 {
            return Ok(());
        }
        let side = (self.taps.count[0] - 1) * self.taps.ratio + 1;
        let template = Template::new([side; 2], &self.features).masked(&self.mask);
        let middle = [side / 2; 2];
        Ok(self.searcher.search_part(&template, middle, [1, 1], 1, &mut self.scratch, &mut self.costs)?)
    }

    /// Adds the errors at a row of a source's samples; where nothing was compared, nothing.
    fn add_row(&self, number: usize, domain: selvedge_core::Domain<2>, y: usize, row: &mut [u64]) {
        let found = self.costs.sources()[number];
        let half = (self.taps.count[0] as i64 - 1) * i64::from(self.taps.ratio) / 2;
        let place = |p: usize, axis: usize| {
            let (p, side) = (p as i64 - half - i64::from(found.first[axis]), i64::from(domain.shape[axis]));
            (if domain.periodic[axis] { p.rem_euclid(side) } else { p }) as usize
        };
        let (start, x) = (place(y, 0) * found.shape[1] as usize, place(0, 1));
        // Of a source that goes around, what comes before the first place is found behind the last one.
        let (ahead, around) = row.split_at_mut(row.len() - x);
        for (to, from) in [(ahead, start + x), (around, start)] {
            let counts = self.costs.counts(number).map(|c| &c[from..from + to.len()]);
            match self.costs.errors(number) {
                Errors::Narrow(errors) => self.add(to, &errors[from..], counts, u32::MAX),
                Errors::Wide(errors) => self.add(to, &errors[from..], counts, u64::MAX),
            }
        }
    }

    /// Adds errors, of which one means that nothing was compared.
    fn add<E: Copy + PartialEq + Into<u64>>(&self, to: &mut [u64], errors: &[E], counts: Option<&[u32]>, none: E) {
        let error = |e: E| if e == none { 0 } else { e.into() };
        match counts {
            None => {
                let compared = self.known + self.unasked;
                to.iter_mut().zip(errors).for_each(|(to, &e)| {
                    *to = to.saturating_add(self.scale.of(error(e), compared));
                });
            }
            Some(counts) => to.iter_mut().zip(errors).zip(counts).for_each(|((to, &e), &c)| {
                *to = to.saturating_add(self.scale.of(error(e), u64::from(c) + self.unasked));
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};

    #[test]
    fn the_best_labels_lie_apart() {
        for case in 0..120 {
            let mut rng = Seed(case).rng();
            let shape = [1 + rng.below(13), 1 + rng.below(13)];
            let domain = Domain { shape, periodic: [case % 2 == 0, case % 3 == 0] };
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let source = Source { features: Grid::try_filled(domain, 1, 0).unwrap(), valid: None, origin };
            let exemplars = Exemplars::from_sources(vec![source], vec![1]).unwrap();
            let totals: Vec<u64> =
                (0..domain.len()).map(|_| if rng.below(9) == 0 { NONE } else { rng.below(50).into() }).collect();
            // 3 and 4 along the axes are just 5.
            let (apart, candidates) = ([1_u32, 3, 5, 5][rng.below(4) as usize], 6);
            let far = |p: usize, q: usize| {
                let [p, q] = [p, q].map(|p| domain.position(p));
                let squares = [0, 1].map(|a| {
                    let d = p[a].abs_diff(q[a]);
                    (if domain.periodic[a] { d.min(shape[a] - d) } else { d }).pow(2)
                });
                apart.pow(2) <= squares[0] + squares[1]
            };
            let mut expected: Vec<usize> = Vec::new();
            for _ in 0..candidates {
                let free = |&p: &usize| totals[p] != NONE && expected.iter().all(|&q| far(p, q));
                let best = (0..totals.len()).filter(free).min_by_key(|&p| (totals[p], p));
                expected.extend(best);
            }
            let least = vec![0; totals.len().div_ceil(BLOCK)];
            let mut ranking =
                Ranking { exemplars: &exemplars, searches: Vec::new(), half: 0, candidates, apart, totals, least };
            let found: Vec<usize> =
                ranking.best([0, 0]).iter().map(|p| domain.index(p.offset.map(|o| o.unsigned_abs()))).collect();
            assert_eq!(found, expected, "{domain:?} {apart}");
        }
    }
}
