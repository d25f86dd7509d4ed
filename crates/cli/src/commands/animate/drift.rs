//! Whether a texture that flows stays what it was.

use serde_json::Value;

/// Frames at the end whose mean is looked at: one by one they differ.
const LAST: usize = 4;
/// From which part of the first frames' on a loss is told, and from how many times the energy of frames a third of the
/// way on: the first ones are whole patches of the exemplar, which whatever flows leaves behind. Over 30 frames of
/// pebbles, olives, bricks and scales in a vortex and a sink, all of which look as they did, sharpness falls to 0.88 of
/// the first at most, completeness not at all, and energy rises to 1.5 times.
const SHARPNESS: f64 = 0.8;
const COMPLETENESS: f64 = 0.5;
const ENERGY: f64 = 2.0;

/// What is warned of, by the counts of all frames in order.
pub(super) fn told(frames: &[Value]) -> Option<String> {
    let mean = |of: &[Value], key: &str| {
        let all: Vec<f64> = of.iter().filter_map(|frame| frame[key].as_f64()).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    };
    let third = frames.len() / 3;
    let (first, begun, last) = (frames.get(..2)?, frames.get(third..third + LAST)?, &frames[frames.len() - LAST..]);
    let fell = |key: &str, least: f64| {
        Some((mean(first, key)?, mean(last, key)?)).filter(|&(begun, ended)| ended < least * begun)
    };
    let what = if let Some((begun, ended)) = fell("sharpness", SHARPNESS) {
        format!("its last frames are {:.0} % as sharp as its first", 100.0 * ended / begun)
    } else if let Some((begun, ended)) = fell("completeness", COMPLETENESS) {
        let percent = |share: f64| 100.0 * share;
        format!("its last frames show {:.0} % of the exemplar, its first {:.0} %", percent(ended), percent(begun))
    } else {
        let (begun, ended) = (mean(begun, "energy")?, mean(last, "energy")?);
        if begun <= 0.0 || ended <= ENERGY * begun {
            return None;
        }
        format!("its last frames are {:.1} times as far from the exemplar as those a third on", ended / begun)
    };
    Some(format!("{what}: use a smaller --lambda, more --iterations or fewer --frames"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_washes_out_is_told_and_what_stays_is_not() {
        let frames = |ends: [f64; 3]| {
            let frame = |i: u32| {
                let by = |end: f64| 1.0 + (end - 1.0) * f64::from(i) / 19.0;
                let energy = if i == 0 { Value::Null } else { (9.0 * by(ends[2])).into() };
                json!({ "sharpness": by(ends[0]), "completeness": by(ends[1]), "energy": energy })
            };
            (0..20).map(frame).collect::<Vec<_>>()
        };
        assert_eq!(told(&frames([0.9, 0.8, 1.5])), None);
        let about = |ends: [f64; 3], word: &str| {
            let told = told(&frames(ends)).unwrap();
            assert!(told.contains(word) && told.ends_with("fewer --frames"), "{told}");
        };
        about([0.5, 0.9, 1.0], "as sharp");
        about([1.0, 0.2, 1.0], "of the exemplar, its first");
        about([1.0, 0.9, 9.0], "times as far");
        assert_eq!(told(&frames([0.5, 0.2, 9.0])[..3]), None, "too few to tell");
    }
}
