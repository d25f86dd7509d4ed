//! What files of others say of their samples beside them: whether there is alpha, and what colours mean.

use std::io::Cursor;

use exr::WritableImage as _;
use exr::prelude as exr;
use selvedge_core::{Depth, Samples};
use selvedge_io::{
    Association, Density, DensityUnit, Format, Metadata, Picture, ReadOptions, Warning, WriteOptions, changes, convert,
    decode, encode, probe_bytes,
};

use crate::bombs::{chunk, png};
use crate::common::plane;
use crate::foreign::tiff;

fn read(bytes: &[u8]) -> Picture {
    let picture = decode(bytes, "x", &ReadOptions::default()).unwrap();
    let told = probe_bytes(bytes, "x", &ReadOptions::default()).unwrap();
    let plane = &picture.plane;
    assert_eq!((told.channels, told.alpha), (plane.samples.channels(), plane.alpha), "told as it is read");
    assert_eq!((told.association, &told.metadata), (plane.association, &picture.metadata));
    picture
}

/// One sample of TGA, and an extension area of this kind of alpha and this gamma.
fn tga(bits: u8, descriptor: u8, sample: &[u8], area: Option<(u8, [u16; 2])>) -> Vec<u8> {
    let mut file = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, bits, 0x20 | descriptor];
    file.extend(sample);
    let Some((alpha, [n, d])) = area else { return file };
    let at = file.len() as u32;
    file.extend(
        [&495_u16.to_le_bytes()[..], &[0; 476], &n.to_le_bytes(), &d.to_le_bytes(), &[0; 12], &[alpha]].concat(),
    );
    file.extend([&at.to_le_bytes()[..], &[0; 4], b"TRUEVISION-XFILE.\0"].concat());
    file
}

#[test]
fn tga_says_what_its_alpha_is() {
    let of = |kind| read(&tga(32, 8, &[3, 2, 1, 128], Some((kind, [0, 0]))));
    for kind in 0..3 {
        let picture = of(kind);
        assert!(matches!(&picture.plane.samples, Samples::U8(g) if g.samples() == [1, 2, 3]), "{kind}");
        assert!(matches!(&picture.warnings[..], [Warning::ChannelsLeftOut { what }] if what.contains("no alpha")));
    }
    for (kind, association) in [(3, Association::Straight), (4, Association::Premultiplied)] {
        let picture = of(kind);
        assert_eq!((picture.plane.alpha, picture.plane.association), (true, association));
        assert_eq!(picture.warnings, []);
    }
    let bits = |descriptor, area| read(&tga(16, descriptor, &[0xff, 0x7f], area)).warnings.len();
    assert_eq!([bits(1, None), bits(0, None), bits(1, Some((0, [0, 0])))], [1, 0, 0], "a bit that is lost is told");
}

#[test]
fn tga_says_its_gamma() {
    let gamma = |ratio| read(&tga(24, 0, &[3, 2, 1], Some((0, ratio)))).metadata.gamma;
    assert_eq!([[0, 0], [10, 10], [22, 10], [10, 22]].map(gamma), [None, Some(100_000), Some(45_455), Some(45_455)]);
}

const WIDE: [f64; 8] = [0.3127, 0.329, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06];

fn unread(picture: &Picture) -> Vec<&'static str> {
    let tag = |w: &Warning| if let Warning::TagUnread { tag } = w { *tag } else { panic!("{w}") };
    picture.warnings.iter().map(tag).collect()
}

