//! How far a label, or the output as it stands, is from the constraints. `[CMS IV-B3]`

use selvedge_core::{Exemplars, Grid, Patch, SampleId, Window, reserve};

use crate::boxes::{Boxes, Taps};
use crate::constraint::{Constraint, MOST_AGREEMENT, Scale, packed, price, unit};
use crate::error::Error;
use crate::options::Options;

/// A constraint with its prices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term<'a> {
    pub(crate) constraint: &'a Constraint,
    pub(crate) scale: Scale,
    pub(crate) taps: Taps,
}

impl<'a> Term<'a> {
    /// Those of the constraints that count: what weighs nothing is neither priced nor searched.
    pub(crate) fn list(exemplars: &Exemplars<2>, constraints: &'a [Constraint], options: &Options) -> Vec<Self> {
        let (half, unit) = (options.neighborhood, unit(exemplars));
        let of = |constraint: &'a Constraint| {
            let weight = options.constraint_weight * constraint.weight * unit;
            let scale = Scale::new(weight, constraint.guide.weights(), u64::from(2 * half + 1).pow(2));
            Self { constraint, scale, taps: Taps::around(half, constraint.ratio) }
        };
        constraints.iter().map(of).filter(|term| !term.scale.is_zero()).collect()
    }

    /// Sums of a label's errors over the neighborhoods of a window's samples, packed with the number of taps.
    pub(crate) fn sums<'b>(
        &self,
        patch: &Patch<2>,
        window: &Window<2>,
        boxes: &'b mut Boxes,
    ) -> Result<&'b [u64], Error> {
        boxes.of(window, self.taps, |reached, values| self.write(patch, reached, values))
    }

    /// The label's errors, 0 where a tap is missing, and no error where nothing is asked for.
    fn write(&self, patch: &Patch<2>, reached: &Window<2>, values: &mut [u64]) {
        let (guide, wide) = (&self.constraint.guide, reached.shape[1] as usize);
        let source = &guide.exemplars().sources()[patch.source];
        let (output, under) = (guide.target().domain(), reached.moved(patch.offset.map(|o| -o)));
        let places = |axis| reached.along(output, axis).zip(under.along(source.domain(), axis));
        let runs = Run::all(places(1));
        let mut errors = vec![0_u32; wide];
        for (row, (to, from)) in values.chunks_mut(wide).zip(places(0)) {
            let (Some(to), Some(from)) = (to, from) else { continue };
            for run in &runs {
                let (to, from) = ((to + run.to) as usize, (from + run.from) as usize);
                let errors = &mut errors[..run.len];
                errors.fill(0);
                for (c, &weight) in guide.weights().iter().enumerate() {
                    let [q, t] = [&source.features.plane(c)[from..], &guide.target().plane(c)[to..]];
                    for ((e, &q), &t) in errors.iter_mut().zip(q).zip(t) {
                        *e += squared(q, t) * u32::from(weight);
                    }
                }
                let row = &mut row[run.start..run.start + run.len];
                row.iter_mut().zip(&*errors).for_each(|(v, &e)| *v = packed(e));
                clear(row, source.valid.as_deref(), from);
            }
        }
        let Some(asked) = guide.asked() else { return };
        for (value, place) in values.iter_mut().zip(reached.places(output)) {
            if place.is_some_and(|place| !asked.samples()[place]) {
                *value = packed(0);
            }
        }
    }

    /// Whether a sample may be used: not where what lies under it is masked.
    #[inline]
    pub(crate) fn uses(&self, source: usize, index: usize) -> bool {
        self.constraint.guide.exemplars().sources()[source].valid.as_deref().is_none_or(|valid| valid.samples()[index])
    }

    /// The error of what stands at a place, packed; 0 where it is a missing tap.
    pub(crate) fn standing(&self, place: usize, id: SampleId) -> u64 {
        let guide = &self.constraint.guide;
        let Some(source) = guide.exemplars().table().source(id) else { return 0 };
        if guide.asked().is_some_and(|asked| !asked.samples()[place]) {
            return packed(0);
        }
        let index = (id.get() - guide.exemplars().table().first(source)) as usize;
        let features = &guide.exemplars().sources()[source].features;
        let channel = |(c, &weight): (usize, &u8)| {
            squared(features.plane(c)[index], guide.target().plane(c)[place]) * u32::from(weight)
        };
        packed(guide.weights().iter().enumerate().map(channel).sum())
    }
}

