//! The part of a frame that has a choice.

use selvedge_core::{Domain, Window};

use crate::choice::Choice;

/// The box that holds all free samples, in the frame's own coordinates; `None` if there are none.
pub(crate) fn span<const D: usize>(shape: [u32; D], choices: &[Choice]) -> Option<Window<D>> {
    let (mut low, mut high) = ([u32::MAX; D], [0; D]);
    let domain = Domain::open(shape);
    let row = shape[D - 1] as usize;
    for (r, cells) in choices.chunks(row).enumerate() {
        let Some(first) = cells.iter().position(|&c| c == Choice::Free) else { continue };
        let last = cells.iter().rposition(|&c| c == Choice::Free).unwrap_or(first);
        let mut at = domain.position(r * row);
        for x in [first, last] {
            at[D - 1] = x as u32;
            low = std::array::from_fn(|a| low[a].min(at[a]));
            high = std::array::from_fn(|a| high[a].max(at[a]));
        }
    }
    let shape = std::array::from_fn(|a| (high[a] + 1).saturating_sub(low[a]));
    (low[0] != u32::MAX).then(|| Window { start: low.map(|l| l as i32), shape })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_tight() {
        let mut choices = [Choice::Old; 20];
        assert_eq!(span([4, 5], &choices), None);
        choices[7] = Choice::Free;
        assert_eq!(span([4, 5], &choices), Some(Window { start: [1, 2], shape: [1, 1] }));
        (choices[6], choices[14]) = (Choice::Free, Choice::Free);
        assert_eq!(span([4, 5], &choices), Some(Window { start: [1, 1], shape: [2, 4] }));
    }
}
