//! What the size of an output follows from.

use selvedge_core::Domain;

use crate::failure::Failure;
use crate::ground::Ground;
use crate::inputs::Input;
use crate::memory::Resized;
use crate::session::Session;
use crate::size::Size;
use crate::weaving::{Sizing, Weaving};

/// How a command lays all exemplars.
type Arrangement<'a> = Box<dyn Fn(&[Domain<2>]) -> Domain<2> + 'a>;

/// What the size of an output follows from.
pub(crate) enum OutputSize<'a> {
    /// What is typed, or a multiple of the first exemplar.
    Exemplar(Sizing),
    /// The first exemplar's, or as it is typed; its lattice is what it is.
    First(Option<Size>),
    /// A picture, of which the header is read, so many times larger.
    Picture(Input, u32),
    /// The same, and what was there before must have it.
    Upon(Box<Ground>, Input, u32),
    /// All exemplars, as a command lays them.
    Arranged(Arrangement<'a>),
    /// What was there before, with which the size typed must agree.
    Ground(Box<Ground>, Sizing),
}

impl OutputSize<'_> {
    /// Shape and topology for exemplars of these domains, the backdrop last.
    pub(crate) fn domain(
        &self,
        session: &Session<'_>,
        weaving: &Weaving,
        exemplars: &[Domain<2>],
    ) -> Result<Domain<2>, Failure> {
        match self {
            Self::Exemplar(sizing) => Ok(weaving.tiled(sizing.shape(exemplars[0].shape))),
            Self::First(size) => {
                let own = exemplars[0].shape;
                Ok(weaving.tiled(size.map_or(own, |size| size.shape(own))))
            }
            Self::Picture(picture, times) => Ok(weaving.tiled(followed(session, weaving, picture, *times)?)),
            Self::Upon(ground, picture, times) => {
                let shape = followed(session, weaving, picture, *times)?;
                ground.under(exemplars, (&picture.path, shape), weaving)
            }
            Self::Arranged(laid) => Ok(laid(exemplars)),
            Self::Ground(ground, sizing) => ground.domain(exemplars, *sizing, weaving),
        }
    }

    /// How the user changes it.
    pub(crate) fn resized(&self) -> Resized {
        match self {
            Self::Picture(..) | Self::Upon(..) => Resized::Target,
            Self::First(None) => Resized::Picture,
            Self::Arranged(_) => Resized::Places,
            Self::Exemplar(_) | Self::First(Some(_)) | Self::Ground(..) => Resized::Size,
        }
    }

    /// True if nothing that is there says what the size is.
    pub(crate) fn is_free(&self) -> bool {
        match self {
            Self::Exemplar(_) => true,
            Self::Ground(ground, _) => ground.is_bare(),
            Self::First(_) | Self::Picture(..) | Self::Upon(..) | Self::Arranged(_) => false,
        }
    }

    /// True if another first exemplar would have another output.
    pub(crate) fn follows_exemplar(&self) -> bool {
        match self {
            Self::Exemplar(sizing) => sizing.is_multiple(),
            Self::Picture(..) | Self::Upon(..) => false,
            Self::First(_) | Self::Arranged(_) => true,
            Self::Ground(ground, sizing) => ground.is_bare() && sizing.is_multiple(),
        }
    }
}

/// The shape of a picture, so many times larger.
fn followed(session: &Session<'_>, weaving: &Weaving, picture: &Input, times: u32) -> Result<[u32; 2], Failure> {
    let info = picture.probe(&weaving.read_options(session))?;
    Ok([info.height, info.width].map(|side| side.saturating_mul(times)))
}
