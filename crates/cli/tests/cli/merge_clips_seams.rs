//! Seams of merged clips: how they are hidden, and that they bring no steps.

use selvedge_core::Samples;

use crate::graphcut::{samples, write};
use crate::merge_clips::{COLORS, paint};
use crate::program::Folder;

/// The largest step from frame to frame, beside that of both clips at the same place.
fn flicker(folder: &Folder, name: &str) -> f64 {
    let frames: Vec<_> = (1..=5).map(|t| samples(folder, &format!("{name}.{t:03}.png"))).collect();
    let steps = frames
        .windows(2)
        .flat_map(|two| (0..two[0].domain().len()).map(|i| (two[1].value(0, i) - two[0].value(0, i)).abs()));
    steps.fold(0.0, f64::max)
}

#[test]
fn seams_of_clips_are_blended_in_space_and_fused_in_time_as_well() {
    let folder = Folder::new("merge-clips-blended");
    // Two slopes that stand still, one of them brighter; a seam between moves by strokes.
    for (name, add) in [("a", 40), ("b", 100)] {
        for t in 0..5 {
            write(&folder, &format!("{name}.{:03}.png", t + 1), [24, 30], 3, |_, [y, x]| (add + 2 * x + y) as u8);
        }
    }
    (0..5).for_each(|t| paint(&folder, &format!("paint.{}.png", t + 1), 3 * t));
    let line = format!("merge a.###.png b.###.png --strokes paint.#.png {COLORS}");
    folder.run(&format!("{line} --label-map l.#.png -o cut.###.png")).done();
    for (options, name) in [("--feather 1.5", "feather"), ("--spline 2", "spline"), ("--fuse", "fuse")] {
        folder.run(&format!("{line} {options} -o {name}.###.png")).done();
    }
    let step = |name: &str, t: u32| {
        let frame = samples(&folder, &format!("{name}.{t:03}.png"));
        let of = |[y, x]: [u32; 2]| {
            (frame.value(0, (y * 30 + x + 1) as usize) - frame.value(0, (y * 30 + x) as usize)).abs()
        };
        (0..24).flat_map(|y| (0..29).map(move |x| [y, x])).map(of).fold(0.0, f64::max)
    };
    for t in 1..=5 {
        assert!(step("cut", t) > 50.0 && step("feather", t) < 25.0, "frame {t}: {}", step("feather", t));
        assert!(
            step("spline", t) < 25.0 && step("fuse", t) < 4.0,
            "frame {t}: {} {}",
            step("spline", t),
            step("fuse", t)
        );
        // A frame is what the pictures of that time are, by the same seam.
        let labels = samples(&folder, &format!("l.{t}.png"));
        for (number, name) in [(1.0, "left"), (2.0, "right")] {
            let shows = |[y, x]: [u32; 2]| labels.value(0, (y * 30 + x) as usize) == number;
            write(&folder, &format!("{name}.png"), [24, 30], 1, |_, at| if shows(at) { 255 } else { 0 });
        }
        let pictures = format!("merge a.{t:03}.png b.{t:03}.png --keep 1 left.png --keep 2 right.png");
        for (options, name) in [("--feather 1.5", "feather"), ("--spline 2", "spline")] {
            folder.run(&format!("{pictures} {options} -o one.png")).done();
            assert!(samples(&folder, "one.png") == samples(&folder, &format!("{name}.{t:03}.png")), "{options}, {t}");
        }
    }
    assert!(flicker(&folder, "cut") > 50.0 && flicker(&folder, "fuse") < 2.0, "{}", flicker(&folder, "fuse"));
    // What is kept is copied, here as it is with no blend.
    write(&folder, "keep.png", [24, 30], 1, |_, [y, _]| if y < 8 { 255 } else { 0 });
    folder.run(&format!("{line} --fuse --fuse-keep keep.png -o kept.###.png")).done();
    for t in 1..=5 {
        let [kept, cut] = ["kept", "cut"].map(|name| samples(&folder, &format!("{name}.{t:03}.png")));
        assert!((0..8 * 30).all(|i| kept.value(0, i) == cut.value(0, i)), "frame {t}");
        assert!((8 * 30..24 * 30).any(|i| kept.value(0, i) != cut.value(0, i)), "frame {t}");
    }
    folder.run(&format!("{line} --fuse-keep keep.png -o no.###.png")).refused(2, &["nothing is fused"]);
    folder.run(&format!("{line} --feather 20 -o no.###.png")).refused(2, &["0 to 16"]);
}

