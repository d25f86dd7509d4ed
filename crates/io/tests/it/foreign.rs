//! What other programs write and we do not: palettes, keys, few bits, orientation, layers, pages.

use std::fs;
use std::io::Cursor;

use crate::common::{bits, plane};
use exr::WritableImage as _;
use exr::prelude as exr;
use half::f16;
use selvedge_core::{Depth, Samples};
use selvedge_io::{Format, Metadata, Picture, Problem, ReadOptions, Warning, WriteOptions, decode, encode, read};

fn planar(picture: &Picture) -> &[u8] {
    let Samples::U8(grid) = &picture.plane.samples else { panic!("not 8 bits") };
    grid.samples()
}

fn load(bytes: &[u8]) -> Picture {
    decode(bytes, "x", &ReadOptions::default()).unwrap()
}

/// A PNG of these packed rows.
fn png(info: png::Info<'_>, packed: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut writer = png::Encoder::with_info(&mut file, info).unwrap().write_header().unwrap();
    writer.write_image_data(packed).unwrap();
    writer.finish().unwrap();
    file
}

#[test]
fn png_palettes_keys_and_few_bits() {
    let mut info = png::Info::with_size(3, 1);
    (info.color_type, info.bit_depth) = (png::ColorType::Indexed, png::BitDepth::Two);
    info.palette = Some(vec![1, 2, 3, 4, 5, 6, 7, 8, 9].into());
    let plain = load(&png(info.clone(), &[0b10_00_01_00]));
    assert_eq!(planar(&plain), [7, 1, 4, 8, 2, 5, 9, 3, 6]);
    assert!(!plain.plane.alpha);
    let beyond = load(&png(info.clone(), &[0b11_00_11_00]));
    assert_eq!(planar(&beyond), [0, 1, 0, 0, 2, 0, 0, 3, 0]);
    assert_eq!(beyond.warnings, [Warning::BeyondPalette { count: 2 }]);
    info.trns = Some(vec![0, 128].into());
    let keyed = load(&png(info, &[0b10_00_01_00]));
    assert_eq!(planar(&keyed)[9..], [255, 0, 128]);
    assert!(keyed.plane.alpha);

    let mut grey = png::Info::with_size(4, 1);
    grey.bit_depth = png::BitDepth::One;
    grey.color_type = png::ColorType::Grayscale;
    assert_eq!(planar(&load(&png(grey, &[0b1010_0000]))), [255, 0, 255, 0]);
}

#[test]
fn exif_orientation_is_applied() {
    let upright = plane(Depth::U8, 3, false, [16, 8]);
    let jpeg = encode(&upright, &Metadata::default(), "x.jpg", &WriteOptions::default()).unwrap();
    let stored = load(&jpeg);
    let mut block =
        b"\xff\xe1\0\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0".to_vec();
    block.splice(0..0, jpeg[..2].iter().copied());
    let turned = load(&[&block, &jpeg[2..]].concat());
    assert_eq!(turned.plane.domain().shape, [8, 16]);
    let at = |picture: &Picture, y: u32, x: u32| {
        let Samples::U8(grid) = &picture.plane.samples else { unreachable!() };
        [0, 1, 2].map(|c| grid.get(c, [y, x]))
    };
    for (y, x) in [(0, 0), (3, 5), (15, 7)] {
        assert_eq!(at(&turned, x, 15 - y), at(&stored, y, x), "a clockwise turn");
    }
}

#[test]
fn truncated_jpeg_is_not_filled_with_grey() {
    let jpeg = encode(&plane(Depth::U8, 3, false, [64, 64]), &Metadata::default(), "x.jpg", &WriteOptions::default());
    let jpeg = jpeg.unwrap();
    let cut = decode(&jpeg[..jpeg.len() * 3 / 4], "x", &ReadOptions::default()).unwrap_err();
    assert!(matches!(cut.problem, Problem::Damaged { format: Format::Jpeg, .. }), "{cut}");
}

