//! The weighted sum of several searches in one go: an overlap, what lies under a block, a guide.

use crate::direct::{self, DirectScratch, Weighted};
use crate::job::Job;
use crate::memory::push;
use crate::placement::Range;
use crate::prepared::Prepared;
use crate::searcher::prefers_fft;
use crate::template::Checked;
use crate::{Costs, Cover, Error, Placement, Scratch, SsdSearcher, Template, cover};
use selvedge_core::{collected, par};

/// One search of a sum.
#[derive(Clone, Copy, Debug)]
pub struct Term<'a, 'e, const D: usize> {
    /// Where the template is searched. All searchers of a sum have sources of the same sizes.
    pub searcher: &'a SsdSearcher<'e, D>,
    /// All templates of a sum have one shape.
    pub template: Template<'a, D>,
    /// How often its errors count.
    pub weight: u64,
}

/// Working memory of sums. Keep one: after the first sum of a size no large buffer is allocated.
#[derive(Debug, Default)]
pub struct SumScratch<const D: usize> {
    parts: Vec<Part<D>>,
    /// Of each weight.
    direct: Vec<DirectScratch>,
    own: Scratch,
}

/// One search by itself.
#[derive(Debug, Default)]
struct Part<const D: usize> {
    scratch: Scratch,
    costs: Costs<D>,
    failed: Option<Error>,
}

impl<const D: usize> SumScratch<D> {
    /// Empty; grows with the first sum.
    pub fn new() -> Self {
        Self::default()
    }
}

/// Becomes the weighted sum of the costs of several searches: at each position the sum of `weight * error`. What is no
/// candidate of one of them is none of the sum.
///
/// The same as as many calls of [`SsdSearcher::search`] and one of [`Costs::sum_of`]. Where the direct engine answers
/// all of them and samples of the box must be valid ([`Cover::Box`]), it is several times as fast for small templates:
/// no map but the sum's is written, and templates of one searcher with one weight are multiplied as one.
///
/// # Errors
/// Those of [`SsdSearcher::search`], [`Error::Mismatch`] if shapes of templates or sources differ, and
/// [`Error::Overflow`] if a sum could pass 64 bits.
pub fn search_sum<const D: usize>(
    terms: &[Term<'_, '_, D>],
    placement: Placement,
    scratch: &mut SumScratch<D>,
    costs: &mut Costs<D>,
) -> Result<(), Error> {
    match terms {
        [] => costs.sum_of(&[]),
        [Term { searcher, template, weight: 1 }] => searcher.search(template, placement, &mut scratch.own, costs),
        _ => sum(terms, placement, scratch, costs),
    }
}

/// Templates of one searcher whose errors count equally often.
struct Merged<'a, 'e, const D: usize> {
    searcher: &'a SsdSearcher<'e, D>,
    templates: Vec<Checked<'a>>,
    weight: u64,
    /// No sum of their errors is larger.
    bound: u128,
}

