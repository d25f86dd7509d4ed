//! What is written is read again, bit for bit, with what the file says besides.

use crate::common::{bits, made, plane, profile};
use selvedge_core::{Depth, Domain, Grid, Plane, Role, Samples};
use selvedge_io::{
    Density, DensityUnit, ErrorKind, Format, Metadata, Picture, Problem, ReadOptions, Warning, WriteOptions,
};
use selvedge_io::{decode, encode, probe_bytes};

const LOSSLESS: [Format; 5] = [Format::Png, Format::Tiff, Format::Exr, Format::Webp, Format::Tga];

fn write(plane: &Plane<2>, metadata: &Metadata, format: Format) -> Vec<u8> {
    let name = format!("a.{format}");
    let bytes = encode(plane, metadata, &name, &WriteOptions::default()).unwrap();
    assert_eq!(bytes, encode(plane, metadata, &name, &WriteOptions::default()).unwrap(), "equal runs, equal files");
    bytes
}

fn read(bytes: &[u8], format: Format) -> Picture {
    let picture = decode(bytes, format!("a.{format}"), &ReadOptions::default()).unwrap();
    assert_eq!((picture.format, &picture.warnings[..]), (format, &[][..]));
    picture
}

/// As other programs write it: rows from below, a palette, and 16 bits for a pixel.
#[test]
fn tga_of_others_is_read() {
    let header = |palette: [u8; 5], kind: u8, bits: u8, descriptor: u8| {
        let [origin, _, length, _, entry] = palette;
        let map = [origin, 0, length, 0, entry];
        [&[0, u8::from(length != 0), kind][..], &map, &[0, 0, 0, 0, 2, 0, 2, 0, bits, descriptor]].concat()
    };
    let plane = |bytes: Vec<u8>| selvedge_io::decode(&bytes, "a.tga", &ReadOptions::default()).unwrap().plane;
    let below = plane([header([0; 5], 3, 8, 0), vec![3, 4, 1, 2]].concat());
    assert_eq!((below.samples.channels(), [0, 1, 2, 3].map(|i| below.samples.value(0, i))), (1, [1.0, 2.0, 3.0, 4.0]));
    let mapped = [header([0, 0, 2, 0, 24], 1, 8, 0x20), vec![10, 20, 30, 40, 50, 60], vec![1, 0, 0, 1]].concat();
    let mapped = plane(mapped);
    assert_eq!([0, 1, 2].map(|c| mapped.samples.value(c, 0)), [60.0, 50.0, 40.0], "blue comes first");
    assert_eq!([0, 1, 2].map(|c| mapped.samples.value(c, 1)), [30.0, 20.0, 10.0]);
    // Five bits each, red in the highest; the sixteenth is no alpha.
    let few =
        plane([header([0; 5], 2, 16, 0x21), [[0xff, 0xff], [0x00, 0x7c], [0x1f, 0], [0, 0x80]].concat()].concat());
    let red: Vec<f64> = (0..4).map(|i| few.samples.value(0, i)).collect();
    assert_eq!((red, few.samples.channels()), (vec![255.0, 255.0, 0.0, 0.0], 3));
    let left = plane([header([0; 5], 3, 8, 0x30), vec![1, 2, 3, 4]].concat());
    assert_eq!([0, 1, 2, 3].map(|i| left.samples.value(0, i)), [2.0, 1.0, 4.0, 3.0], "from the right");
    let run = plane([header([0; 5], 10, 32, 0x28), vec![0x83, 1, 2, 3, 128]].concat());
    assert_eq!(([0, 1, 2, 3].map(|c| run.samples.value(c, 3)), run.alpha), ([3.0, 2.0, 1.0, 128.0], true));
}

#[test]
fn every_lossless_format_keeps_every_layout_and_depth_to_the_bit() {
    let mut held = 0;
    for format in LOSSLESS {
        for &depth in format.depths() {
            for (colors, alpha) in [(1, false), (1, true), (3, false), (3, true)] {
                for shape in [[1, 1], [1, 9], [9, 1], [33, 70]] {
                    let plane = plane(depth, colors, alpha, shape);
                    let plane = Plane { association: format.association().unwrap_or_default(), ..plane };
                    let bytes = write(&plane, &Metadata::default(), format);
                    let picture = read(&bytes, format);
                    // WebP knows no grey.
                    let grey = format == Format::Webp && colors == 1;
                    if grey {
                        assert_eq!(picture.plane.color_channels(), 3);
                        assert_eq!(bits(&picture.plane)[..plane.domain().len()], bits(&plane)[..plane.domain().len()]);
                    } else {
                        assert_eq!(bits(&picture.plane), bits(&plane), "{format} {depth:?} {colors} {alpha} {shape:?}");
                        assert_eq!(picture.plane.samples.depth(), depth);
                        assert_eq!((picture.plane.domain(), picture.plane.alpha), (plane.domain(), alpha));
                        held += 1;
                    }
                    let info = probe_bytes(&bytes, format!("a.{format}"), &ReadOptions::default()).unwrap();
                    assert_eq!([info.height, info.width], shape);
                    assert_eq!((info.depth, info.alpha), (depth, picture.plane.alpha));
                    assert_eq!(info.channels, picture.plane.samples.channels());
                    assert_eq!(info.metadata, picture.metadata);
                }
            }
        }
    }
    assert_eq!(held, (2 + 4 + 2 + 1) * 16 + 8);
}