/// A little-endian TIFF of one strip.
pub(crate) fn tiff(tags: &[(u16, u16, u32, u32)], data: &[u8]) -> Vec<u8> {
    let data_at = 8 + 2 + 12 * (tags.len() as u32 + 2) + 4;
    let mut tags = tags.to_vec();
    tags.extend([(273, 4, 1, data_at), (279, 4, 1, data.len() as u32)]);
    tags.sort_unstable();
    let mut file = b"II\x2a\0\x08\0\0\0".to_vec();
    file.extend((tags.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in tags {
        file.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        file.extend([count.to_le_bytes(), value.to_le_bytes()].concat());
    }
    file.extend([0; 4]);
    file.extend(data);
    file
}

#[test]
fn tiff_palettes_few_bits_and_white_as_zero() {
    // Three samples of two bits, then a palette of four colours: reds, greens, blues.
    let colors: [u16; 12] =
        [0x0100, 0x0200, 0x0300, 0x0400, 0x1111, 0x2222, 0x3333, 0x4444, 5 << 8, 6 << 8, 7 << 8, 0xffff];
    let mut data = vec![0b11_00_01_00, 0];
    data.extend(colors.iter().flat_map(|c| c.to_le_bytes()));
    let size = [(256, 3, 1, 3), (257, 3, 1, 1), (278, 3, 1, 1), (259, 3, 1, 1)];
    let palette_at = 8 + 2 + 12 * 9 + 4 + 2;
    let palette = [&size[..], &[(258, 3, 1, 2), (262, 3, 1, 3), (320, 3, 12, palette_at)]].concat();
    assert_eq!(planar(&load(&tiff(&palette, &data))), [4, 1, 2, 0x44, 0x11, 0x22, 255, 5, 6]);

    let grey = |photometric| [&size[..], &[(258, 3, 1, 4), (262, 3, 1, photometric)]].concat();
    assert_eq!(planar(&load(&tiff(&grey(1), &[0x0f, 0x80]))), [0, 255, 136]);
    assert_eq!(planar(&load(&tiff(&grey(0), &[0x0f, 0x80]))), [255, 0, 119]);
}

#[test]
fn tiff_of_64_bit_floats_is_rounded_and_of_32_bit_integers_refused() {
    let size = [(256, 3, 1, 2), (257, 3, 1, 1), (278, 3, 1, 1), (259, 3, 1, 1), (262, 3, 1, 1)];
    let doubles = [&size[..], &[(258, 3, 1, 64), (339, 3, 1, 3)]].concat();
    let data: Vec<u8> = [0.1_f64, -3.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let picture = load(&tiff(&doubles, &data));
    assert!(matches!(&picture.plane.samples, Samples::F32(g) if g.samples() == [0.1, -3.0]));
    assert_eq!(picture.warnings, [Warning::Rounded]);
    let integers = [&size[..], &[(258, 3, 1, 32), (339, 3, 1, 1)]].concat();
    let refused = decode(&tiff(&integers, &[0; 8]), "x", &ReadOptions::default()).unwrap_err();
    assert!(matches!(refused.problem, Problem::Unsupported { .. }), "{refused}");
}

/// Beauty and a layer by prefix, half; depth float; a second part.
fn layered() -> Vec<u8> {
    let half = |v: f32| exr::FlatSamples::F16((0..6).map(|i| f16::from_f32(v + i as f32)).collect());
    let float = |v: f32| exr::FlatSamples::F32((0..6).map(|i| v + i as f32).collect());
    let channel = |name: &str, samples| exr::AnyChannel::new(name, samples);
    let first = exr::AnyChannels::sort(
        [
            channel("R", half(10.0)),
            channel("G", half(20.0)),
            channel("B", half(30.0)),
            channel("diffuse.R", half(40.0)),
            channel("diffuse.G", half(50.0)),
            channel("diffuse.B", half(60.0)),
            channel("Z", float(70.5)),
        ]
        .into_iter()
        .collect(),
    );
    let second = exr::AnyChannels::sort([channel("Y", float(80.0))].into_iter().collect());
    let layer = |name: &str, channels| {
        exr::Layer::new((3, 2), exr::LayerAttributes::named(name), exr::Encoding::SMALL_LOSSLESS, channels)
    };
    let attributes = exr::ImageAttributes::new(exr::IntegerBounds::from_dimensions((3, 2)));
    let image = exr::Image::from_layers(attributes, vec![layer("main", first), layer("matte", second)]);
    let mut file = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut file).unwrap();
    file.into_inner()
}

#[test]
fn exr_layers_and_channels_are_chosen_by_name() {
    let file = layered();
    let choose = |channels: Option<&str>| {
        let options = ReadOptions { channels: channels.map(str::to_owned), ..ReadOptions::default() };
        decode(&file, "x.exr", &options)
    };
    let first = |channels: Option<&str>| {
        let samples = choose(channels).unwrap().plane.samples;
        let values: Vec<f64> = (0..samples.channels()).map(|c| samples.value(c, 0)).collect();
        (samples.depth(), values)
    };
    assert_eq!(first(None), (Depth::F16, vec![10.0, 20.0, 30.0]));
    assert_eq!(first(Some("diffuse")), (Depth::F16, vec![40.0, 50.0, 60.0]));
    assert_eq!(first(Some("main.diffuse")), (Depth::F16, vec![40.0, 50.0, 60.0]));
    assert_eq!(first(Some("Z")), (Depth::F32, vec![70.5]));
    assert_eq!(first(Some("matte")), (Depth::F32, vec![80.0]));
    assert_eq!(first(Some("B,R")), (Depth::F16, vec![30.0, 10.0]));
    let mixed = choose(Some("R,Z")).unwrap();
    assert_eq!(mixed.warnings, [Warning::Widened]);
    assert_eq!(bits(&mixed.plane)[6..], [70.5_f32, 71.5, 72.5, 73.5, 74.5, 75.5].map(f32::to_bits));
    let left = "not in the picture: main.Z, main.diffuse.B, main.diffuse.G, main.diffuse.R and 1 more; \
                'file.exr[main.Z]' reads the first";
    assert_eq!(choose(None).unwrap().warnings, [Warning::ChannelsLeftOut { what: left.into() }]);
    assert_eq!(choose(Some("diffuse")).unwrap().warnings, [], "what is chosen is all that is wanted");
    // Colour and height together are kept together.
    let joint = choose(Some("R,G,B,diffuse.R")).unwrap();
    assert_eq!((joint.plane.samples.channels(), joint.plane.alpha), (4, false));
    let written = encode(&joint.plane, &joint.metadata, "joint.exr", &WriteOptions::default()).unwrap();
    let options = ReadOptions { channels: Some("R,G,B,diffuse.R".into()), ..ReadOptions::default() };
    assert_eq!(bits(&decode(&written, "joint.exr", &options).unwrap().plane), bits(&joint.plane));
    let renamed = |channels| -> Vec<String> {
        let picture = choose(Some(channels)).unwrap();
        selvedge_io::changes(&picture.plane, &picture.metadata, Format::Exr).iter().map(Warning::to_string).collect()
    };
    assert!(["R,G,B", "diffuse", "matte"].iter().all(|usual| renamed(usual).is_empty()));
    assert_eq!(
        (renamed("Z"), renamed("R,G")),
        (vec!["Z is named Y in this exr".to_owned()], vec!["R, G are named X, Y in this exr".to_owned()])
    );
    let missing = choose(Some("specular")).unwrap_err().to_string();
    assert!(missing.contains("no layer or channels 'specular' in it; it holds main.B, "), "{missing}");

    let folder = std::env::temp_dir().join(format!("selvedge-io-layers-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("x.exr"), &file).unwrap();
    let by_brackets = read(folder.join("x.exr[diffuse]"), &ReadOptions::default()).unwrap();
    fs::remove_dir_all(&folder).unwrap();
    assert_eq!(by_brackets.plane, choose(Some("diffuse")).unwrap().plane);
    assert_eq!(by_brackets.fingerprint("dir/x.exr[diffuse]").name, "x.exr");

    let png = encode(&plane(Depth::U8, 3, false, [2, 2]), &Metadata::default(), "x.png", &WriteOptions::default());
    let options = ReadOptions { channels: Some("R".into()), ..ReadOptions::default() };
    assert!(decode(&png.unwrap(), "x.png", &options).is_err());
}
