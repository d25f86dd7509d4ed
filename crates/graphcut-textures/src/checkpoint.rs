//! What a run has come to, so that another goes on from there to the same map.

use selvedge_core::{Exemplars, Patch, Run, SampleId, SourceMap, Start, Woven};

use crate::error::Error;
use crate::history::History;
use crate::plan::Plan;
use crate::stats::Stats;
use crate::weaver::{Weaver, worked};
use crate::words::{Words, put_ids, put_prices, put_word};

/// Bytes begin so: what is kept, and in which form.
const MAGIC: &[u8] = b"selvedge graphcut 1\n";

/// What a run at one size has come to: its map, counts, the offsets that it used, how patches lie to each other, and
/// which regions it gave up for now. A run of the same exemplars, start, options and seed that goes on from it
/// ([`Plan::weave_on`]) comes to the same map and counts as one that was never stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint<const D: usize> {
    ids: Vec<SampleId>,
    history: History<D>,
    step: u64,
    failures: u64,
    left_out: Vec<bool>,
    /// Of patches, refinements, improvements, cuts and their nodes.
    counts: [u64; 5],
    energy: Vec<i64>,
}

impl<const D: usize> Checkpoint<D> {
    /// Of a run as it is now.
    pub(crate) fn of(weaver: &Weaver<'_, D>) -> Self {
        Self {
            ids: weaver.canvas.map.ids.plane(0).to_vec(),
            history: weaver.history.clone(),
            step: weaver.step,
            failures: weaver.failures,
            left_out: weaver.canvas.cells.left_out().to_vec(),
            counts: weaver.stats.counts(),
            energy: weaver.stats.energy.clone(),
        }
    }

    /// A run that was just begun from this one's map becomes this one.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] unless it has as many regions.
    fn resume(&self, weaver: &mut Weaver<'_, D>) -> Result<(), Error> {
        if !weaver.canvas.cells.leave_out_all(&self.left_out) {
            return Err(Error::Checkpoint { what: "regions" });
        }
        (weaver.history, weaver.step, weaver.failures) = (self.history.clone(), self.step, self.failures);
        let stats = &mut weaver.stats;
        stats.set_counts(self.counts);
        stats.energy.clone_from(&self.energy);
        Ok(())
    }

    /// The start of a run with what was laid so far in it.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] for an output of another size, or samples that no exemplar has.
    fn started(&self, start: Start<D>, exemplars: &Exemplars<D>) -> Result<Start<D>, Error> {
        let mut map = start.map;
        let ids = map.ids.plane_mut(0);
        if ids.len() != self.ids.len() {
            return Err(Error::Checkpoint { what: "output" });
        }
        let samples = exemplars.table().len();
        if self.ids.iter().any(|id| id.is_assigned() && samples <= id.get()) {
            return Err(Error::Checkpoint { what: "exemplars" });
        }
        ids.copy_from_slice(&self.ids);
        Ok(Start { map, ..start })
    }

    /// Patches that cover the output, and refinements, so far.
    pub fn done(&self) -> [u64; 2] {
        [self.counts[0], self.counts[1]]
    }

    /// The same in bytes, for a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let mut put = |word: u64| put_word(&mut bytes, word);
        let patch = |source: usize, offset: [i32; D]| {
            std::iter::once(source as u64).chain(offset.into_iter().map(|by| i64::from(by) as u64))
        };
        [D as u64, self.step, self.failures, self.history.noted.into()].into_iter().for_each(&mut put);
        self.counts.into_iter().for_each(&mut put);
        put_prices(&mut bytes, &self.energy);
        let mut put = |word: u64| put_word(&mut bytes, word);
        put(self.history.used.len() as u64);
        self.history.used.iter().flat_map(|of| patch(of.source, of.offset)).for_each(&mut put);
        put(self.history.vectors.len() as u64);
        for (&(source, vector), &times) in &self.history.vectors {
            patch(source, vector).chain([times.into()]).for_each(&mut put);
        }
        put(self.left_out.len() as u64);
        put(self.ids.len() as u64);
        bytes.extend(self.left_out.iter().map(|&out| u8::from(out)));
        put_ids(&mut bytes, &self.ids);
        bytes
    }

    /// What [`to_bytes`](Self::to_bytes) made.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] for anything else.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, Error> {
        read(bytes).ok_or(Error::Checkpoint { what: "form" })
    }
}

fn read<const D: usize>(bytes: &[u8]) -> Option<Checkpoint<D>> {
    let mut words = Words(bytes.strip_prefix(MAGIC)?);
    if words.word()? != D as u64 {
        return None;
    }
    let (step, failures, noted) = (words.word()?, words.word()?, u32::try_from(words.word()?).ok()?);
    let counts = words.array()?;
    let energy = words.prices()?;
    let patch = |words: &mut Words<'_>| {
        let (source, mut offset) = (usize::try_from(words.word()?).ok()?, [0; D]);
        for by in &mut offset {
            *by = i32::try_from(words.word()? as i64).ok()?;
        }
        Some(Patch { source, offset })
    };
    let used = (0..words.word()?).map(|_| patch(&mut words)).collect::<Option<_>>()?;
    let vectors = (0..words.word()?).map(|_| {
        let of = patch(&mut words)?;
        Some(((of.source, of.offset), u32::try_from(words.word()?).ok()?))
    });
    let vectors = vectors.collect::<Option<_>>()?;
    let (cells, samples) = (usize::try_from(words.word()?).ok()?, words.word()?);
    let (left_out, rest) = words.0.split_at_checked(cells)?;
    if left_out.iter().any(|out| 1 < *out) {
        return None;
    }
    let ids = Words(rest).ids(samples)?;
    let left_out = left_out.iter().map(|out| *out == 1).collect();
    let history = History { used, vectors, noted };
    Some(Checkpoint { ids, history, step, failures, left_out, counts, energy })
}

impl<const D: usize> Plan<'_, D> {
    /// Weaves as planned, and lets `keep` make a [`Checkpoint`] after each patch and each batch of refinements. With
    /// one it goes on from there, where `start` is what the run began with.
    ///
    /// # Errors
    /// Those of [`weave`](Plan::weave), and [`Error::Checkpoint`] for a checkpoint of another run, as far as is seen,
    /// and at several levels.
    pub fn weave_on(
        &self,
        start: Start<D>,
        from: Option<&Checkpoint<D>>,
        run: &Run<'_, D>,
        keep: &mut dyn FnMut(&dyn Fn() -> Checkpoint<D>),
    ) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        let plan = self.fitting(&start, run)?;
        if plan.settings.levels != 1 {
            return Err(Error::Checkpoint { what: "number of levels" });
        }
        let start = match from {
            Some(from) => from.started(start, plan.exemplars)?,
            None => start,
        };
        plan.weighed(run, |run| {
            let work = |weaver: &mut Weaver<'_, D>| {
                from.map_or(Ok(()), |from| from.resume(weaver))?;
                weaver.weave_on(&mut |weaver| keep(&|| Checkpoint::of(weaver)))
            };
            worked(plan.exemplars, start, &plan.settings, &plan.options, run, work).map(|(woven, _)| woven)
        })
    }
}
