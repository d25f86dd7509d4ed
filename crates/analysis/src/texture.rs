//! What kind of texture it is, all in one.

use selvedge_core::{Exemplars, Grid};
use selvedge_fft_ssd::Error;

use crate::feature_size::{feature_size_of, lost_likeness};
use crate::lattice::Lattice;
use crate::lines::{Lines, share};
use crate::near::Near;
use crate::periods::Strengths;
use crate::picture::Picture;

/// What kind of texture an exemplar is. Each asks for something else of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// It comes again in two directions: patches must be laid on its lattice.
    Lattice,
    /// Lines of writing: rows that must be carried on, of signs that must stay whole.
    Text,
    /// Straight lines, planks, courses of bricks: they must be carried on.
    Lines,
    /// Bodies that must stay whole, in no order.
    Objects,
    /// Grain without bodies.
    Stochastic,
    /// A picture of few large things: hardly a texture.
    Scene,
}

/// What one exemplar is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// What it is taken for.
    pub kind: Kind,
    /// Height and width in samples.
    pub shape: [u32; 2],
    /// See [`feature_size`](crate::feature_size()).
    pub feature_size: u32,
    /// The clearest lattice, however weak; see [`Lattice::strength`].
    pub lattice: Option<Lattice>,
    /// Lines along the axes.
    pub lines: Lines,
    /// Thousandths of the variance that lie in means over a third of the lesser side: uneven light, or things as large.
    pub shade: u32,
    /// How unlike neighbouring cells of a 200th of the longer side are, in thousandths: below 250 bodies are smooth.
    pub grain: u32,
    /// The distance at which likeness is lost, in thousandths of the lesser side.
    pub body: u32,
    /// Skewness of the cells' brightness, in thousandths: far above 0 a few bright places lie on a darker ground.
    pub skew: i32,
}

/// Shares, in thousandths, that tell kinds apart: chosen so that a reader who had named 53 textures before is agreed
/// with most often (`docs/defaults.md`, "Kinds").
///
/// Rows of text, and lines along them, by their share of the variance.
const WRITTEN: u32 = 200;
const LINED: u32 = 120;
/// So much of the variance in one direction is no lattice, however it repeats itself: planks.
const MOSTLY_LINES: u32 = 400;
/// Along both axes so much of it are the joints of tiles, which are one: of 77 textures none else has more than 160.
const LINED_BOTH_WAYS: u32 = 200;
/// Differences along the lines of more than that share: signs.
const SIGNS: u32 = 524;
/// Of less than this one: lines.
const STRAIGHT: u32 = 286;
/// From this strength on a lattice is what the texture is made of;
const REGULAR: u32 = 650;
/// from this one on patches are better laid by it.
const ORDERLY: u32 = 400;
/// Means over a third of the side with more of the variance than this are uneven light.
const UNEVEN: u32 = 150;
/// Bodies of more than a tenth of the lesser side, lit unevenly, are a scene: few of them are in it.
const FEW: u32 = 100;
/// Where neighbours differ by less than this share of the variance, samples belong to bodies.
const SMOOTH: u32 = 250;
/// What is skewed more than this shows glints, veins or caustics, however smooth: bodies fill a picture, and are parted
/// by what is darker. Of fifteen textures of bodies none is above 700, of four smooth ones without any none below 980.
const GLINTS: i32 = 850;

