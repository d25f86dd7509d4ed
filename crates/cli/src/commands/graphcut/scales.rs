//! `--scale-field`: texture that is larger here than there, for perspective. `[Kwatra03 6A]`

use std::path::PathBuf;
use std::str::FromStr;

use selvedge_core::{Domain, Grid, Plane};
use selvedge_graphcut_textures::{self as graphcut, WantedScale};

use crate::failure::Failure;
use crate::wrong::Wrong;

/// What textures can be magnified by.
const LIMITS: Range = Range { low: graphcut::Scales::LIMITS[0], high: graphcut::Scales::LIMITS[1] };
/// Sides of an output, in the order of [`Field::Sides`].
const SIDES: [&str; 4] = ["top", "bottom", "left", "right"];

/// Scales from side to side.
type Sides = WantedScale<fn([u32; 2]) -> f64>;

/// The scale of the texture at each place of the output.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Field {
    /// From side to side in equal steps; what goes down times what goes across.
    Sides([f64; 4]),
    /// A picture, stretched over the output.
    Picture(PathBuf),
}

/// The least and the greatest scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
}

/// A scale, or a step between two.
pub(super) fn scale(text: &str) -> Result<f64, Wrong> {
    let scale = text.parse().ok().filter(|s| (LIMITS.low..=LIMITS.high).contains(s));
    let remedy = format!("write a number from {} to {}", LIMITS.low, LIMITS.high);
    scale.ok_or_else(|| Wrong::new(format!("'{text}' is no scale"), remedy))
}

/// A factor between neighbouring scales.
pub(super) fn step(text: &str) -> Result<f64, Wrong> {
    let step = text.parse().ok().filter(|s| (1.01..=4.0).contains(s));
    step.ok_or_else(|| Wrong::new(format!("'{text}' is no step between scales"), "write a number from 1.01 to 4"))
}

impl FromStr for Range {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let (low, high) =
            text.split_once("..").ok_or_else(|| Wrong::new(format!("'{text}' is no range"), "write 0.5..2"))?;
        let (low, high) = (scale(low)?, scale(high)?);
        let backwards = || Wrong::new(format!("'{text}' runs backwards"), format!("write {high}..{low}"));
        if low <= high { Ok(Self { low, high }) } else { Err(backwards()) }
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}..{}", self.low, self.high)
    }
}

impl FromStr for Field {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let side =
            |part: &str| SIDES.iter().position(|side| part.split_once('=').is_some_and(|(name, _)| name == *side));
        let Some(places) = text.split(',').map(side).collect::<Option<Vec<usize>>>() else {
            return Ok(Self::Picture(text.into()));
        };
        let mut sides = [None; 4];
        for (place, part) in places.into_iter().zip(text.split(',')) {
            let value = part.split_once('=').map_or("", |(_, value)| value);
            if sides[place].replace(scale(value)?).is_some() {
                return Err(Wrong::new(format!("'{text}' names a side twice"), "name each once"));
            }
        }
        let field = Self::Sides(sides.map(|s| s.unwrap_or(1.0)));
        let Range { low, high } = field.range(None).expect("sides have a range");
        if low < LIMITS.low || LIMITS.high < high {
            let remedy = format!("stay from {} to {}", LIMITS.low, LIMITS.high);
            return Err(Wrong::new(format!("'{text}' makes scales from {low} to {high}"), remedy));
        }
        Ok(field)
    }
}

impl std::fmt::Display for Field {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sides(sides) => {
                let words: Vec<String> = SIDES.iter().zip(sides).map(|(side, s)| format!("{side}={s}")).collect();
                f.write_str(&words.join(","))
            }
            Self::Picture(path) => f.write_str(&selvedge_io::display_name(path)),
        }
    }
}

impl Field {
    /// The file that is read, if any.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::Picture(path) => Some(path),
            Self::Sides(_) => None,
        }
    }

    /// Least and greatest scale; `typed` is what black and white of a picture stand for.
    fn range(&self, typed: Option<Range>) -> Option<Range> {
        let Self::Sides(sides) = self else { return typed };
        let [low, high] = Sides::Sides(*sides).range();
        Some(Range { low, high })
    }
}

/// `--scale-field` with `--scale-range` and `--scale-step`, understood.
#[derive(Clone, Debug)]
pub(super) struct Scales {
    field: Field,
    range: Range,
    series: graphcut::Scales,
}

