//! What kind of texture it is, all in one.

use selvedge_core::{Exemplars, Grid};
use selvedge_fft_ssd::Error;

use crate::feature_size::{firsts, lost_likeness, of_strengths};
use crate::lattice::Lattice;
use crate::lines::{Lines, share};
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
}

/// Shares, in thousandths, that tell kinds apart: chosen on 53 textures that a reader had named before.
///
/// Rows of text, and lines along them, by their share of the variance.
const WRITTEN: u32 = 200;
const LINED: u32 = 120;
/// So much of the variance in one direction is no lattice, however it repeats itself: planks.
const MOSTLY_LINES: u32 = 400;
/// Differences along the lines of more than that share: signs; of less than this one: lines.
const SIGNS: u32 = 524;
const STRAIGHT: u32 = 286;
/// From this strength on a lattice is what the texture is made of;
const REGULAR: u32 = 650;
/// from this one on patches are better laid by it.
const ORDERLY: u32 = 400;
const UNEVEN: u32 = 150;
const FEW: u32 = 100;
const SMOOTH: u32 = 250;

impl Texture {
    /// Looks at a texture; of clips at the frame in the middle.
    ///
    /// All of it is measured on means over cells of a 200th of the longer side, so that it takes milliseconds: the shade is
    /// what means over a third of the lesser side show, lines and lattice are looked for in what is left without it.
    ///
    /// # Errors
    /// Those of [`periods`](crate::periods()).
    pub fn of<const D: usize>(
        features: &Grid<u8, D>,
        valid: Option<&Grid<bool, D>>,
        weights: &[u8],
    ) -> Result<Self, Error> {
        let whole = Strengths::of(features, valid, weights)?;
        let feature_size = whole.as_ref().map_or(Ok(1), of_strengths)?;
        let picture = Picture::of(features, valid)?;
        let lesser = picture.shape()[0].min(picture.shape()[1]);
        let low = picture.shade(lesser / 6)?;
        let even = picture.without(&low)?;
        let fine = picture.without(&picture.shade((lesser / 16).max(2))?)?;
        let lines = Lines::of(&fine, weights);
        let strengths = Strengths::within(&even.features()?, Some(&even.known), weights, Lattice::reach(&even))?;
        let lattice = strengths.as_ref().map(|s| Lattice::of(s, &even)).transpose()?.flatten();
        let lattice = lattice.map(|l| whole.as_ref().map_or(l, |w| l.refined(w, picture.side)));
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
        };
        texture.kind = texture.judged();
        Ok(texture)
    }

    /// The first source of each exemplar.
    ///
    /// # Errors
    /// Those of [`of`](Self::of).
    pub fn of_each<const D: usize>(exemplars: &Exemplars<D>) -> Result<Vec<Self>, Error> {
        firsts(exemplars).map(|s| Self::of(&s.features, s.valid.as_ref(), exemplars.weights())).collect()
    }

    /// True where patches are better laid by how the whole of them agrees than by their surroundings alone: on a lattice, even
    /// a weak one, and on lines of text.
    pub fn is_orderly(&self) -> bool {
        self.kind == Kind::Text || self.lattice.is_some_and(|l| ORDERLY <= l.strength)
    }

    /// True where light differs from place to place.
    pub fn is_uneven(&self) -> bool {
        UNEVEN <= self.shade
    }

    fn judged(&self) -> Kind {
        let (share, along) = self.lines.strongest();
        match self.lattice {
            _ if WRITTEN <= share && SIGNS <= along => Kind::Text,
            Some(l) if REGULAR <= l.strength && share < MOSTLY_LINES => Kind::Lattice,
            _ if LINED <= share || self.lines.upright.min(1000 - self.lines.upright) < STRAIGHT => Kind::Lines,
            _ if self.is_uneven() && FEW <= self.body => Kind::Scene,
            _ if !self.is_uneven() && self.grain <= SMOOTH => Kind::Objects,
            _ => Kind::Stochastic,
        }
    }
}
