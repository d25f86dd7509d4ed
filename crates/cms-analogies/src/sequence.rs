//! Frame after frame: what the one before shows, moved, is where the next one begins, and what it is to look like.
//!
//! Frames that are made each by itself flicker, since labels that agree alike are many and each frame takes others.
//! LazyFluids' and ebsynth's users have their frame before as one more guide; here its labelling is gone on from too,
//! so that where nothing has changed nothing is searched.

use selvedge_core::{Direction, Exemplars, Flow, Grid, Guide, Look, SampleId, SourceMap, Window};

use crate::constraint::Constraint;
use crate::error::Error;

/// The labelling of the next frame as that of the one before has it: every sample where the flow takes it, to whole
/// samples. Nothing where something comes into sight. Without a flow nothing moves.
///
/// # Errors
/// [`Error::Flow`] if the flow is not of the map's shape, and no memory.
///
/// # Complexity
/// `O(samples)`.
pub fn carried(map: &SourceMap<2>, flow: Option<&Flow>, direction: Direction) -> Result<SourceMap<2>, Error> {
    let output = map.domain();
    let mut ids = map.ids.map(|id| id)?;
    if let Some(flow) = flow {
        let (expected, found) = (output.shape, flow.domain().shape);
        if expected != found {
            return Err(Error::Flow { expected: expected.to_vec(), found: found.to_vec() });
        }
        for (id, from) in ids.samples_mut().iter_mut().zip(flow.came_from(direction)?) {
            *id = match from.is_sure {
                true => map.ids.get(0, from.nearest(output).0),
                false => SampleId::UNASSIGNED,
            };
        }
    }
    Ok(SourceMap { ids, table: map.table.clone() })
}

/// What a map shows as a constraint: under the exemplars are their own features, and nothing is asked for where nothing
/// stands.
///
/// # Errors
/// No memory.
///
/// # Panics
/// If the map is of other exemplars.
pub fn as_shown(exemplars: &Exemplars<2>, map: &SourceMap<2>, weight: f64) -> Result<Constraint, Error> {
    assert_eq!(map.table, *exemplars.table(), "a map of these exemplars");
    let (output, mut look) = (map.domain(), Look::new());
    look.at_map(exemplars, map, &Window::all(output), |_| true)?;
    let mut target = Grid::try_filled(output, exemplars.channels(), 0)?;
    target.samples_mut().copy_from_slice(look.features());
    let mut asked = Grid::try_filled(output, 1, false)?;
    asked.samples_mut().copy_from_slice(look.known());
    Ok(Constraint { weight, ..Constraint::new(Guide::of_look(exemplars, target)?.asking(asked)?) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{Case, case};
    use crate::{Options, analogy_from};
    use selvedge_core::{Domain, Run, Start};

    /// Every sample of a case one sample further down and two to the right, and the map that is carried there.
    fn moved(case: &Case, map: &SourceMap<2>) -> (Flow, SourceMap<2>) {
        let output = map.domain();
        let samples = [vec![1.0; output.len()], vec![2.0; output.len()]].concat();
        let flow = Flow { by: Grid::from_vec(output, 2, samples).unwrap(), known: None };
        let next = carried(map, Some(&flow), Direction::Forward).unwrap();
        assert_eq!(next.table, *case.exemplars.table());
        (flow, next)
    }

    #[test]
    fn labels_go_where_the_flow_takes_them_and_what_comes_into_sight_is_open() {
        for seed in 0..20 {
            let case = case(seed);
            let (map, _) = case.weave(true);
            let (flow, next) = moved(&case, &map);
            let output = map.domain();
            for at in output.positions() {
                let from = output.step(at, [-1, -2]);
                let expected = from.map_or(SampleId::UNASSIGNED, |from| map.ids.get(0, from));
                assert_eq!(next.ids.get(0, at), expected, "{seed} {at:?}");
            }
            // The same by a field that says where samples come from.
            let back = Flow { by: flow.by.map(|v| -v).unwrap(), known: None };
            assert_eq!(carried(&map, Some(&back), Direction::Backward).unwrap(), next);
            assert_eq!(carried(&map, None, Direction::Forward).unwrap(), map);
            // Where it is unknown, nothing is.
            let known = Grid::try_filled(output, 1, false).unwrap();
            let none = carried(&map, Some(&Flow { known: Some(known), ..flow }), Direction::Forward).unwrap();
            assert_eq!(none.holes(), output.len());
        }
        let case = case(0);
        let (map, _) = case.weave(true);
        let flow = Flow { by: Grid::try_filled(Domain::open([3, 4]), 2, 0.0).unwrap(), known: None };
        let expected = map.domain().shape.to_vec();
        let wrong = carried(&map, Some(&flow), Direction::Forward);
        assert_eq!(wrong, Err(Error::Flow { expected, found: vec![3, 4] }));
    }

    /// What a frame shows agrees with it to the last sample, and what is laid has to.
    #[test]
    fn a_frame_that_is_gone_on_from_is_followed() {
        for seed in 0..20 {
            let mut case = case(seed);
            let (map, _) = case.weave(true);
            let weight = 1e4 / case.options.constraint_weight.max(1.0);
            let shown = as_shown(&case.exemplars, &map, weight).unwrap();
            assert_eq!(shown.guide.asked().unwrap().samples().iter().filter(|a| **a).count(), map.domain().len());
            case.constraints = vec![shown];
            // Samples by themselves: over neighborhoods labels of other pieces may agree better.
            let (constraint_weight, neighborhood) = (case.options.constraint_weight.max(0.1), 0);
            let options = Options { constraint_weight, neighborhood, spread: 0.0, ..case.options };
            let start = Start { map: carried(&map, None, Direction::Forward).unwrap(), fixed: None, sources: None };
            let again = analogy_from(&case.exemplars, &case.constraints, &start, &options, &Run::seeded(0)).unwrap();
            assert_eq!(again.stats.truth.agreement, 0, "{seed}");
        }
    }
}
