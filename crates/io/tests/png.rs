//! PNG: what is written is read again, bit for bit.

use selvedge_core::{Domain, Grid, Plane, Role, Samples, Seed};
use selvedge_io::{Density, DensityUnit, Metadata, ReadOptions, WriteOptions, decode, encode};

fn planes() -> Vec<Plane<2>> {
    let domain = Domain::open([5, 7]);
    let mut rng = Seed(1).rng();
    let mut planes = Vec::new();
    for channels in 1..=4 {
        let n = domain.len() * channels;
        let bytes = (0..n).map(|_| rng.below(256) as u8).collect();
        let words = (0..n).map(|_| rng.below(65_536) as u16).collect();
        for samples in [
            Samples::U8(Grid::from_vec(domain, channels, bytes).unwrap()),
            Samples::U16(Grid::from_vec(domain, channels, words).unwrap()),
        ] {
            planes.push(Plane { role: Role::Color, samples, alpha: channels % 2 == 0 });
        }
    }
    planes
}

#[test]
fn every_layout_and_depth_survives() {
    for plane in planes() {
        let bytes = encode(&plane, &Metadata::default(), "a.png", &WriteOptions::default()).unwrap();
        let picture = decode(&bytes, "a.png", &ReadOptions::default()).unwrap();
        assert_eq!(picture.plane, plane);
        assert_eq!(picture.warnings, []);
    }
}

#[test]
fn metadata_survive() {
    let mut profile = vec![7; 200];
    profile[16..20].copy_from_slice(b"RGB ");
    let metadata = Metadata {
        icc: Some(profile),
        srgb: None,
        gamma: Some(45_455),
        chromaticities: Some([0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06]),
        density: Some(Density { x: 2_835.0, y: 2_834.0, unit: DensityUnit::Metre }),
    };
    for plane in planes() {
        let bytes = encode(&plane, &metadata, "a.png", &WriteOptions::default()).unwrap();
        let found = decode(&bytes, "a.png", &ReadOptions::default()).unwrap().metadata;
        let expected =
            Metadata { icc: metadata.icc.clone().filter(|_| plane.color_channels() == 3), ..metadata.clone() };
        assert_eq!(found, expected);
    }
}