impl Texture {
    /// Looks at a texture; of clips at the frame in the middle.
    ///
    /// All of it is measured on means over cells of a 200th of the longer side, so that it takes milliseconds: the
    /// shade is what means over a third of the lesser side show, lines and lattice are looked for in what is left
    /// without it.
    ///
    /// # Errors
    /// Those of [`periods`](crate::periods()).
    pub fn of<const D: usize>(
        features: &Grid<u8, D>,
        valid: Option<&Grid<bool, D>>,
        weights: &[u8],
    ) -> Result<Self, Error> {
        let feature_size = feature_size_of(features, valid, weights)?;
        let picture = Picture::of(features, valid)?;
        let lesser = picture.shape()[0].min(picture.shape()[1]);
        let low = picture.shade(lesser / 6)?;
        let even = picture.without(&low)?;
        let fine = picture.without(&picture.shade((lesser / 16).max(2))?)?;
        let lines = Lines::of(&fine, weights);
        let strengths =
            Strengths::within(&even.features()?, Some(&even.known), weights, Lattice::reach(even.domain()))?;
        let lattice = strengths.as_ref().map(|s| Lattice::of(s, &even)).transpose()?.flatten();
        // Shade draws likeness towards the short ways: where cells are samples, what was found without it is as fine.
        let lattice = lattice.map(|l| match Near::new(features, valid, weights) {
            Some(near) if 1 < picture.side => l.refined(&near, picture.side),
            _ => l,
        });
        let near = |v| strengths.as_ref().and_then(|s| s.at(v)).unwrap_or(1000);
        let body = strengths.as_ref().map_or(0, lost_likeness);
        let mut texture = Self {
            kind: Kind::Stochastic,
            shape: picture.shape().map(|n| n * picture.side),
            feature_size,
            lattice,
            lines,
            shade: share(low.variance(weights), picture.variance(weights)),
            grain: (1000 - (near([0, 1]) + near([1, 0])) / 2).max(0) as u32,
            body: body * 1000 / lesser.max(1),
            skew: picture.skew(weights),
        };
        // What is all alike, or one row, has no structure that could be told.
        if 0 < picture.variance(weights) && 1 < lesser {
            texture.kind = texture.judged();
        }
        Ok(texture)
    }

    /// The first source of each exemplar.
    ///
    /// # Errors
    /// Those of [`of`](Self::of).
    pub fn of_each<const D: usize>(exemplars: &Exemplars<D>) -> Result<Vec<Self>, Error> {
        exemplars.firsts().map(|s| Self::of(&s.features, s.valid.as_deref(), exemplars.weights())).collect()
    }

    /// True where patches are better laid by how the whole of them agrees than by their surroundings alone: on a
    /// lattice, even a weak one, and on lines of text.
    pub fn is_orderly(&self) -> bool {
        self.kind == Kind::Text || self.lattice.is_some_and(|l| ORDERLY <= l.strength)
    }

    /// The lattice that outputs have to close, where there is one that patches are laid by.
    pub fn order(&self) -> Option<Lattice> {
        self.lattice.filter(|_| self.is_orderly())
    }

    /// True where light differs from place to place.
    pub fn is_uneven(&self) -> bool {
        UNEVEN <= self.shade
    }