impl Scales {
    pub(super) fn new(field: Field, typed: Option<Range>, step: f64) -> Result<Self, Failure> {
        let range = match (&field, typed) {
            (Field::Picture(path), None) => {
                let what = "which scales do black and white stand for";
                return Err(Failure::new(2, what).about(path).remedy("give --scale-range, such as 0.5..2"));
            }
            (Field::Sides(_), Some(range)) => {
                let what = format!("--scale-range {range} is for pictures, and --scale-field names sides");
                return Err(Failure::new(2, what).remedy("leave --scale-range out"));
            }
            _ => field.range(typed).expect("pictures come with a range"),
        };
        let series = graphcut::Scales::new([range.low, range.high], step)?;
        Ok(Self { field, range, series })
    }

    /// The magnifications of sources: a geometric series through 1, that nearest to 1 first.
    pub(super) fn levels(&self) -> &[f64] {
        self.series.levels()
    }

    /// Refuses a field that jumps where the output tiles.
    fn check(&self, periodic: [bool; 2]) -> Result<(), Failure> {
        let Field::Sides(sides) = &self.field else { return Ok(()) };
        let Some(axis) = Sides::Sides(*sides).torn(periodic) else { return Ok(()) };
        let ([low, high], [one, other]) = ([0, 1].map(|i| sides[2 * axis + i]), [0, 1].map(|i| SIDES[2 * axis + i]));
        let along = ["y", "x"][axis];
        let what = format!("a scale of {low} at the {one} and {high} at the {other} cannot tile along {along}");
        Err(Failure::new(2, what).remedy("change --tile, or make both sides equal"))
    }

    /// By position, the sources that may be copied from, of those `of` each level of [`levels`](Self::levels).
    pub(super) fn allowed(
        &self,
        output: Domain<2>,
        picture: Option<&Plane<2>>,
        of: &[u64],
    ) -> Result<Grid<u64, 2>, Failure> {
        self.check(output.periodic)?;
        let wanted = match (&self.field, picture) {
            (Field::Sides(sides), _) => WantedScale::Sides(*sides),
            (Field::Picture(_), Some(plane)) => WantedScale::Picture {
                shape: plane.domain().shape,
                light: |at| light(plane, plane.domain().index(at)),
                range: [self.range.low, self.range.high],
            },
            (Field::Picture(path), None) => return Err(Failure::new(3, "was not read").about(path)),
        };
        Ok(self.series.field(output, |at| wanted.at(output, at), of)?)
    }
}

/// Lightness as masks have it: 77, 150 and 29 of 256 parts of red, green and blue, as stored.
fn light(plane: &Plane<2>, i: usize) -> f64 {
    let white = plane.samples.depth().full();
    let value = |c: usize| plane.samples.value(c, i) / white;
    let light = if plane.color_channels() < 3 {
        value(0)
    } else {
        (77.0 * value(0) + 150.0 * value(1) + 29.0 * value(2)) / 256.0
    };
    light.clamp(0.0, 1.0)
}

/// At most so many sources can be told apart by place.
pub(super) fn check_number(
    exemplars: usize,
    orientations: usize,
    levels: usize,
    backdrop: bool,
) -> Result<(), Failure> {
    let sources = exemplars * orientations * levels + usize::from(backdrop);
    if sources <= u64::BITS as usize {
        return Ok(());
    }
    let counts = format!("{exemplars} exemplars in {orientations} orientations and {levels} scales");
    let what = format!("{counts} are {sources} sources, and places can choose from {}", u64::BITS);
    Err(Failure::new(2, what).remedy("use a larger --scale-step, a narrower range, or fewer orientations"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        let Wrong { what, remedy } = text.parse::<Field>().unwrap_err();
        format!("{what}; {remedy}")
    }

    #[test]
    fn fields_are_read_as_written() {
        assert_eq!("top=0.5,bottom=1.5".parse(), Ok(Field::Sides([0.5, 1.5, 1.0, 1.0])));
        assert_eq!("right=2".parse(), Ok(Field::Sides([1.0, 1.0, 1.0, 2.0])));
        assert_eq!("depth.png".parse(), Ok(Field::Picture("depth.png".into())));
        assert_eq!("a,top=1.png".parse(), Ok(Field::Picture("a,top=1.png".into())));
        for wrong in ["top=nan", "top=0", "top=-1", "bottom=inf", "left=17", "right=", "top=1,top=2"] {
            assert!(refused(wrong).contains("is no scale") || refused(wrong).contains("twice"), "{wrong}");
        }
        assert!(refused("top=10,left=10").contains("from 1 to 100"), "{}", refused("top=10,left=10"));
    }
}
