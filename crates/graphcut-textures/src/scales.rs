//! Texture that is larger here than there, from sources at several scales. `[Kwatra03 6A]`

use selvedge_core::{Domain, Error as CoreError, Grid};

use crate::error::Error;

/// Scales that a field may ask for. Beyond them a sample of one source covers more than a whole region of another, and
/// sources grow with the square of the scale: at 16 an exemplar of 256 px has 16 million samples.
const LEAST: f64 = 1.0 / 16.0;
const MOST: f64 = 16.0;

/// A place takes sources whose scale is up to so many steps from its own: neighbouring scales overlap by half a step,
/// so that there is room for a seam between them. With half a step they would only touch, and a seam could not choose
/// where to run.
const OVERLAP: f64 = 0.75;

/// Scales that a field of scales is made of: a geometric series through 1, as far as a range goes.
///
/// ```
/// use selvedge_core::Domain;
/// use selvedge_graphcut_textures::Scales;
/// # fn main() -> Result<(), selvedge_graphcut_textures::Error> {
/// let scales = Scales::new([0.5, 2.0], 2.0)?;
/// assert_eq!(scales.levels(), [1.0, 0.5, 2.0]);
/// // From half the size at the left to twice at the right; sources 0, 1 and 2 have these scales.
/// let field = scales.field(Domain::open([1, 5]), |[_, x]| 0.5 * f64::from(1 << x).sqrt(), &[0b001, 0b010, 0b100])?;
/// assert_eq!(field.plane(0), [0b010, 0b011, 0b001, 0b101, 0b100]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Scales {
    step: f64,
    levels: Vec<f64>,
}

impl Scales {
    /// What sources can be magnified by: the least and the most.
    pub const LIMITS: [f64; 2] = [LEAST, MOST];

    /// The scales from `low` to `high` whose neighbours differ by a factor of `step`.
    ///
    /// # Errors
    /// [`Range`](selvedge_core::Error::Range) unless `1/16 <= low <= high <= 16` and `1.01 <= step <= 4`.
    pub fn new([low, high]: [f64; 2], step: f64) -> Result<Self, Error> {
        if !(1.01..=4.0).contains(&step) {
            return Err(CoreError::range("scale_step", step, "1.01 to 4").into());
        }
        for (value, least) in [(low, LEAST), (high, low.max(LEAST))] {
            if !(least..=MOST).contains(&value) {
                return Err(CoreError::range("scale_range", value, "1/16 to 16, the lower first").into());
            }
        }
        let exponent = |scale: f64| (libm::log(scale) / libm::log(step)).round() as i32;
        let mut exponents: Vec<i32> = (exponent(low)..=exponent(high)).collect();
        exponents.sort_by_key(|e| (e.abs(), *e));
        let level = |e: &i32| libm::pow(step, f64::from(*e)).clamp(LEAST, MOST);
        Ok(Self { step, levels: exponents.iter().map(level).collect() })
    }

    /// The magnifications of sources, that nearest to 1 first.
    pub fn levels(&self) -> &[f64] {
        &self.levels
    }

    /// By position the sources that may show there ([`Start::sources`](crate::Start::sources)), from the scale wanted
    /// `at` each and the sources `of` each level: all levels within three quarters of a step, or the nearest.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    ///
    /// # Panics
    /// If there are not as many sets of sources as levels.
    pub fn field<const D: usize>(
        &self,
        output: Domain<D>,
        at: impl Fn([u32; D]) -> f64,
        of: &[u64],
    ) -> Result<Grid<u64, D>, Error> {
        assert_eq!(of.len(), self.levels.len(), "each level has its sources");
        let place = |scale: f64| libm::log(scale) / libm::log(self.step);
        let places: Vec<f64> = self.levels.iter().map(|level| place(*level)).collect();
        let mut field = Grid::try_filled(output, 1, 0_u64)?;
        for (i, bits) in field.plane_mut(0).iter_mut().enumerate() {
            let wanted = place(at(output.position(i)));
            let nearest = places.iter().map(|p| (p - wanted).abs()).fold(f64::INFINITY, f64::min);
            let near = |p: &f64| (p - wanted).abs() <= OVERLAP.max(nearest);
            *bits = of.iter().zip(&places).filter(|(_, p)| near(p)).fold(0, |bits, (of, _)| bits | of);
        }
        Ok(field)
    }
}

/// The scale of a texture at each place of an output.
#[derive(Clone, Copy, Debug)]
pub enum WantedScale<L> {
    /// From side to side in equal steps, given at the top, the bottom, the left and the right; what goes down times
    /// what goes across.
    Sides([f64; 4]),
    /// A picture that is stretched over the output.
    Picture {
        /// Its height and width.
        shape: [u32; 2],
        /// How light each of its samples is, from 0 to 1.
        light: L,
        /// The scales that black and white stand for.
        range: [f64; 2],
    },
}

impl<L> WantedScale<L> {
    /// The least and the greatest scale.
    pub fn range(&self) -> [f64; 2] {
        match self {
            Self::Sides([top, bottom, left, right]) => {
                let corners = [top * left, top * right, bottom * left, bottom * right];
                [corners.into_iter().fold(f64::INFINITY, f64::min), corners.into_iter().fold(0.0, f64::max)]
            }
            Self::Picture { range, .. } => *range,
        }
    }