    fn judged(&self) -> Kind {
        let (share, along) = self.lines.strongest();
        match self.lattice {
            _ if WRITTEN <= share && SIGNS <= along => Kind::Text,
            Some(l) if REGULAR <= l.strength && (share < MOSTLY_LINES || LINED_BOTH_WAYS <= self.lines.lesser()) => {
                Kind::Lattice
            }
            _ if LINED <= share || self.lines.upright.min(1000 - self.lines.upright) < STRAIGHT => Kind::Lines,
            _ if self.is_uneven() && FEW <= self.body => Kind::Scene,
            _ if !self.is_uneven() && self.grain <= SMOOTH && self.skew <= GLINTS => Kind::Objects,
            _ => Kind::Stochastic,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Seed};

    fn of(shape: [u32; 2], at: impl Fn(i64, i64) -> u8) -> Texture {
        let domain = Domain::open(shape);
        let samples = domain.positions().map(|[y, x]| at(y.into(), x.into())).collect();
        Texture::of(&Grid::from_vec(domain, 1, samples).unwrap(), None, &[1]).unwrap()
    }

    /// Noise from -1000 to 1000 that keeps its value over cells.
    fn noise(y: i64, x: i64, seed: u64) -> i64 {
        Seed(seed).derive("noise", (y as u64) << 32 | x as u64 & 0xffff_ffff).rng().below(2001) as i64 - 1000
    }

    fn disc(y: i64, x: i64, radius: i64) -> bool {
        y * y + x * x < radius * radius
    }

    /// Discs of a radius about places that are moved at random out of the order of a grid.
    fn bodies(y: i64, x: i64, step: i64, radius: i64) -> u8 {
        let near = |dy: i64, dx: i64| {
            let (cy, cx) = (y.div_euclid(step) + dy, x.div_euclid(step) + dx);
            let moved = |c: i64, seed| c * step + step / 2 + noise(cy, cx, seed) * step / 2200;
            disc(y - moved(cy, 1), x - moved(cx, 2), radius).then(|| 130 + (noise(cy, cx, 3) / 20) as i32)
        };
        let found = (-1..=1).flat_map(|dy| (-1..=1).filter_map(move |dx| near(dy, dx))).next();
        found.unwrap_or(20) as u8
    }

    #[test]
    fn what_shows_nothing_is_of_no_kind() {
        let flat = [of([64, 64], |_, _| 90), of([1, 1], |_, _| 90), of([1, 64], |_, x| (4 * x) as u8)];
        assert_eq!(flat.map(|t| t.kind), [Kind::Stochastic; 3]);
    }

    #[test]
    fn kinds_are_told_apart() {
        let lattice = of([120, 150], |y, x| if disc(y % 24 - 12, x % 30 - 15, 9) { 220 } else { 40 });
        assert_eq!((lattice.kind, lattice.is_orderly()), (Kind::Lattice, true));
        let planks = of([150, 150], |y, x| (120 + noise(y / 25, 0, 4) / 12 + noise(y, x, 5) / 60) as u8);
        assert_eq!(planks.kind, Kind::Lines);
        let signs = |y: i64, x: i64| if y % 14 < 8 && 0 < noise(y / 14 * 8 + y % 14 / 4, x / 2, 6) { 30 } else { 230 };
        let text = of([160, 160], signs);
        assert_eq!((text.kind, text.is_orderly()), (Kind::Text, true), "{text:?}");
        let grain = of([150, 150], |y, x| (128 + noise(y, x, 7) / 9) as u8);
        assert_eq!((grain.kind, grain.is_orderly()), (Kind::Stochastic, false));
        let stones = of([180, 180], |y, x| bodies(y, x, 22, 9));
        assert_eq!((stones.kind, stones.is_uneven()), (Kind::Objects, false), "{stones:?}");
        // The same bodies, few and bright on a dark ground that is not empty: flakes, or light on water.
        let flakes =
            of(
                [180, 180],
                |y, x| {
                    if 20 < bodies(y, x, 45, 6) { 220 } else { (60 + noise(y / 12, x / 12, 2) / 60) as u8 }
                },
            );
        assert!(flakes.grain < SMOOTH && GLINTS < flakes.skew && flakes.kind == Kind::Stochastic, "{flakes:?}");
        let scene = of([120, 120], |y, x| if disc(y - 50, x - 65, 42) { 120 } else { 240 });
        assert_eq!(scene.kind, Kind::Scene, "{scene:?}");
    }

    #[test]
    fn light_is_taken_away_before_a_lattice_is_looked_for() {
        let lit = |y: i64, x: i64| (if disc(y % 24 - 12, x % 30 - 15, 9) { 90 } else { 40 }) + x as u8;
        let texture = of([120, 150], lit);
        assert!(texture.is_uneven() && texture.kind == Kind::Lattice, "{texture:?}");
        let lattice = texture.lattice.unwrap();
        assert_eq!([0, 1].map(|axis| lattice.closing(axis, 100)), [96, 90]);
    }

    #[test]
    fn lattices_are_found_by_samples_beyond_half_of_the_exemplar_and_askew() {
        // A board of which the exemplar holds little more than one period.
        let board = of([100, 100], |y, x| if (y / 35 + x / 35) % 2 == 0 { 220 } else { 40 });
        let lattice = board.lattice.unwrap();
        assert!(board.kind == Kind::Lattice && lattice.vectors == [[35, -35], [35, 35]], "{board:?}");
        assert_eq!(lattice.along, [Some((70, 1)), Some((70, 1))]);
        // Tiles are nearly all joints, along both axes; planks are along one.
        let joint = |v: i64| v % 24 < 6;
        let tiles = of([144, 144], |y, x| if joint(y) || joint(x) { 30 } else { 200 });
        assert!(400 < tiles.lines.rows && 400 < tiles.lines.columns && tiles.kind == Kind::Lattice, "{tiles:?}");
        assert_eq!(of([144, 144], |y, x| if joint(y) { 30 } else { 200 + (x % 2) as u8 }).kind, Kind::Lines);
        // Rows moved by half, in a picture whose cells are three samples.
        let rows = of([500, 600], |y, x| if disc(y % 50 - 25, (x + y / 50 * 35) % 70 - 35, 18) { 220 } else { 40 });
        let lattice = rows.lattice.unwrap();
        assert_eq!((lattice.vectors, rows.kind), ([[50, -35], [50, 35]], Kind::Lattice), "{rows:?}");
        assert_eq!([0, 1].map(|axis| lattice.closing(axis, 333)), [300, 350]);
        for length in 1..400 {
            for (axis, period) in [100, 70].into_iter().enumerate() {
                let most = if length < period { length } else { length / period * period };
                assert_eq!(lattice.closing_within(axis, length), most, "{axis}, {length}");
            }
        }
    }

    #[test]
    fn a_running_bond_closes_at_every_second_course() {
        // Courses of 17.5 samples, each moved by half a brick, bricks in shades of their own.
        let brick = |y: i64, x: i64| {
            let course = 2 * y / 35;
            let across = x + course % 2 * 22;
            let mortar = 2 * y % 35 < 6 || across % 44 < 3;
            if mortar { 220 } else { (90 + noise(course, across / 44, 8) / 30) as u8 }
        };
        let lattice = of([192, 200], brick).lattice.unwrap();
        let [down, across] = [0, 1].map(|axis| lattice.closing(axis, 576));
        assert_eq!((down, across), (560, 572), "{lattice:?}");
        assert!(lattice.along[0].is_some_and(|(samples, times)| samples == times * 35), "{lattice:?}");
    }

    #[test]
    fn anything_is_of_some_kind() {
        assert_eq!(of([40, 50], |_, _| 7).lattice, None);
        for shape in [[1, 1], [1, 50], [3, 2], [9, 300]] {
            of(shape, |y, x| (y * 91 + x * 57) as u8);
        }
        let clip = Domain::open([5, 30, 30]);
        let samples = clip.positions().map(|[_, y, x]| if (y / 5 + x / 5) % 2 == 0 { 220 } else { 40 }).collect();
        let clip = Texture::of(&Grid::from_vec(clip, 1, samples).unwrap(), None, &[1]).unwrap();
        assert_eq!((clip.kind, clip.shape), (Kind::Lattice, [30, 30]));
        let mut holed = Grid::from_vec(Domain::open([60, 60]), 1, vec![9_u8; 3600]).unwrap();
        let mut valid = Grid::try_filled(holed.domain(), 1, true).unwrap();
        for [y, x] in holed.domain().positions() {
            let hole = y < 20 && x < 20;
            holed.set(0, [y, x], if hole { 255 } else { u8::from((y / 6 + x / 6) % 2 == 0) * 90 });
            valid.set(0, [y, x], !hole);
        }
        assert_eq!(Texture::of(&holed, Some(&valid), &[2]).unwrap().kind, Kind::Lattice);
    }
}
