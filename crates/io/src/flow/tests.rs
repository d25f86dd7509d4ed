//! Each format by its definition, and what is wrong with files.

use std::path::Path;

use selvedge_core::{Association, Plane, Role, Samples};

use super::*;
use crate::{Metadata, WriteOptions, encode};

fn flo(width: i32, height: i32, vectors: &[[f32; 2]]) -> Vec<u8> {
    let mut bytes = b"PIEH".to_vec();
    bytes.extend([width, height].iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(vectors.iter().flatten().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn read(bytes: &[u8], name: &str) -> Result<Flow, String> {
    let name = Path::new(name);
    decode(bytes, name, &ReadOptions::default()).map_err(|problem| Error::new(name, problem).to_string())
}

#[test]
fn flo_is_read_and_unknown_vectors_are_masked() {
    let flow = read(&flo(2, 1, &[[1.5, -2.0], [1e10, 0.0]]), "a.flo").unwrap();
    assert_eq!(flow.domain(), Domain::open([1, 2]));
    assert_eq!((flow.by.get(0, [0, 0]), flow.by.get(1, [0, 0])), (-2.0, 1.5));
    assert!(flow.is_known([0, 0]) && !flow.is_known([0, 1]));
}

#[test]
fn a_bad_flo_is_one_line() {
    let vectors = [[0.0; 2]; 6];
    let whole = flo(3, 2, &vectors);
    for cut in 1..whole.len() {
        assert!(read(&whole[..cut], "a.flo").unwrap_err().starts_with("'a.flo': "), "{cut}");
    }
    let wrong = |bytes: &[u8], text: &str| {
        let line = read(bytes, "a.flo").unwrap_err();
        assert!(line.contains(text) && line.lines().count() == 1, "{line}");
    };
    wrong(&whole[..59], "damaged flo file (59 of 60 bytes)");
    wrong(&[&whole[..], &[0]].concat(), "damaged flo file (61 of 60 bytes)");
    wrong(&flo(-3, 2, &vectors), "damaged flo file (-3x2 vectors)");
    wrong(&flo(0, 2, &[]), "0x2 px has no samples");
    wrong(&flo(70_000, 1, &[]), "over the cap");
    wrong(
        &flo(3, 2, &[[0.0, 0.0], [0.0, f32::NAN], [0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]]),
        "the first at x=1 y=0 in channel 1",
    );
    wrong(&[], "empty file");
    wrong(b"GIF89a", "is no flow");
}

fn picture(samples: Samples<2>, name: &str) -> Vec<u8> {
    let plane = Plane { role: Role::Scalar, samples, alpha: false, association: Association::default() };
    encode(&plane, &Metadata::default(), name, &WriteOptions::default()).unwrap()
}

#[test]
fn kitti_is_read() {
    let domain = Domain::open([1, 2]);
    let stored = Grid::from_vec(domain, 3, vec![32_768 + 96, 0, 32_768 - 64, 0, 1, 0]).unwrap();
    let flow = read(&picture(Samples::U16(stored), "a.png"), "a.png").unwrap();
    assert_eq!((flow.by.get(0, [0, 0]), flow.by.get(1, [0, 0])), (-1.0, 1.5));
    assert!(flow.is_known([0, 0]) && !flow.is_known([0, 1]));
    let eight = picture(Samples::U8(Grid::try_filled(domain, 3, 0).unwrap()), "a.png");
    assert!(read(&eight, "a.png").unwrap_err().contains("a PNG of 3 channel(s), u8"), "{:?}", read(&eight, "a.png"));
}

#[test]
fn vectors_of_exr_are_read() {
    let domain = Domain::open([1, 2]);
    let stored = Grid::from_vec(domain, 3, vec![1.5_f32, 2e9, -2.0, 0.0, 7.0, 7.0]).unwrap();
    let flow = read(&picture(Samples::F32(stored), "a.exr"), "a.exr").unwrap();
    assert_eq!((flow.by.get(0, [0, 0]), flow.by.get(1, [0, 0])), (-2.0, 1.5));
    assert!(!flow.is_known([0, 1]));
    let one = picture(Samples::F32(Grid::try_filled(domain, 1, 0.0).unwrap()), "a.exr");
    assert!(read(&one, "a.exr").unwrap_err().contains("holds one channel"));
}
