//! Whether what lies under the exemplars covers what is asked for: told before the work, and drawn. `[CMS V-H]`

use std::path::Path;

use selvedge_cms_analogies::Fitness;
use selvedge_core::{Grid, Plane, Role, Samples};
use serde_json::Value;

use crate::failure::Failure;
use crate::session::Session;
use crate::thumbnail::Thumbnail;

/// From this share on it is told. Of examples that others publish because they work it is 0 to 0.17, of a photograph by
/// day that a painting of a night is to lead 0.9.
const TOLD: f64 = 0.25;
/// Over what nothing is like.
const UNCOVERED: [u8; 3] = [255, 40, 40];

/// Warns where much of a target is like nothing under the exemplars; `alike` says what brings them nearer.
pub(in crate::commands) fn warn(session: &Session<'_>, path: &Path, fitness: &Fitness, alike: &str) {
    if fitness.uncovered.is_some_and(|share| TOLD <= share) {
        let what = format!("use pictures that are alike ({alike}), more exemplars or a smaller -N");
        session.warn(path, &format!("{}: {what}", told(fitness)));
    }
}

/// In words.
pub(in crate::commands) fn told(fitness: &Fitness) -> String {
    let side = fitness.side;
    match fitness.uncovered.map(|share| 100.0 * share) {
        Some(share) => {
            format!("{share:.0} % of it is like nothing under the exemplars ({side} px squares are compared)")
        }
        None => format!("whether it is like what lies under the exemplars cannot be told ({side} px squares)"),
    }
}

/// Of a run's JSON.
pub(in crate::commands) fn json(fitness: &Fitness) -> Value {
    // Thousandths of a share and of a grey level.
    let rounded = |v: f64| if v.is_finite() { Value::from((v * 1e3).round() / 1e3) } else { Value::Null };
    serde_json::json!({
        "uncovered": fitness.uncovered.map(rounded), "limit": rounded(fitness.limit), "side": fitness.side,
    })
}

/// What pictures of it stand under.
pub(in crate::commands) const HEADING: &str = "Followed, red where nothing under the exemplars is like it";

/// A target with red over what nothing is like.
pub(in crate::commands) fn drawn(path: &Path, target: &Grid<u8, 2>, fitness: &Fitness) -> Result<Thumbnail, Failure> {
    let mut picture = Grid::try_filled(target.domain(), 3, 0)?;
    for at in target.domain().positions() {
        let is_uncovered = fitness.is_uncovered(at);
        for (c, red) in UNCOVERED.into_iter().enumerate() {
            let own = target.get(c.min(target.channels() - 1), at);
            picture.set(c, at, if is_uncovered { u8::midpoint(own / 2, red) } else { own });
        }
    }
    let caption = format!("{}: {}", selvedge_io::display_name(path), told(fitness));
    Ok(Thumbnail { picture: Plane::new(Role::Color, Samples::U8(picture)), caption })
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Domain;

    #[test]
    fn what_nothing_is_like_is_red() {
        let target = Grid::from_vec(Domain::open([1, 4]), 1, vec![10; 4]).unwrap();
        let differences = Grid::from_vec(Domain::open([1, 2]), 1, vec![1.0, 9.0]).unwrap();
        let fitness = Fitness { uncovered: Some(0.5), limit: 5.0, differences, side: 2 };
        let Thumbnail { picture, caption } = drawn(Path::new("a/b.png"), &target, &fitness).unwrap();
        let Samples::U8(grid) = picture.samples else { unreachable!() };
        assert_eq!([1, 2].map(|x| [0, 1, 2].map(|c| grid.get(c, [0, x]))), [[10; 3], [130, 22, 22]]);
        assert_eq!(caption, "b.png: 50 % of it is like nothing under the exemplars (2 px squares are compared)");
        assert_eq!(json(&Fitness { limit: f64::INFINITY, ..fitness })["limit"], Value::Null);
    }
}
