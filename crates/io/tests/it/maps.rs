//! Source maps as files.

use crate::common::made;
use selvedge_core::{Domain, Grid, Limits, Origin, SampleId, Seed, SourceMap, SourceTable, Transform};
use selvedge_io::{Fingerprint, MapFile, Problem, ReadOptions, decode, decode_map, encode_map, probe_bytes};

fn map(periodic: [bool; 2]) -> MapFile {
    let origin =
        |exemplar, quarter_turns, mirror| Origin { exemplar, transform: Transform::Exact { quarter_turns, mirror } };
    let resampled =
        |exemplar, degrees, scale, mirror| Origin { exemplar, transform: Transform::new(degrees, scale, mirror) };
    let sources = vec![
        (origin(0, 0, false), Domain::open([5, 7])),
        (origin(0, 1, true), Domain { shape: [7, 5], periodic: [true, false] }),
        (origin(2, 3, false), Domain::periodic([300, 200])),
        (resampled(0, 29.999_999_999_999_996, 0.1 + 0.2, true), Domain::open([4, 5])),
        (resampled(2, 0.0, 1.0 / 3.0, false), Domain::open([1, 1])),
    ];
    let table = SourceTable::new(sources).unwrap();
    let domain = Domain { shape: [40, 30], periodic };
    let mut rng = Seed(3).rng();
    let mut id = |_| if rng.below(5) == 0 { SampleId::UNASSIGNED } else { SampleId::new(rng.below(table.len())) };
    let ids = Grid::from_vec(domain, 1, (0..domain.len()).map(&mut id).collect()).unwrap();
    let name = |name: &str| Fingerprint { name: name.into(), blake3: format!("{:064x}", name.len()) };
    let exemplars = vec![name("brick name=x é.png"), Fingerprint::default(), name("c.exr")];
    MapFile::new(SourceMap::new(ids, table).unwrap(), exemplars, made())
}

#[test]
fn maps_are_read_again_with_their_topology() {
    for periodic in [[false, false], [false, true], [true, false], [true, true]] {
        let file = map(periodic);
        let bytes = encode_map(&file, "m.exr").unwrap();
        assert_eq!(bytes, encode_map(&file, "m.exr").unwrap(), "equal maps, equal files");
        assert_eq!(decode_map(&bytes, "m.exr", &Limits::default()).unwrap(), file);
    }
}

#[test]
fn a_map_is_no_picture_and_a_picture_no_map() {
    let bytes = encode_map(&map([false; 2]), "m.exr").unwrap();
    let refused = decode(&bytes, "m.exr", &ReadOptions::default()).unwrap_err();
    assert_eq!(refused.to_string(), "'m.exr': is a source map, no picture; give a picture, or apply the map to one");
    assert!(matches!(probe_bytes(&bytes, "m.exr", &ReadOptions::default()).unwrap_err().problem, Problem::IsAMap));

    let plane = crate::common::plane(selvedge_core::Depth::F16, 3, false, [4, 4]);
    let picture = selvedge_io::encode(&plane, &made(), "p.exr", &Default::default()).unwrap();
    let refused = decode_map(&picture, "p.exr", &Limits::default()).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "'p.exr': is no source map; it holds channels B, G, R; give a file that was written as a map"
    );
    assert!(decode_map(b"\x89PNG\r\n\x1a\n", "p.png", &Limits::default()).is_err());
    assert!(decode_map(b"", "p.png", &Limits::default()).is_err());
}

#[test]
fn sources_that_cannot_be_are_refused() {
    // A scale of 0 as long as the one that was written.
    let bytes = encode_map(&map([false; 2]), "m.exr").unwrap();
    let (from, to) = (b"scale=0.3333333333333333", b"scale=0.0000000000000000");
    let at = bytes.windows(from.len()).position(|w| w == from).expect("attributes are not packed");
    let mut wrong = bytes;
    wrong[at..at + to.len()].copy_from_slice(to);
    let refused = decode_map(&wrong, "m.exr", &Limits::default()).unwrap_err().to_string();
    assert!(refused.contains("its list of sources"), "{refused}");
}

#[test]
fn missing_exemplars_are_counted() {
    let mut file = map([false; 2]);
    file.exemplars.truncate(2);
    let refused = encode_map(&file, "m.exr").unwrap_err();
    assert!(matches!(refused.problem, Problem::ExemplarCount { found: 2, needed: 3 }));
}

#[test]
fn cut_and_mutated_maps_are_errors_or_maps() {
    let bytes = encode_map(&map([true; 2]), "m.exr").unwrap();
    let mut rng = Seed(4).rng();
    for end in (0..bytes.len()).step_by(7) {
        assert!(decode_map(&bytes[..end], "m.exr", &Limits::default()).is_err());
    }
    for _ in 0..3_000 {
        let mut mutant = bytes.clone();
        // The header, where the list of sources is, more often than the packed rows.
        let reach = if rng.below(2) == 0 { 1_000 } else { bytes.len() as u32 };
        mutant[rng.below(reach) as usize] = b"0129 =\n\xff"[rng.below(8) as usize];
        if let Ok(file) = decode_map(&mutant, "m.exr", &Limits { samples: 1 << 20, ..Limits::default() }) {
            let known = |id: &SampleId| !id.is_assigned() || file.map.table.locate(*id).is_some();
            assert!(file.map.ids.plane(0).iter().all(known));
        }
    }
}

#[test]
fn a_source_that_no_picture_may_have_is_refused_with_its_size() {
    let domain = Domain::open([65_535, 65_535]);
    let table = SourceTable::new(vec![(Origin { exemplar: 0, transform: Transform::IDENTITY }, domain)]).unwrap();
    let ids = Grid::try_filled(Domain::open([2, 2]), 1, SampleId::UNASSIGNED).unwrap();
    let exemplars = vec![Fingerprint { name: "a".repeat(9_000), blake3: "00".into() }];
    let file = MapFile::new(SourceMap::new(ids, table).unwrap(), exemplars, made());
    let refused = decode_map(&encode_map(&file, "m.exr").unwrap(), "m.exr", &Limits::default()).unwrap_err();
    assert!(refused.to_string().contains("65535x65535 px"), "{refused}");
}