impl<'a, 'e, const D: usize> Merged<'a, 'e, D> {
    fn list(terms: &[Term<'a, 'e, D>], checked: &[Checked<'a>]) -> Result<Vec<Self>, Error> {
        let mut list: Vec<Self> = Vec::new();
        for (term, &template) in terms.iter().zip(checked) {
            let bound = term.searcher.bound(template.samples);
            let same = |m: &&mut Self| {
                std::ptr::eq(m.searcher, term.searcher) && m.weight == term.weight && is_narrow(m.bound + bound)
            };
            if let Some(merged) = list.iter_mut().find(same) {
                push(&mut merged.templates, template)?;
                merged.bound += bound;
            } else {
                let (searcher, weight) = (term.searcher, term.weight);
                push(&mut list, Self { searcher, templates: vec![template], weight, bound })?;
            }
        }
        Ok(list)
    }

    /// What the engine is told about a source, ready but for what is prepared of it.
    fn job<'j>(&'j self, number: usize, range: Range, prepared: &'j Prepared, template: &'j Checked<'a>) -> Job<'j> {
        self.searcher.job(number, range, Cover::Box, prepared, template)
    }
}

/// True if 32 bits hold such errors.
fn is_narrow(bound: u128) -> bool {
    bound < u128::from(u32::MAX)
}

fn sum<const D: usize>(
    terms: &[Term<'_, '_, D>],
    placement: Placement,
    scratch: &mut SumScratch<D>,
    costs: &mut Costs<D>,
) -> Result<(), Error> {
    let first = terms[0].searcher;
    let mut checked = Vec::new();
    for term in terms {
        push(&mut checked, term.template.check(term.searcher.channels())?)?;
    }
    let shape = checked[0].shape;
    if terms.iter().zip(&checked).any(|(t, c)| c.shape != shape || !t.searcher.has_shapes_of(first)) {
        return Err(Error::Mismatch);
    }
    let merged = Merged::list(terms, &checked)?;
    if placement.cover != Cover::Box
        || merged.iter().any(|m| !m.searcher.has_validity_of(first))
        || merged.iter().any(|m| !is_narrow(m.bound) || u64::from(u32::MAX) < m.weight)
    {
        return one_by_one(terms, placement, scratch, costs);
    }
    let ranges: Vec<Range> = collected(first.ranges(placement.positions, shape))?;
    let mut prepared = Vec::new();
    for (number, range) in ranges.iter().enumerate() {
        for m in &merged {
            push(&mut prepared, m.searcher.prepared(number, range, shape)?)?;
        }
    }
    let mut jobs = Vec::new();
    for (number, (&range, prepared)) in ranges.iter().zip(prepared.chunks(merged.len())).enumerate() {
        for (m, prepared) in merged.iter().zip(prepared) {
            let job = |template| m.job(number, range, prepared, template);
            if m.templates.iter().any(|t| prefers_fft(&job(t), m.searcher.engine())) {
                return one_by_one(terms, placement, scratch, costs);
            }
            let (job, templates, weight) = (job(&m.templates[0]), &m.templates[..], m.weight as u32);
            push(&mut jobs, Weighted { job, templates, weight })?;
        }
    }
    let bound = merged.iter().map(|m| m.bound * u128::from(m.weight)).sum::<u128>();
    let samples = checked.iter().map(|c| c.samples).max().unwrap_or(0);
    costs.reset_sum(&ranges, samples, bound, first.kernel())?;
    scratch.direct.resize_with(merged.len().max(scratch.direct.len()), DirectScratch::default);
    for (number, jobs) in jobs.chunks(merged.len()).enumerate() {
        let map = costs.sum_mut(number);
        if !map.is_empty() {
            direct::search_sum(jobs, &mut scratch.direct, map)?;
            cover::apply(&jobs[0].job, direct::BIAS, false, &mut scratch.own.cover, map, &mut [])?;
        }
    }
    Ok(())
}

/// Each search by itself, and their sum.
fn one_by_one<const D: usize>(
    terms: &[Term<'_, '_, D>],
    placement: Placement,
    scratch: &mut SumScratch<D>,
    costs: &mut Costs<D>,
) -> Result<(), Error> {
    scratch.parts.resize_with(terms.len().max(scratch.parts.len()), Part::default);
    let parts = &mut scratch.parts[..terms.len()];
    // Some searches are too short to be split, but not too short to run beside each other.
    par::for_rows(parts, 1, |number, part| {
        let (Term { searcher, template, .. }, part) = (&terms[number], &mut part[0]);
        part.failed = searcher.search(template, placement, &mut part.scratch, &mut part.costs).err();
    });
    if let Some(error) = parts.iter_mut().find_map(|part| part.failed.take()) {
        return Err(error);
    }
    let weighted = collected(terms.iter().map(|t| t.weight).zip(parts.iter().map(|p| &p.costs)))?;
    costs.sum_of(&weighted)
}