#[inline]
fn squared(a: u8, b: u8) -> u32 {
    u32::from(a.abs_diff(b)).pow(2)
}

/// Removes what a mask excludes.
fn clear(row: &mut [u64], mask: Option<&Grid<bool, 2>>, from: usize) {
    if let Some(mask) = mask {
        row.iter_mut().zip(&mask.samples()[from..]).filter(|(_, used)| !**used).for_each(|(v, _)| *v = 0);
    }
}

/// Neighbours along a row that are neighbours in the output and in the source.
#[derive(Debug, PartialEq)]
struct Run {
    start: usize,
    to: u32,
    from: u32,
    len: usize,
}

impl Run {
    fn all(places: impl Iterator<Item = (Option<u32>, Option<u32>)>) -> Vec<Self> {
        let mut runs: Vec<Self> = Vec::new();
        for (i, place) in places.enumerate() {
            let (Some(to), Some(from)) = place else { continue };
            match runs.last_mut().filter(|r| {
                let len = r.len as u32;
                (r.start + r.len, r.to + len, r.from + len) == (i, to, from)
            }) {
                Some(run) => run.len += 1,
                None => runs.push(Self { start: i, to, from, len: 1 }),
            }
        }
        runs
    }
}

/// `A'` of a label for each sample of a window, into `costs`. Where the label is not defined it means nothing.
pub(crate) fn of_label(
    terms: &[Term<'_>],
    patch: &Patch<2>,
    window: &Window<2>,
    boxes: &mut Boxes,
    scaled: &mut Vec<u64>,
    costs: &mut Vec<i32>,
) -> Result<(), Error> {
    scaled.clear();
    reserve(scaled, window.len())?;
    scaled.resize(window.len(), 0);
    for term in terms {
        let sums = term.sums(patch, window, boxes)?;
        scaled.iter_mut().zip(sums).for_each(|(to, &sum)| *to = to.saturating_add(term.scale.of_packed(sum)));
    }
    costs.clear();
    reserve(costs, window.len())?;
    costs.extend(scaled.iter().map(|&s| price(s)));
    for term in terms.iter().filter(|term| term.constraint.guide.exemplars().is_masked()) {
        let under = patch.places(term.constraint.guide.exemplars().sources()[patch.source].domain(), window);
        let unused = under.map(|place| place.is_some_and(|place| !term.uses(patch.source, place)));
        costs.iter_mut().zip(unused).filter(|(_, unused)| *unused).for_each(|(cost, _)| *cost = MOST_AGREEMENT);
    }
    Ok(())
}

/// `A'` of one sample at one place, by its definition: for maps that a run begins with. `[CMS IV-B3]`
pub(crate) fn of_sample(terms: &[Term<'_>], exemplars: &Exemplars<2>, at: [u32; 2], id: SampleId) -> i32 {
    let Some((source, from)) = exemplars.locate(id) else { return crate::constraint::DUMMY };
    let index = (id.get() - exemplars.table().first(source)) as usize;
    if !terms.iter().all(|term| term.uses(source, index)) {
        return MOST_AGREEMENT;
    }
    let patch = Patch { source, offset: [0, 1].map(|a| at[a] as i32 - from[a] as i32) };
    let window = Window { start: at.map(|p| p as i32), shape: [1, 1] };
    let one = |term: &Term<'_>| {
        let reached = term.taps.reached(&window);
        let mut values = vec![0; reached.len()];
        term.write(&patch, &reached, &mut values);
        let ratio = term.taps.ratio as usize;
        let wide = reached.shape[1] as usize;
        let rows = values.chunks(wide).step_by(ratio);
        term.scale.of_packed(rows.map(|row| row.iter().step_by(ratio).sum::<u64>()).sum())
    };
    price(terms.iter().map(one).fold(0, u64::saturating_add))
}