    /// The axis along which an output cannot be periodic, since the scale jumps where it goes around. A picture is
    /// taken to go around as it is.
    pub fn torn(&self, periodic: [bool; 2]) -> Option<usize> {
        let Self::Sides(sides) = self else { return None };
        (0..2).find(|axis| periodic[*axis] && sides[2 * axis] != sides[2 * axis + 1])
    }
}

impl<L: Fn([u32; 2]) -> f64> WantedScale<L> {
    /// The scale at a position of the output.
    pub fn at(&self, output: Domain<2>, at: [u32; 2]) -> f64 {
        let part = [0, 1].map(|axis: usize| (f64::from(at[axis]) + 0.5) / f64::from(output.shape[axis]));
        match self {
            Self::Sides([top, bottom, left, right]) => {
                between(*top, *bottom, part[0]) * between(*left, *right, part[1])
            }
            Self::Picture { shape, light, range: [low, high] } => between(*low, *high, stretched(*shape, light, part)),
        }
    }
}

fn between(low: f64, high: f64, part: f64) -> f64 {
    low + (high - low) * part
}

/// How light a picture is at a place, both in 0..1, between the samples around it.
fn stretched([h, w]: [u32; 2], light: impl Fn([u32; 2]) -> f64, part: [f64; 2]) -> f64 {
    let along = |part: f64, side: u32| {
        let place = (part * f64::from(side) - 0.5).clamp(0.0, f64::from(side - 1));
        let first = place as u32;
        (first, (first + 1).min(side - 1), place - f64::from(first))
    };
    let ((top, bottom, down), (left, right, across)) = (along(part[0], h), along(part[1], w));
    let row = |y: u32| between(light([y, left]), light([y, right]), across);
    between(row(top), row(bottom), down)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_go_through_one_and_cover_the_range() {
        assert_eq!(Scales::new([1.0, 1.0], 1.2).unwrap().levels(), [1.0]);
        for (low, high) in [(0.0625, 16.0), (0.3, 0.4), (1.1, 3.7)] {
            let scales = Scales::new([low, high], 1.2).unwrap();
            for scale in [low, (low * high).sqrt(), high] {
                let off = scales.levels().iter().map(|l| (l / scale).max(scale / l)).fold(f64::INFINITY, f64::min);
                assert!(off <= 1.2_f64.sqrt() + 1e-9, "{scale} of {:?}", scales.levels());
            }
        }
    }

    #[test]
    fn every_place_has_a_source_and_neighbouring_scales_share_half_a_step() {
        let scales = Scales::new([0.25, 4.0], 2.0).unwrap();
        let output = Domain::open([401]);
        let bits: Vec<u64> = (0..5).map(|level| 1 << level).collect();
        // A hundredth of a step a sample.
        let field = scales.field(output, |[x]| libm::pow(2.0, f64::from(x) / 100.0 - 2.0), &bits).unwrap();
        let shared = field.plane(0).iter().filter(|bits| bits.count_ones() == 2).count();
        assert!(field.plane(0).iter().all(|bits| (1..=2).contains(&bits.count_ones())));
        assert!((4 * 49..=4 * 53).contains(&shared), "{shared} of 400 samples");
        // Far from all of them the nearest has to do.
        let far = Scales::new([1.0, 1.0], 1.1).unwrap();
        assert_eq!(far.field(Domain::open([1]), |_| 9.0, &[0b100]).unwrap().plane(0), [0b100]);
    }

    #[test]
    fn pictures_are_stretched_and_sides_multiplied() {
        let ramp = |[_, x]: [u32; 2]| f64::from(x);
        let at = |x| stretched([1, 2], ramp, [0.3, x]);
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(at), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(stretched([1, 1], |_| 0.2, [0.9, 0.1]), 0.2);
        let (output, range) = (Domain::open([1, 4]), [1.0, 3.0]);
        let picture = WantedScale::Picture { shape: [1, 2], light: ramp, range };
        assert_eq!([0, 1, 2, 3].map(|x| picture.at(output, [0, x])), [1.0, 1.5, 2.5, 3.0]);
        let sides: WantedScale<fn([u32; 2]) -> f64> = WantedScale::Sides([1.0, 2.0, 0.5, 1.5]);
        assert_eq!(sides.at(Domain::open([2, 2]), [1, 0]), 1.75 * 0.75);
        assert_eq!((sides.range(), picture.range()), ([0.5, 3.0], range));
        let torn = [[false, false], [true, false], [false, true], [true, true]].map(|axes| sides.torn(axes));
        assert_eq!(torn, [None, Some(0), Some(1), Some(0)]);
        assert_eq!(WantedScale::<fn([u32; 2]) -> f64>::Sides([1.0, 2.0, 3.0, 3.0]).torn([false, true]), None);
    }

    #[test]
    fn wrong_ranges_are_refused() {
        for (range, step) in
            [([2.0, 1.0], 1.2), ([0.0, 1.0], 1.2), ([1.0, 17.0], 1.2), ([f64::NAN, 1.0], 1.2), ([1.0, 2.0], 1.0)]
        {
            assert!(matches!(Scales::new(range, step), Err(Error::Core(CoreError::Range { .. }))), "{range:?} {step}");
        }
    }
}
