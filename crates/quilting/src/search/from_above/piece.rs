//! What is searched for, at several sizes.

use selvedge_core::{Domain, try_vec};
use selvedge_fft_ssd::Template;

use crate::options::Error;
use crate::search::Term;

/// Sides below which an odd sample is halved as well. Exemplars hold such a piece at any size.
const THIN: u32 = 16;

/// The shape of a piece at half the size: an odd row or column is left out, but of thin pieces, of which it is too
/// much, it stands by itself.
fn half(shape: [u32; 2]) -> [u32; 2] {
    shape.map(|n| if n < THIN { n.div_ceil(2) } else { n / 2 })
}

/// The same so often.
pub(crate) fn halved(shape: [u32; 2], times: u32) -> [u32; 2] {
    (0..times).fold(shape, |shape, _| half(shape))
}

/// What is searched for at one size.
#[derive(Debug)]
pub(super) struct Piece {
    shape: [u32; 2],
    features: Vec<u8>,
    mask: Vec<bool>,
}

impl Piece {
    /// What a term has to agree with, of so many channels.
    pub(super) fn of(term: &Term<'_>, channels: usize) -> Result<Self, Error> {
        let template = term.template;
        let len = template.shape().iter().map(|&n| n as usize).product::<usize>();
        let mut features = try_vec(len * channels, 0_u8)?;
        features.copy_from_slice(template.features());
        let mut mask = try_vec(len, true)?;
        if let Some(known) = template.mask() {
            mask.copy_from_slice(known);
        }
        Ok(Self { shape: template.shape(), features, mask })
    }

    /// True if nothing of it is compared.
    pub(super) fn is_empty(&self) -> bool {
        !self.mask.contains(&true)
    }

    pub(super) fn shape(&self) -> [u32; 2] {
        self.shape
    }

    pub(super) fn template(&self) -> Template<'_, 2> {
        Template::new(self.shape, &self.features).masked(&self.mask)
    }

    /// The same at half the size: means of what is known, where at least half of it is.
    pub(super) fn halved(&self) -> Result<Self, Error> {
        let shape = half(self.shape);
        let (fine, coarse) = (Domain::open(self.shape), Domain::open(shape));
        let channels = self.features.len() / self.mask.len().max(1);
        let (mut features, mut mask) = (try_vec(coarse.len() * channels, 0_u8)?, try_vec(coarse.len(), false)?);
        for (i, [y, x]) in coarse.positions().enumerate() {
            let four = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[dy, dx]| [2 * y + dy, 2 * x + dx]);
            let four = four.map(|at| (at[0] < self.shape[0] && at[1] < self.shape[1]).then(|| fine.index(at)));
            let [all, known] =
                [0, 1].map(|of| four.iter().flatten().filter(|&&f| of == 0 || self.mask[f]).count() as u32);
            mask[i] = all <= 2 * known;
            if !mask[i] {
                continue;
            }
            for c in 0..channels {
                let plane = &self.features[c * self.mask.len()..];
                let sum: u32 = four.iter().flatten().filter(|&&f| self.mask[f]).map(|&f| u32::from(plane[f])).sum();
                features[c * coarse.len() + i] = ((2 * sum + known) / (2 * known)) as u8;
            }
        }
        Ok(Self { shape, features, mask })
    }
}
