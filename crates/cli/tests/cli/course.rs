//! What the page of `graphcut --report` shows of seams that become cheaper.

use std::fs;

use selvedge_core::{Exemplars, Grid, Plane, Role, Samples, SeamCosts, SeamMeasure, SourceMap};
use selvedge_io::{ReadOptions, decode};

use crate::graphcut::{energy, map, samples};
use crate::program::Folder;

/// The pictures of seam costs on a page: number of the refinement, price of all seams, samples.
fn steps(page: &str) -> Vec<(usize, i64, Grid<u8, 2>)> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let decoded = |text: &str| -> Vec<u8> {
        let digits: Vec<u32> = text.bytes().filter(|c| *c != b'=').map(|c| digit(c).into()).collect();
        let bits = digits.chunks(4).map(|four| (four.len(), (0..4).fold(0, |b, i| b << 6 | four.get(i).unwrap_or(&0))));
        bits.flat_map(|(n, bits): (usize, u32)| bits.to_be_bytes()[1..n].to_vec()).collect()
    };
    let figures = page.split("<img alt=\"Seam costs, ").skip(1);
    let step = |figure: &str| {
        let data = figure.split_once("base64,").unwrap().1.split_once('"').unwrap().0;
        let caption = figure.split_once("<figcaption>").unwrap().1.split_once('<').unwrap().0;
        let (when, energy) = caption.split_once(": ").unwrap();
        let refinement = if when == "covered" { 0 } else { when.strip_prefix("refinement ").unwrap().parse().unwrap() };
        let plane = decode(&decoded(data), "step.png", &ReadOptions::default()).unwrap().plane;
        let Samples::U8(grid) = plane.samples else { panic!("8 bits") };
        (refinement, energy.parse().unwrap(), grid)
    };
    figures.map(step).collect()
}

#[test]
fn the_report_shows_what_seams_cost_after_refinements() {
    let folder = Folder::new("graphcut-course");
    let line = "graphcut @/stars.png --seam difference --placement sub --region 16 --patience 30";
    let small = format!("{line} --size 70x60 --refine 20");
    let said = folder.run(&format!("{small} -o a.png --map a.exr --report page --json")).done();
    let written: Vec<String> =
        said.json()["outputs"].as_array().unwrap().iter().map(|o| o["path"].to_string()).collect();
    assert_eq!(written.len(), 3, "the pictures are inside of the page: {written:?}");
    assert_eq!(fs::read_dir(folder.path("page")).unwrap().count(), 1);
    let page = fs::read_to_string(folder.path("page/index.html")).unwrap();
    let energy = energy(&said);
    let changes: Vec<usize> = (0..energy.len()).filter(|&i| i == 0 || energy[i] != energy[i - 1]).collect();
    let found = steps(&page);
    assert!((4..=24).contains(&changes.len()), "{energy:?}");
    assert_eq!(found.iter().map(|s| s.0).collect::<Vec<_>>(), changes, "each that changed something");
    assert!(found.iter().all(|(n, e, _)| energy[*n] == *e));
    let curve = page.split_once("<polyline points=\"").unwrap().1.split_once('"').unwrap().0;
    assert_eq!(curve.split_whitespace().count(), energy.len());

    // The pictures against the definition: the dearest seam at each place, on the scale of the first picture.
    let stars = samples(&folder, "@/stars.png");
    let stars = Plane::new(Role::Color, stars);
    let exemplars = Exemplars::of(&[std::slice::from_ref(&stars)]).unwrap();
    let costs = SeamCosts::new(&exemplars, SeamMeasure::Difference).unwrap();
    let prices = |map: &SourceMap<2>| -> Vec<f64> {
        let dearest = |at| f64::from((0..2).map(|axis| costs.at(map, at, axis)).max().unwrap());
        map.domain().positions().map(dearest).collect()
    };
    folder.run(&format!("{line} --size 70x60 --refine 0 -o b.png --map b.exr")).done();
    let (first, last) = (prices(&map(&folder, "b.exr").map), prices(&map(&folder, "a.exr").map));
    let mut seams: Vec<f64> = first.iter().copied().filter(|price| 0.0 < *price).collect();
    seams.sort_by(f64::total_cmp);
    let white = seams[seams.len() * 49 / 50];
    for (prices, picture) in [(&first, &found[0].2), (&last, &found.last().unwrap().2)] {
        let tones: Vec<u8> = prices.iter().map(|p| (255.0 * (p / white).sqrt()).min(255.0) as u8).collect();
        assert_eq!(picture.samples(), tones);
    }

    // A long run: some of them, evenly spread, and the last.
    let said = folder.run(&format!("{line} --size 420x300 --refine 900 -o c.png --report page --json")).done();
    let energy = self::energy(&said);
    let changes: Vec<usize> = (0..energy.len()).filter(|&i| i == 0 || energy[i] != energy[i - 1]).collect();
    let found = steps(&fs::read_to_string(folder.path("page/index.html")).unwrap());
    assert!(48 < changes.len() && (12..=25).contains(&found.len()), "{} of {}", found.len(), changes.len());
    let places: Vec<usize> = found.iter().map(|s| changes.binary_search(&s.0).unwrap()).collect();
    let every = places[1];
    assert!(places[..places.len() - 1].iter().enumerate().all(|(i, p)| *p == i * every), "{places:?}");
    assert_eq!(found.last().unwrap().1, *energy.last().unwrap());
    assert_eq!(found[0].2.domain().shape, [150, 210], "reduced");

    // Counted before the work.
    let needed = |options: &str| {
        let said = folder.run(&format!("{line} --size 400 -o d.png --dry-run --json {options}")).done();
        said.json()["estimated_memory_bytes"].as_u64().unwrap()
    };
    assert!(needed("") + 400 * 400 < needed("--report page"));
}
