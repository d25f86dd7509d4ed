//! What blocks and samples follow besides what stands: a guide, as one more term of every choice.

use selvedge_core::{Error, Exemplars, Guide, Look, SampleId, Window, try_vec};
use selvedge_quilting::search::{Space, Term, mean_weights};

use crate::features::side_by_side;

/// Blocks are not split below this side because of a guide alone: the samples of a neighborhood (7 by 7) and one more.
/// Where the exemplars have nothing of what is asked for, no block is small enough.
pub(crate) const LEAST_FOLLOWED: u32 = 8;
/// Fractions of a squared step in which samples follow.
const FINE: u64 = 1 << 16;
/// Most that a guide counts where samples are chosen: sums stay below 64 bits.
const MOST: f64 = 1000.0;

/// A guide and what it counts.
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    /// Under the sources as they are searched.
    pub(crate) guide: Guide<2>,
    /// Where the exemplars count 1.
    pub(crate) weight: f64,
}

impl Followed {
    /// The same under other sources, maps of the guide's own.
    pub(crate) fn under(&self, maps: &Exemplars<2>) -> Result<Self, Error> {
        let guide = Guide::of_look(maps, self.guide.target().map(|v| v)?)?;
        let guide = match self.guide.asked() {
            Some(asked) => guide.asking(asked.map(|v| v)?)?,
            None => guide,
        };
        Ok(Self { guide, weight: self.weight })
    }

    /// Looks at what is asked for in a window.
    pub(crate) fn look(&self, window: &Window<2>, look: &mut Look) -> Result<(), Error> {
        look.at_grid(self.guide.target(), self.guide.asked(), window)
    }

    /// What a block has to agree with: what stands, and what is asked for, each as a mean.
    pub(crate) fn terms<'t>(
        &self,
        texture: &Exemplars<2>,
        shape: [u32; 2],
        (stands, asked): (&'t Look, &'t Look),
    ) -> Vec<Term<'t>> {
        let share = (1000.0 / (1.0 + self.weight)).round() as u32;
        let averaged = |look: &Look, weights: &[u8]| look.samples() as u64 * whole(weights);
        let means = [averaged(stands, texture.weights()), averaged(asked, self.guide.weights())];
        let weights = mean_weights([(share, means[0]), (1000 - share, means[1])]);
        let term = |space, look, weight| Term { weight, ..Term::new(space, shape, look) };
        let both = [term(Space::Texture, stands, weights[0]), term(Space::Guide, asked, weights[1])];
        let [texture, _] = both;
        let counts = |(term, mean): (Term<'t>, u64)| (mean != 0).then_some(term);
        let terms: Vec<_> = both.into_iter().zip(means).filter_map(counts).collect();
        // Where nothing is compared everything fits.
        if terms.is_empty() { vec![texture] } else { terms }
    }

    /// Both errors as one of `samples` samples of the texture: the mean of both means, each by what it counts.
    pub(crate) fn joined(&self, texture: &Exemplars<2>, (error, samples): (u64, u64), guide: (u64, u64)) -> (u64, u64) {
        if guide.1 == 0 {
            return (error, samples);
        }
        let guided =
            guide.0 as f64 / guide.1 as f64 * whole(texture.weights()) as f64 / whole(self.guide.weights()) as f64;
        if samples == 0 {
            return ((guided * guide.1 as f64) as u64, guide.1);
        }
        (((error as f64 + self.weight * guided * samples as f64) / (1.0 + self.weight)) as u64, samples)
    }
}

/// All channels' weights together.
fn whole(weights: &[u8]) -> u64 {
    weights.iter().map(|&w| u64::from(w)).sum()
}

/// What single samples follow.
pub(crate) struct SampleGuide<'a> {
    guide: &'a Guide<2>,
    /// By sample number, all channels side by side.
    features: Vec<u8>,
    /// In [`FINE`] parts.
    weights: Vec<u64>,
}

impl<'a> SampleGuide<'a> {
    pub(crate) fn new(followed: &'a Followed, texture: &Exemplars<2>) -> Result<Self, Error> {
        let guide = &followed.guide;
        let each = followed.weight.min(MOST) * whole(texture.weights()) as f64 / whole(guide.weights()) as f64;
        let mut weights = try_vec(guide.weights().len(), 0)?;
        for (to, &weight) in weights.iter_mut().zip(guide.weights()) {
            *to = (each * f64::from(weight) * FINE as f64).round() as u64;
        }
        Ok(Self { guide, features: side_by_side(guide.exemplars())?, weights })
    }

    /// How far a sample is from what is asked for at a place, in squared steps of the texture; 0 where nothing is.
    pub(crate) fn error(&self, id: SampleId, place: usize) -> u64 {
        if self.guide.asked().is_some_and(|asked| !asked.samples()[place]) {
            return 0;
        }
        let from = &self.features[id.get() as usize * self.weights.len()..];
        let square = |(c, &weight): (usize, &u64)| {
            weight * u64::from(u32::from(from[c].abs_diff(self.guide.target().plane(c)[place])).pow(2))
        };
        self.weights.iter().enumerate().map(square).sum::<u64>() / FINE
    }
}