#[test]
fn jpeg_is_near_and_hdr_is_as_near_as_its_mantissas() {
    let smooth = |x: usize| (x * 4) as u8;
    let mut grey = plane(Depth::U8, 1, false, [40, 50]);
    let Samples::U8(grid) = &mut grey.samples else { unreachable!() };
    grid.plane_mut(0).iter_mut().enumerate().for_each(|(i, v)| *v = smooth(i % 50));
    let back = read(&write(&grey, &Metadata::default(), Format::Jpeg), Format::Jpeg).plane;
    assert!(bits(&grey).iter().zip(bits(&back)).all(|(a, b)| a.abs_diff(b) <= 4));

    let light = selvedge_io::convert(&grey, Depth::F32, &Metadata::default()).unwrap().plane;
    let once = read(&write(&light, &Metadata::default(), Format::Hdr), Format::Hdr).plane;
    for i in 0..light.domain().len() {
        let (a, b) = (light.samples.value(0, i), once.samples.value(2, i));
        assert!((a - b).abs() <= a / 128.0, "{a} {b}");
    }
    let twice = read(&write(&once, &Metadata::default(), Format::Hdr), Format::Hdr).plane;
    assert_eq!(bits(&once), bits(&twice), "what the format holds stays");
}

#[test]
fn metadata_go_where_the_format_has_a_place() {
    let density = Some(Density { x: 3_000.0, y: 2_900.0, unit: DensityUnit::Centimetre });
    let xy = [0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06];
    let chromaticities = Some(xy);
    let icc = Some(profile(b"RGB "));
    let full = Metadata { icc: icc.clone(), gamma: Some(45_455), chromaticities, density, ..made() };
    let none = made();
    for (format, expected) in [
        (Format::Png, Metadata { density: None, ..full.clone() }),
        (Format::Tiff, Metadata { icc: icc.clone(), density, ..none.clone() }),
        (Format::Jpeg, Metadata { icc: icc.clone(), density, ..none.clone() }),
        (Format::Webp, Metadata { icc, ..none.clone() }),
        (Format::Hdr, none.clone()),
        (Format::Tga, none.clone()),
        (Format::Exr, Metadata { chromaticities, density, ..none }),
    ] {
        let plane = plane(format.depths()[0], 3, false, [5, 7]);
        let mut found = read(&write(&plane, &full, format), format).metadata;
        match format {
            Format::Png => {
                assert_eq!(found.density.take().unwrap().per_metre(), Some((300_000.0, 290_000.0)));
            }
            Format::Exr => {
                let (x, y) = found.density.take().unwrap().per_metre().unwrap();
                assert!((x - 300_000.0).abs() < 0.1 && (y - 290_000.0).abs() < 0.1, "{x} {y}");
                let found_xy = found.chromaticities.take().unwrap();
                assert!(found_xy.iter().zip(xy).all(|(a, b)| (a - b).abs() < 1e-7));
                found.density = density;
                found.chromaticities = chromaticities;
            }
            _ => {}
        }
        assert_eq!(found, expected, "{format}");
    }
}

#[test]
fn a_profile_of_other_channels_is_left_out() {
    let metadata = Metadata { icc: Some(profile(b"GRAY")), ..Metadata::default() };
    for format in [Format::Png, Format::Tiff, Format::Jpeg] {
        let colour = write(&plane(Depth::U8, 3, false, [4, 4]), &metadata, format);
        assert_eq!(read(&colour, format).metadata.icc, None, "{format}");
        let grey = write(&plane(Depth::U8, 1, false, [4, 4]), &metadata, format);
        assert_eq!(read(&grey, format).metadata.icc, metadata.icc, "{format}");
    }
}