fn little(entries: &[(u16, u16, u32, u32)]) -> Vec<u8> {
    let entry = |(tag, kind, count, value): &(u16, u16, u32, u32)| {
        [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat()
    };
    [&(entries.len() as u16).to_le_bytes()[..], &entries.iter().flat_map(entry).collect::<Vec<_>>(), &[0; 4]].concat()
}

/// A JPEG with one more segment.
fn jpeg(marker: u8, segment: &[u8]) -> Vec<u8> {
    let jpeg = encode(&plane(Depth::U8, 3, false, [8, 8]), &Metadata::default(), "x.jpg", &WriteOptions::default());
    let mut file = jpeg.unwrap();
    let len = (segment.len() as u16 + 2).to_be_bytes();
    file.splice(2..2, [&[0xff, marker][..], &len, segment].concat());
    file
}

#[test]
fn adobe_rgb_of_cameras_is_known_by_its_rule() {
    let rule = |name: [u8; 4]| {
        let ratio = [220_u32.to_le_bytes(), 100_u32.to_le_bytes()].concat();
        let picture = little(&[(0xa001, 3, 1, 0xffff), (0xa005, 4, 1, 26 + 42 + 8), (0xa500, 5, 1, 26 + 42)]);
        let exchange = little(&[(1, 2, 4, u32::from_le_bytes(name))]);
        let block =
            [b"Exif\0\0II\x2a\0\x08\0\0\0", &little(&[(0x8769, 4, 1, 26)])[..], &picture, &ratio, &exchange].concat();
        read(&jpeg(0xe1, &block))
    };
    let adobe = rule(*b"R03\0");
    assert_eq!((adobe.metadata.chromaticities, adobe.metadata.gamma), (Some(WIDE), Some(45_455)));
    let format = Format::Jpeg;
    assert_eq!(changes(&adobe.plane, &adobe.metadata, format), [Warning::TagLeftOut { tag: "chromaticities", format }]);
    assert_eq!(changes(&adobe.plane, &adobe.metadata, Format::Png), []);
    assert_eq!(adobe.metadata.converted(Depth::U8, Depth::F16).chromaticities, Some(WIDE), "told in an EXR");
    assert_eq!(rule(*b"R98\0").metadata.chromaticities, None);
}

#[test]
fn tiff_keeps_chromaticities_and_tells_curves() {
    let pixels = plane(Depth::U8, 3, false, [3, 4]);
    let metadata = Metadata { chromaticities: Some(WIDE), ..Metadata::default() };
    assert_eq!(changes(&pixels, &metadata, Format::Tiff), []);
    let file = encode(&pixels, &metadata, "x.tif", &WriteOptions::default()).unwrap();
    assert_eq!(read(&file).metadata, metadata);
    let size = [(256, 3, 1, 1), (257, 3, 1, 1), (258, 3, 1, 8), (278, 3, 1, 1), (259, 3, 1, 1), (262, 3, 1, 1)];
    let linear = tiff(&[&size[..], &[(301, 3, 1, 0)]].concat(), &[7]);
    assert_eq!(unread(&read(&linear)), ["transfer function"]);
    let slices = tiff(&[&size[..], &[(32_997, 4, 1, 4)]].concat(), &[7, 8, 9, 10]);
    assert_eq!(read(&slices).warnings, [Warning::FirstPictureOnly]);
}

/// A bitmap of one pixel whose second header says so of its colours.
fn bmp(kind: [u8; 4], points: [[f64; 3]; 3], gammas: [f64; 3], profile: &[u8]) -> Vec<u8> {
    let number = |v: u32| v.to_le_bytes().to_vec();
    let fixed = |v: f64, bits: u32| number((v * f64::from(1_u32 << bits)).round() as u32);
    let mut file = [b"BM".to_vec(), number(0), number(0), number(138)].concat();
    file.extend(
        [number(124), number(1), number(1), vec![1, 0, 24, 0], vec![0; 40], vec![kind[3], kind[2], kind[1], kind[0]]]
            .concat(),
    );
    points.concat().into_iter().for_each(|v| file.extend(fixed(v, 30)));
    gammas.into_iter().for_each(|v| file.extend(fixed(v, 16)));
    file.extend([number(0), number(128), number(profile.len() as u32), number(0), vec![3, 2, 1, 0]].concat());
    file.extend(profile);
    file
}

#[test]
fn bitmaps_say_their_colours() {
    let nothing = [[0.0; 3]; 3];
    let profile = crate::common::profile(b"RGB ");
    assert_eq!(read(&bmp(*b"MBED", nothing, [0.0; 3], &profile)).metadata.icc.as_ref(), Some(&profile));
    let cut = bmp(*b"MBED", nothing, [0.0; 3], &profile);
    assert_eq!(read(&cut[..cut.len() - 1]).warnings, [Warning::ProfileLeftOut]);
    assert_eq!(read(&bmp(*b"LINK", nothing, [0.0; 3], b"a.icc")).warnings, [Warning::ProfileLeftOut]);
    assert_eq!(read(&bmp(*b"sRGB", nothing, [1.0; 3], &[])).metadata, Metadata::default());
    assert_eq!(read(&bmp([0; 4], nothing, [0.0; 3], &[])).metadata, Metadata::default());
    // XYZ of Adobe RGB.
    let points = [[0.576_67, 0.297_34, 0.027_03], [0.185_56, 0.627_36, 0.070_69], [0.188_23, 0.075_29, 0.991_34]];
    let calibrated = read(&bmp([0; 4], points, [1.0; 3], &[]));
    let found = calibrated.metadata.chromaticities.unwrap();
    assert!(found.iter().zip(WIDE).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}");
    let alone = [[0.64, 0.33, 0.03], [0.21, 0.71, 0.08], [0.15, 0.06, 0.79]];
    let found = read(&bmp([0; 4], alone, [0.0; 3], &[])).metadata.chromaticities.unwrap();
    assert!(found.iter().zip(WIDE).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    assert_eq!(calibrated.metadata.gamma, Some(100_000));
    let light = convert(&calibrated.plane, Depth::F32, &calibrated.metadata).unwrap().plane;
    assert_eq!(light.samples.value(0, 0) as f32, 1.0 / 255.0, "linear light");
    assert_eq!(unread(&read(&bmp([0; 4], nothing, [1.0, 1.0, 2.2], &[]))), ["gammas"]);
}

#[test]
fn radiance_headers_are_told() {
    let of = |lines: &str| {
        let mut file = format!("#?RADIANCE\n{lines}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n").into_bytes();
        file.extend([128, 64, 32, 129]);
        read(&file)
    };
    let (plain, said) = (of(""), of("EXPOSURE=4\nGAMMA=2.2\nCOLORCORR=1 2 1\n"));
    assert_eq!(said.plane, plain.plane, "samples stay as they are");
    assert_eq!((unread(&said), unread(&plain)), (vec!["exposure", "colour correction", "gamma"], vec![]));
    assert_eq!(unread(&of("EXPOSURE=1.0\nGAMMA=1\n")), [""; 0]);
    let shaped = of("PRIMARIES=.64 .33 .21 .71 .15 .06 .3127 .329\nPIXASPECT=0.5\n").metadata;
    let density = Some(Density { x: 1.0, y: 2.0, unit: DensityUnit::Aspect });
    assert_eq!((shaped.chromaticities, shaped.density), (Some(WIDE), density));
}

#[test]
fn exr_tells_its_windows_and_its_white() {
    let file = |display: (usize, usize), at: (i32, i32), white: Option<f32>| {
        let samples = exr::FlatSamples::F32(vec![0.5; 6]);
        let channels = exr::AnyChannels::sort([exr::AnyChannel::new("Y", samples)].into_iter().collect());
        let mut attributes = exr::LayerAttributes { white_luminance: white, ..Default::default() };
        attributes.layer_position = exr::Vec2(at.0, at.1);
        let layer = exr::Layer::new((3, 2), attributes, exr::Encoding::SMALL_LOSSLESS, channels);
        let attributes = exr::ImageAttributes::new(exr::IntegerBounds::from_dimensions(display));
        let mut file = Cursor::new(Vec::new());
        exr::Image::new(attributes, layer).write().non_parallel().to_buffered(&mut file).unwrap();
        unread(&read(&file.into_inner()))
    };
    assert_eq!(file((3, 2), (0, 0), None), [""; 0]);
    assert_eq!(file((8, 8), (2, 1), None), ["place in its display window"]);
    assert_eq!(file((3, 2), (0, 0), Some(100.0)), ["white luminance"]);
}

#[test]
fn png_tells_what_screens_it_is_for_and_animations_beside_it() {
    let idat = chunk(b"IDAT", &[0x78, 0x01, 0x01, 2, 0, 0xfd, 0xff, 0, 7, 0, 9, 0, 8]);
    let screens = [chunk(b"mDCV", &[1; 24]), chunk(b"cLLI", &[0; 8]), idat.clone()];
    assert_eq!(unread(&read(&png(1, 1, 8, 0, &screens))), ["mastering display", "content light level"]);
    let frame = [&[0, 0, 0, 0][..], &[0, 0, 0, 1], &[0, 0, 0, 1], &[0; 8], &[0, 1, 0, 25, 0, 0]].concat();
    let data = [&[0, 0, 0, 1][..], &[0x78, 0x01, 0x01, 2, 0, 0xfd, 0xff, 0, 7, 0, 9, 0, 8]].concat();
    let beside = [chunk(b"acTL", &[0, 0, 0, 1, 0, 0, 0, 0]), idat, chunk(b"fcTL", &frame), chunk(b"fdAT", &data)];
    assert_eq!(read(&png(1, 1, 8, 0, &beside)).warnings, [Warning::DefaultPictureOnly]);
}

#[test]
fn further_pictures_of_a_jpeg_are_told() {
    let of = |count| {
        let block = [b"MPF\0II\x2a\0\x08\0\0\0", &little(&[(0xb000, 7, 4, 0), (0xb001, 4, 1, count)])[..]].concat();
        read(&jpeg(0xe2, &block)).warnings
    };
    assert_eq!((of(2), of(1)), (vec![Warning::FirstPictureOnly], vec![]));
}

#[test]
fn a_thumbnail_is_no_page() {
    let page = |kind: u32, side: u32, data: u32, next: u32| {
        let size = [(254, 4, 1, kind), (256, 3, 1, side), (257, 3, 1, side), (258, 3, 1, 8), (259, 3, 1, 1)];
        let strip = [(262, 3, 1, 1), (273, 4, 1, data), (278, 3, 1, side), (279, 4, 1, side * side)];
        let mut page = little(&[&size[..], &strip].concat());
        let end = page.len() - 4;
        page[end..].copy_from_slice(&next.to_le_bytes());
        page
    };
    let len = page(0, 1, 0, 0).len() as u32;
    let two = |first: u32, second: u32| {
        let data = 8 + 2 * len;
        let pages = [page(first, 1, data, 8 + len), page(second, 2, data + 1, 0)].concat();
        read(&[b"II\x2a\0\x08\0\0\0", &pages[..], &[9, 1, 2, 3, 4]].concat())
    };
    let side = |picture: &Picture| picture.plane.domain().shape[0];
    let picture = two(1, 0);
    assert!(matches!(&picture.plane.samples, Samples::U8(g) if g.samples() == [1, 2, 3, 4]));
    assert_eq!(picture.warnings, []);
    assert_eq!((side(&two(0, 1)), side(&two(0, 0)), side(&two(1, 1))), (1, 1, 1), "else the first is read");
}

#[test]
fn animations_that_show_all_of_their_first_frame_have_no_alpha() {
    let gif = |width: u16, transparent| {
        let mut file = Vec::new();
        let mut encoder = gif::Encoder::new(&mut file, 2, 1, &[0, 0, 0, 90, 90, 90]).unwrap();
        let buffer = std::borrow::Cow::Borrowed(&[0, 1][..usize::from(width)]);
        encoder.write_frame(&gif::Frame { width, height: 1, transparent, buffer, ..Default::default() }).unwrap();
        drop(encoder);
        read(&file).plane.alpha
    };
    assert_eq!([gif(2, None), gif(2, Some(1)), gif(1, None)], [false, true, true]);
    let webp = |alpha: bool| {
        let picture =
            encode(&plane(Depth::U8, 3, alpha, [1, 2]), &Metadata::default(), "x.webp", &WriteOptions::default());
        let chunk = |kind: &[u8], data: &[u8]| [kind, &(data.len() as u32).to_le_bytes(), data].concat();
        let frame = [&[0; 6][..], &[1, 0, 0, 0, 0, 0, 25, 0, 0, 0], &picture.unwrap()[12..]].concat();
        let header = chunk(b"VP8X", &[0x12, 0, 0, 0, 1, 0, 0, 0, 0, 0]);
        let all = [b"WEBP", &header[..], &chunk(b"ANIM", &[0; 6]), &chunk(b"ANMF", &frame)].concat();
        read(&chunk(b"RIFF", &all)).plane.alpha
    };
    assert_eq!([webp(false), webp(true)], [false, true]);
}

#[test]
fn what_cannot_be_read_is_not_offered() {
    let channel = |name: &str, samples| exr::AnyChannel::new(name, samples);
    let id = channel("id", exr::FlatSamples::U32(vec![7]));
    let left = |others: Vec<exr::AnyChannel<exr::FlatSamples>>| {
        let all = [vec![channel("Y", exr::FlatSamples::F32(vec![0.5])), id.clone()], others].concat();
        let channels = exr::AnyChannels::sort(all.into_iter().collect());
        let layer = exr::Layer::new((1, 1), exr::LayerAttributes::default(), exr::Encoding::SMALL_LOSSLESS, channels);
        let mut file = Cursor::new(Vec::new());
        exr::Image::from_layer(layer).write().non_parallel().to_buffered(&mut file).unwrap();
        let warnings = read(&file.into_inner()).warnings;
        let [Warning::ChannelsLeftOut { what }] = &warnings[..] else { panic!("{warnings:?}") };
        what.clone()
    };
    assert_eq!(left(vec![]), "not in the picture: id (32-bit integers, deep or subsampled, which are not read)");
    let depth = channel("z", exr::FlatSamples::F32(vec![1.0]));
    assert_eq!(left(vec![depth]), "not in the picture: id, z; 'file.exr[z]' reads that one");
}
