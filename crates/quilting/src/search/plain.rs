//! The search as the paper has it, block by block and sample by sample: what the fast one is held against.

use selvedge_core::{Domain, Exemplars, Guide, Source};

use super::*;

/// Looks at every sample of every block of every source.
pub(crate) struct PlainSearch<'e> {
    exemplars: &'e Exemplars<2>,
    guide: Option<&'e Guide<2>>,
}

impl<'e> PlainSearch<'e> {
    pub(crate) fn new(exemplars: &'e Exemplars<2>, guide: Option<&'e Guide<2>>) -> Self {
        Self { exemplars, guide }
    }

    fn all(&self, terms: &[Term<'_>]) -> Vec<Candidate> {
        let mut found = Vec::new();
        for (number, source) in self.exemplars.sources().iter().enumerate() {
            for at in source.domain().positions().filter(|&at| fits(source, terms[0].template.shape(), at)) {
                let error = |term: &Term<'_>| term.weight * self.error(number, term, at);
                found.push(Candidate { error: terms.iter().map(error).sum(), source: number, at });
            }
        }
        found
    }

    /// The weighted squared differences of one term.
    fn error(&self, source: usize, term: &Term<'_>, at: [u32; 2]) -> u64 {
        let space = match (term.space, self.guide) {
            (Space::Guide, Some(guide)) => guide.exemplars(),
            _ => self.exemplars,
        };
        let features = &space.sources()[source].features;
        let block = Domain::open(term.template.shape());
        let compared = |i: usize| term.template.mask().is_none_or(|mask| mask[i]);
        let mut error = 0;
        for (i, [y, x]) in block.positions().enumerate().filter(|&(i, _)| compared(i)) {
            for (c, &weight) in space.weights().iter().enumerate() {
                let sample = features.get(c, [at[0] + y, at[1] + x]);
                let d = sample.abs_diff(term.template.features()[c * block.len() + i]);
                error += u64::from(d).pow(2) * u64::from(weight);
            }
        }
        error
    }
}

/// False if the block sticks out or holds masked samples.
fn fits(source: &Source<2>, block: [u32; 2], at: [u32; 2]) -> bool {
    Domain::open(block).positions().all(|p| {
        let from = source.domain().step(at, p.map(|p| p as i32));
        from.is_some_and(|from| source.valid.as_deref().is_none_or(|v| v.get(0, from)))
    })
}

impl Search for PlainSearch<'_> {
    type Scratch = Vec<Candidate>;

    fn places(&self) -> u64 {
        self.exemplars.table().len().into()
    }

    fn near<'s>(
        &self,
        terms: &[Term<'_>],
        by: Within<'_>,
        avoid: Avoid<'_>,
        found: &'s mut Vec<Candidate>,
    ) -> Result<&'s [Candidate], Error> {
        let all = self.all(terms);
        *found = within(&all, by, |c| !avoid(c.source, c.at));
        if found.is_empty() {
            *found = within(&all, by, |_| true);
        }
        Ok(found)
    }
}

fn within(all: &[Candidate], by: Within<'_>, allow: impl Fn(&Candidate) -> bool) -> Vec<Candidate> {
    let mut near: Vec<Candidate> = all.iter().copied().filter(allow).collect();
    near.sort_unstable();
    let limit = near.first().map_or(0, |best| u128::from(best.error) * (1000 + u128::from(by(best))));
    near.retain(|c| u128::from(c.error) * 1000 <= limit);
    near.sort_unstable_by_key(|c| (c.source, c.at));
    near
}
