//! What an animation has come to, so that another goes on from there to the same frames.

use selvedge_core::{Bytes, Domain, Exemplars, Run, SampleId, SourceMap};

use super::animator::{Animation, Animator};
use super::carry::Carried;
use crate::error::Error;

/// Bytes begin so: what is kept, and in which form.
const MAGIC: &[u8] = b"selvedge animation 1\n";

/// What an [`Animator`] has come to: its frame, where what it shows stands between samples, what its first frame
/// showed and how well those after it fitted, and how far it has closed.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    frame: Vec<SampleId>,
    begun: Vec<SampleId>,
    carried: Carried,
    first: Vec<f64>,
    usual: Option<f64>,
    /// Frames made while it closed.
    closed: u64,
}

impl Animator<'_> {
    /// What it has come to.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            frame: self.map.ids.plane(0).to_vec(),
            begun: self.begun.clone(),
            carried: self.carried.clone(),
            first: self.first.clone(),
            usual: self.usual,
            closed: self.closed as u64,
        }
    }
}

impl<'e> Animator<'e> {
    /// Goes on from a checkpoint of the same exemplars (of a clip, those that its last frame was of), options and seed,
    /// to the same frames. One that had begun to [close](Self::close) is told so again, by the same flows.
    ///
    /// # Errors
    /// Those of [`new`](Self::new), and [`Error::Checkpoint`] for one of another output or of exemplars with fewer
    /// samples.
    pub fn resume(
        exemplars: &'e Exemplars<2>,
        output: Domain<2>,
        from: &Checkpoint,
        options: &Animation,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        if from.carried.domain != output {
            return Err(Error::Checkpoint { what: "output differs" });
        }
        let is_foreign = |id: &SampleId| exemplars.table().len() <= id.get();
        if from.frame.iter().chain(&from.begun).any(is_foreign) || !from.carried.is_of(exemplars) {
            return Err(Error::Checkpoint { what: "exemplars differ" });
        }
        let mut map = SourceMap::unassigned(exemplars, output)?;
        map.ids.plane_mut(0).copy_from_slice(&from.frame);
        let mut animator = Self::new(exemplars, map, options, run)?;
        animator.begun.clone_from(&from.begun);
        animator.carried = from.carried.clone();
        (animator.first, animator.usual, animator.closed) = (from.first.clone(), from.usual, from.closed as usize);
        Ok(animator)
    }
}

/// An upper bound of the bytes that a [`Checkpoint`] takes, with what a file of it has.
pub fn checkpoint_bytes(output: Domain<2>) -> Bytes {
    // As it is, in bytes, and in those beside a head.
    Bytes::of_samples(output, 40 + 32 + 32)
}

impl Checkpoint {
    /// The same in bytes, for a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let mut put = |word: u64| bytes.extend(word.to_le_bytes());
        let Domain { shape, periodic } = self.carried.domain;
        shape.into_iter().for_each(|n| put(n.into()));
        periodic.into_iter().for_each(|around| put(around.into()));
        put(self.closed);
        let usual = self.usual.into_iter();
        for all in [self.first.clone(), usual.collect()] {
            put(all.len() as u64);
            all.into_iter().for_each(|v| put(v.to_bits()));
        }
        self.carried.words().for_each(&mut put);
        bytes.extend(self.frame.iter().chain(&self.begun).flat_map(|id| id.get().to_le_bytes()));
        bytes
    }

    /// What [`to_bytes`](Self::to_bytes) made.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] for anything else.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, Error> {
        read(bytes).ok_or(Error::Checkpoint { what: "form differs" })
    }
}

fn read(bytes: &[u8]) -> Option<Checkpoint> {
    let mut rest = bytes.strip_prefix(MAGIC)?;
    let mut word = || {
        let (first, others) = rest.split_first_chunk::<8>()?;
        rest = others;
        Some(u64::from_le_bytes(*first))
    };
    let shape = [u32::try_from(word()?).ok()?, u32::try_from(word()?).ok()?];
    let mut flag = || word().filter(|word| *word < 2).map(|word| word == 1);
    let domain = Domain { shape, periodic: [flag()?, flag()?] };
    let closed = word()?;
    let mut numbers = || (0..word()?).map(|_| word().map(f64::from_bits)).collect::<Option<Vec<_>>>();
    let (first, usual) = (numbers()?, numbers()?);
    let carried = Carried::of_words(domain, &mut word)?;
    let (ids, others) = rest.as_chunks::<4>();
    if !others.is_empty() || ids.len() != 2 * domain.len() || 1 < usual.len() {
        return None;
    }
    let ids: Vec<_> = ids.iter().map(|id| SampleId::new(u32::from_le_bytes(*id))).collect();
    let (frame, begun) = (ids[..domain.len()].to_vec(), ids[domain.len()..].to_vec());
    Some(Checkpoint { frame, begun, carried, first, usual: usual.first().copied(), closed })
}