/// Steps from frame to frame, as root mean squares, and those of all pixels, from small to large.
fn steps(folder: &Folder, name: &str, frames: u32) -> [Vec<f64>; 2] {
    let frames: Vec<_> = (1..=frames).map(|t| samples(folder, &format!("{name}.{t:02}.png"))).collect();
    let steps = |two: &[Samples<2>]| -> Vec<f64> {
        (0..two[0].domain().len()).map(|i| (two[1].value(0, i) - two[0].value(0, i)).abs()).collect()
    };
    let by_frame: Vec<Vec<f64>> = frames.windows(2).map(steps).collect();
    let whole = |steps: &Vec<f64>| (steps.iter().map(|step| step * step).sum::<f64>() / steps.len() as f64).sqrt();
    let mut both = [by_frame.iter().map(whole).collect(), by_frame.concat()];
    both.iter_mut().for_each(|steps: &mut Vec<f64>| steps.sort_by(f64::total_cmp));
    both
}

#[test]
fn a_seam_moves_less_than_the_scene_and_adds_no_steps_to_it() {
    let folder = Folder::new("merge-clips-moves");
    // Two scenes of waves that go down by two pixels a frame, and sideways by one.
    let scene = |seed: f64, t: u32, [y, x]: [u32; 2]| {
        let (y, x) = (f64::from(y) - 2.0 * f64::from(t), f64::from(x) + f64::from(t));
        128.0
            + 60.0 * libm::sin(0.35 * x + seed) * libm::cos(0.28 * y + 2.0 * seed)
            + 40.0 * libm::sin(0.5 * (x + y) + 3.0 * seed)
    };
    for (name, seed) in [("a", 1.0), ("b", 2.3)] {
        for t in 0..12 {
            write(&folder, &format!("{name}.{:02}.png", t + 1), [40, 48], 1, |_, at| scene(seed, t, at).round() as u8);
        }
    }
    let stroke = |c: usize, [_, x]: [u32; 2]| match (x, c) {
        (0..6, 0 | 1) | (42.., 2) => 255,
        _ => 0,
    };
    write(&folder, "paint.png", [40, 48], 3, stroke);
    let line = format!("merge a.##.png b.##.png --strokes paint.png {COLORS} -o out.##.png --json");
    let moves = folder.run(&line).done().json()["stats"]["seam_moves"].as_f64().unwrap();
    assert!(0.0 < moves && moves < 2.0, "{moves}");
    let [[out, pixels], [a, pixels_a], [b, pixels_b]] = ["out", "a", "b"].map(|name| steps(&folder, name, 12));
    for (part, of) in [("median", 5), ("largest", 10)] {
        assert!(out[of] < 1.1 * a[of].max(b[of]), "{part} step: {} of {} and {}", out[of], a[of], b[of]);
    }
    // One in a thousand steps of a clip is larger than this one.
    let rare = pixels.len() * 999 / 1000;
    let rare = pixels_a[rare].max(pixels_b[rare]);
    let share = |steps: &[f64]| steps.iter().filter(|step| rare < **step).count() as f64 / steps.len() as f64;
    for t in 1..=12 {
        let line = format!("merge a.{t:02}.png b.{t:02}.png --strokes paint.png {COLORS} -o each.{t:02}.png");
        folder.run(&line).done();
    }
    let (made, each) = (share(&pixels), share(&steps(&folder, "each", 12)[1]));
    assert!(made < 0.002 && 3.0 * made < each, "{made} of all steps are larger, of frames merged one by one {each}");
}
