//! How far a picture is laid over itself, how wide its border is, or how long its period.

use selvedge_analysis::Texture;
use selvedge_graphcut_textures::labels::{check_band, check_overlap, overlaps};

use super::{MethodArg, TileCommand};
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::method::Method as _;
use crate::size::Tile;
use crate::values::Auto;

/// Sides of less have no border that could be closed.
const LEAST: u32 = 4;

/// How far a picture is laid over itself, or the width of its border, or its period, along each axis.
pub(super) type Widths = [u32; 2];

/// Ways after which a lattice closes that are looked through for one of whole samples: a tile of more would be most of
/// a picture.
const OFTEN: u32 = 4;
/// What they may be off by to be whole, in parts of a sample: a seam takes that, and few lattices are nearer. A guess.
const WHOLE: f64 = 0.15;

impl TileCommand {
    /// What is closed along each axis, which it takes from the output where the picture is laid over itself.
    pub(super) fn widths(&self, loom: &mut Loom<'_>) -> Result<Widths, Failure> {
        let axes = Tile::domain(Some(self.axes()), [1, 1]).periodic;
        let along = |n: u32| std::array::from_fn(|a| if axes[a] { n } else { 0 });
        let (exemplars, shape) = (&loom.loaded.exemplars, loom.domain.shape);
        let about = |e| loom.loaded.about(Failure::from(e));
        thin(axes, shape).map_or(Ok(()), |failure| Err(loom.loaded.about(failure)))?;
        let widths = match (self.method, self.overlap.0, self.band.0) {
            (MethodArg::Overlap, Some(n), _) | (MethodArg::Band, _, Some(n)) => along(n),
            (MethodArg::Band, ..) => along((shape[0].min(shape[1]) / 8).max(1)),
            (MethodArg::Overlap, ..) => {
                overlaps(exemplars, axes, self.seams.measure(), &loom.session.run()).map_err(about)?
            }
        };
        // Fine by themselves, but too wide for this picture.
        let too_wide = |e| loom.loaded.about(Failure { exit: 3, ..Failure::from(e) });
        match self.method {
            MethodArg::Overlap => check_overlap(shape, widths).map_err(too_wide)?,
            MethodArg::Band => check_band(shape, widths).map_err(too_wide)?,
        }
        if self.method == MethodArg::Overlap {
            self.lay(loom, std::array::from_fn(|a| shape[a].saturating_sub(widths[a]).max(1)))?;
        }
        Ok(widths)
    }

    /// The output becomes smaller.
    fn lay(&self, loom: &mut Loom<'_>, shape: [u32; 2]) -> Result<(), Failure> {
        let exemplars = &loom.loaded.exemplars;
        let (domain, channels) = (exemplars.sources()[0].domain(), exemplars.channels());
        loom.lay(shape, |output| self.bytes(&[domain], channels, output))
    }

    /// The shape of one period, which the output has; along axes that are not closed all of the picture.
    pub(super) fn period(&self, loom: &mut Loom<'_>) -> Result<Widths, Failure> {
        let (source, shape) = (&loom.loaded.exemplars.sources()[0], loom.domain.shape);
        let about = |what: String| loom.loaded.about(Failure::new(3, what));
        let mut period = match self.period {
            Some(Auto(Some(period))) => period,
            _ => {
                let weights = loom.loaded.exemplars.weights();
                let texture = Texture::of(&source.features, source.valid.as_deref(), weights)?;
                let mut period = shape;
                for axis in (0..2).filter(|&a| loom.domain.periodic[a]) {
                    let along = texture.order().and_then(|lattice| lattice.along[axis]);
                    let Some(along) = along else {
                        let what = format!("it comes again nowhere straight {}", ["down", "across"][axis]);
                        return Err(about(what).remedy("leave --period out, or say how long it is"));
                    };
                    period[axis] = whole(along);
                }
                period
            }
        };
        for axis in 0..2 {
            if !loom.domain.periodic[axis] {
                period[axis] = shape[axis];
            } else if period[axis] < 2 || shape[axis] < period[axis].saturating_add(2) {
                let what = format!("a period of {} does not lie in its {}", period[axis], shape[axis]);
                return Err(about(what).remedy("give a period of 2 px or more, and 2 less than the picture"));
            }
        }
        self.lay(loom, period)?;
        Ok(period)
    }
}

/// What is wrong with a picture that has no border to close along an axis.
fn thin(axes: [bool; 2], shape: [u32; 2]) -> Option<Failure> {
    let axis = (0..2).find(|&a| axes[a] && shape[a] < LEAST)?;
    let (side, pixels) = (["height", "width"][axis], n("pixel", shape[axis] as usize));
    let what = format!("its {side} is {pixels}, and a picture of less than {LEAST} px has no border to close");
    Some(Failure::new(3, what).remedy("give a larger picture, or close the other axis"))
}

/// A length after which what comes again `times` on `samples` does so after whole samples, nearly; of the first few the
/// shortest, or the nearest to it.
fn whole((samples, times): (u32, u32)) -> u32 {
    let length = |often: u32| f64::from(often) * f64::from(samples) / f64::from(times);
    let off = |often: u32| (length(often) - length(often).round()).abs();
    let near = (1..=OFTEN).find(|&often| off(often) <= WHOLE);
    let nearest = (1..=OFTEN).min_by(|&a, &b| off(a).total_cmp(&off(b)));
    length(near.or(nearest).unwrap_or(1)).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_of_part_samples_close_after_some() {
        assert_eq!([(24, 1), (72, 3), (135, 2), (100, 3), (61, 4)].map(whole), [24, 24, 135, 100, 61]);
        // Never within four: the second is nearest, 26.8.
        assert_eq!(whole((67, 5)), 27);
    }
}
