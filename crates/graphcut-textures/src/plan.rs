//! A run that is planned: what it is made of, and all that it has chosen before it lays the first patch.

use selvedge_core::{Bytes, Domain, Error as CoreError, Exemplars, Grid, Limits, Run, SourceMap, Start, Woven, par};

use crate::error::Error;
use crate::estimate::{Known, at_levels, measuring};
use crate::levels;
use crate::options::Options;
use crate::regions::CLIP;
use crate::settings::{Settings, measured};
use crate::stats::Stats;
use crate::weaver::weave_at;
use crate::work::{Weighed, Work};

/// Refuses other numbers of axes than one to three, at the line that calls what users call.
pub(crate) const fn supported(axes: usize) {
    assert!(1 <= axes && axes <= 3, "textures have one to three axes");
}

/// A run by these exemplars and options, onto an output of this domain, before any of it is done.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'e, const D: usize> {
    pub(crate) exemplars: &'e Exemplars<D>,
    pub(crate) output: Domain<D>,
    pub(crate) options: Options<D>,
    /// What it has chosen.
    pub settings: Settings<D>,
}

/// What [`graphcut_from`](crate::graphcut_from) would do with these exemplars, an output and a field of sources
/// ([`Start::sources`], `None` for all everywhere), without doing any of it: all that a run chooses by itself.
///
/// # Errors
/// Those of [`graphcut_from`](crate::graphcut_from) that are known before the first patch is laid, but for what is
/// wrong with the start itself, and for memory that only the work needs.
///
/// # Complexity
/// Time `O(samples log(samples))` of the exemplars, however large the output is.
pub fn plan<'e, const D: usize>(
    exemplars: &'e Exemplars<D>,
    output: Domain<D>,
    field: Option<&Grid<u64, D>>,
    options: &Options<D>,
    limits: &Limits,
) -> Result<Plan<'e, D>, Error> {
    const { supported(D) };
    check(exemplars, output, options, limits)?;
    let settings = measured(exemplars, output, field, options)?;
    Ok(Plan { exemplars, output, options: *options, settings })
}

/// What can be checked before anything is measured.
fn check<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
    limits: &Limits,
) -> Result<(), Error> {
    options.validate()?;
    let (sources, masked) = (exemplars.domains(), exemplars.is_masked());
    Ok(limits.admit(output, measuring(&sources, exemplars.channels(), masked, options))?)
}

/// True where nothing is there, or asked for, that a run at several sizes could not begin from. Of clips whole frames
/// stand, which are halved as the clip is; a map without holes is only made better.
pub(crate) fn may_be_halved<const D: usize>(start: &Start<D>) -> bool {
    let holes = start.map.holes();
    let is_fresh = start.fixed.is_none() && holes == start.map.domain().len();
    start.sources.is_none() && (is_fresh || D == CLIP && 0 < holes && stands_by_frames(start))
}

/// Whether each frame stands or is missing as a whole, and stays or may change so: of a part as thin as a sample
/// nothing may be left at half the size, which would be woven there as if it were not.
fn stands_by_frames<const D: usize>(start: &Start<D>) -> bool {
    let frame = start.map.domain().strides()[0].max(1);
    let stand = start.map.ids.plane(0).chunks(frame);
    let stay = start.fixed.iter().flat_map(|fixed| fixed.plane(0).chunks(frame));
    stand.into_iter().all(|ids| ids.iter().all(|id| id.is_assigned() == ids[0].is_assigned()))
        && stay.into_iter().all(|fixed| fixed.iter().all(|stays| *stays == fixed[0]))
}

impl<const D: usize> Plan<'_, D> {
    /// The same for a run that goes on from `start`: of a picture where anything is there, or asked for, it has one
    /// size, of a clip where nothing is missing, frames stand or stay in part, or sources are asked for.
    ///
    /// # Errors
    /// [`Error::LevelsOfStart`] if the options ask for several.
    pub fn on(self, start: &Start<D>) -> Result<Self, Error> {
        match self.options.levels {
            _ if self.settings.levels == 1 || may_be_halved(start) => Ok(self),
            None => Ok(Self { settings: Settings { levels: 1, ..self.settings }, ..self }),
            Some(levels) => Err(Error::LevelsOfStart { levels }),
        }
    }

    /// About how many patches cover an output with nothing in it.
    pub fn patches(&self) -> u64 {
        self.settings.patches(self.output)
    }

    /// How many refinements follow at most.
    pub fn refinements(&self) -> u64 {
        let most = self.patches().saturating_mul(Options::<D>::REFINEMENTS_A_PATCH);
        self.options.refine.map_or(most, u64::from)
    }

    /// Options that leave nothing to choose: what they plan is this, without measuring anything.
    #[must_use]
    pub fn chosen(&self) -> Options<D> {
        let settings = &self.settings;
        Options {
            placement: settings.placement,
            region: Some(settings.region),
            reach: Some(settings.reach),
            variety: Some(settings.variety),
            apart: Some(settings.apart),
            stutter: settings.stutter,
            levels: Some(settings.levels),
            ..self.options
        }
    }

    /// An upper bound of the bytes that making this plan and weaving by it hold besides the exemplars themselves, on
    /// the threads of this pool.
    pub fn bytes(&self) -> Bytes {
        self.bytes_of(self.output)
    }

    /// The same of an output of another size: how much smaller one has to be that memory holds.
    pub fn bytes_of(&self, output: Domain<D>) -> Bytes {
        let (exemplars, settings) = (self.exemplars, &self.settings);
        let (sources, masked) = (exemplars.domains(), exemplars.is_masked());
        let known = Known { masked, threads: par::threads() as u64 };
        let (region, reach) = (Some(settings.region), Some(settings.reach));
        let chosen = Options { placement: settings.placement, region, reach, ..self.options };
        let run = at_levels(&sources, exemplars.channels(), output, &chosen, settings.levels, known);
        measuring(&sources, exemplars.channels(), masked, &self.options).then(run)
    }

    /// Weaves as planned, from what is there; a field of sources is the plan's.
    ///
    /// # Errors
    /// Those of [`graphcut_from`](crate::graphcut_from), and the core's `StartShape` if the start is no start of the
    /// output that was planned.
    pub fn weave(&self, start: Start<D>, run: &Run<'_, D>) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        let plan = self.fitting(&start, run)?;
        match plan.settings.levels {
            1 => plan.at_one_size(start, run),
            _ => levels::weave(self.exemplars, start, &plan.settings, &self.options, run),
        }
    }

    /// The plan of a run from this start, for which there is memory.
    pub(crate) fn fitting(&self, start: &Start<D>, run: &Run<'_, D>) -> Result<Self, Error> {
        start.check(self.exemplars)?;
        let (expected, found) = (self.output, start.map.domain());
        if expected != found {
            let (expected, found) = (expected.shape.to_vec(), found.shape.to_vec());
            return Err(CoreError::StartShape { what: "start", expected, found }.into());
        }
        let plan = self.on(start)?;
        run.limits.admit(self.output, plan.bytes())?;
        Ok(plan)
    }

    /// A run at the size of its output.
    fn at_one_size(&self, start: Start<D>, run: &Run<'_, D>) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        self.weighed(run, |run| weave_at(self.exemplars, start, &self.settings, &self.options, run))
    }

    /// Does something in a run that says how far it is.
    pub(crate) fn weighed<T>(&self, run: &Run<'_, D>, work: impl FnOnce(&Run<'_, D>) -> T) -> T {
        let observer =
            &Weighed { observer: run.observer, work: Work::of(&self.settings, self.output, 0, &self.options) };
        work(&Run { observer, ..*run })
    }
}