#[test]
fn depths_that_a_format_cannot_hold_are_refused_or_converted() {
    for format in Format::ALL {
        for depth in [Depth::U8, Depth::U16, Depth::F16, Depth::F32] {
            let plane = plane(depth, 3, false, [3, 3]);
            let name = format!("dir/a.{format}");
            let plain = encode(&plane, &Metadata::default(), &name, &WriteOptions::default());
            assert_eq!(plain.is_ok(), format.depths().contains(&depth), "{format} {depth:?}");
            for &to in format.depths() {
                let options = WriteOptions { depth: Some(to), ..WriteOptions::default() };
                let bytes = encode(&plane, &Metadata::default(), &name, &options).unwrap();
                let found = decode(&bytes, &name, &ReadOptions::default()).unwrap().plane.samples.depth();
                assert_eq!(found, if format == Format::Hdr { Depth::F32 } else { to });
            }
        }
    }
    let plane = plane(Depth::F32, 3, false, [3, 3]);
    let refused = encode(&plane, &Metadata::default(), "a.png", &WriteOptions::default()).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "'a.png': png cannot hold float samples; convert it to u8 or u16, or write tiff, exr, hdr"
    );
    assert!(matches!(refused.problem, Problem::DepthNotHeld { .. }));
    for quality in [0, 101] {
        let options = WriteOptions { quality, ..WriteOptions::default() };
        let refused = options.format_of("a.jpg").unwrap_err();
        assert_eq!((refused.kind(), options.format_of("a.png").is_ok()), (ErrorKind::Option, true));
    }
    let unknown = encode(&plane, &Metadata::default(), "a.xyz", &WriteOptions::default()).unwrap_err();
    assert_eq!(
        unknown.to_string(),
        "'a.xyz': 'xyz' is no format that can be written; write one of png, jpeg, tiff, exr, hdr, webp, tga"
    );
}

#[test]
fn channels_that_a_format_cannot_hold_are_refused() {
    for format in Format::ALL.into_iter().filter(|f| !f.depths().is_empty()) {
        for colors in [2, 4, 5] {
            let plane = plane(format.depths()[0], colors, false, [3, 3]);
            let written = encode(&plane, &Metadata::default(), format!("a.{format}"), &WriteOptions::default());
            assert_eq!(written.is_ok(), format == Format::Exr, "{format} {colors}");
        }
    }
    let flow = plane(Depth::F32, 2, false, [3, 4]);
    assert_eq!(bits(&read(&write(&flow, &Metadata::default(), Format::Exr), Format::Exr).plane), bits(&flow));
}

#[test]
fn role_and_hash_are_told() {
    let bytes = write(&plane(Depth::U8, 1, false, [3, 3]), &Metadata::default(), Format::Png);
    let options = ReadOptions { role: Role::Height, ..ReadOptions::default() };
    let picture = decode(&bytes, "a.png", &options).unwrap();
    assert_eq!(picture.plane.role, Role::Height);
    assert_eq!(picture.blake3, blake3::hash(&bytes).to_hex().to_string());
}

#[test]
fn misnamed_files_are_read_with_a_warning() {
    let bytes = write(&plane(Depth::F16, 3, false, [3, 3]), &Metadata::default(), Format::Exr);
    let picture = decode(&bytes, "a.png", &ReadOptions::default()).unwrap();
    assert_eq!(picture.warnings[0].to_string(), "the name says png, but the content is exr");
    assert_eq!(decode(&bytes, "no extension", &ReadOptions::default()).unwrap().warnings, []);
}

#[test]
fn no_packet_of_tga_goes_on_in_the_next_row() {
    for (width, height, channels) in [(90, 96, 3), (90, 3, 1), (300, 2, 3), (1, 5, 3)] {
        let samples = Samples::U8(Grid::try_filled(Domain::open([height, width]), channels, 7).unwrap());
        let plane = Plane::new(Role::Color, samples);
        let file = encode(&plane, &Metadata::default(), "a.tga", &WriteOptions::default()).unwrap();
        assert_eq!(decode(&file, "a.tga", &ReadOptions::default()).unwrap().plane.samples, plane.samples);
        let mut at = 18;
        for y in 0..height {
            let mut x = 0;
            while x < width {
                let n = u32::from(file[at] & 0x7f) + 1;
                at += 1 + channels * if file[at] & 0x80 == 0 { n as usize } else { 1 };
                x += n;
            }
            assert_eq!(x, width, "row {y} of {width}x{height}");
        }
        assert_eq!(at, file.len());
    }
}

#[test]
fn light_below_zero_is_told_where_hdr_makes_it_zero() {
    let light = vec![-0.5, 1.0, 0.0, -2.0];
    let plane = Plane::new(Role::Color, Samples::F32(Grid::from_vec(Domain::open([2, 2]), 1, light).unwrap()));
    let told = |format| selvedge_io::changes(&plane, &Metadata::default(), format);
    assert_eq!(told(Format::Hdr), [Warning::Negative { count: 2, format: Format::Hdr }]);
    assert_eq!(told(Format::Exr), []);
}
