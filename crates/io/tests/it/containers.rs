//! Clips in one file: what is written is read, what others write is seen as they mean it, and what is cut is refused.

use crate::clips::{Folder, all, frames, open, write};
use crate::common::bits;
use selvedge_core::{Depth, Domain, Grid, Limits, Plane, Role, Samples};
use selvedge_io::clip::{ClipOptions, ClipProblem, ClipReader, ClipWriteOptions, Flipbook};
use selvedge_io::{Error, Problem, ReadOptions};

fn rate(text: &str) -> ClipWriteOptions {
    ClipWriteOptions { rate: text.parse().ok(), ..ClipWriteOptions::default() }
}

fn file(folder: &Folder, name: &str, frames: &[Plane<2>], options: ClipWriteOptions) -> Vec<u8> {
    let path = folder.path(name);
    write(&path, frames, options).unwrap().finish().unwrap();
    std::fs::read(path).unwrap()
}

fn of(bytes: &[u8]) -> Result<ClipReader, Error> {
    let limits = Limits { memory: 64 << 20, side: 4096, samples: 1 << 20 };
    let frame = ReadOptions { limits, ..ReadOptions::default() };
    ClipReader::of_bytes(bytes.to_vec(), "x", &ClipOptions { frame, ..ClipOptions::default() })
}

/// Reads all of it, or says why not.
fn whole(bytes: &[u8]) -> Result<Vec<Plane<2>>, Error> {
    let mut reader = of(bytes)?;
    let mut frames = Vec::new();
    while let Some(frame) = reader.next()? {
        frames.push(frame);
    }
    Ok(frames)
}

/// Few colours, none of which is missing in a GIF.
fn few(count: u32, channels: usize, alpha: bool) -> Vec<Plane<2>> {
    let all = frames(Depth::U8, 3, true, [count, 6, 7]);
    let part = |plane: &Plane<2>| {
        let Samples::U8(grid) = &plane.samples else { unreachable!() };
        let values: Vec<u8> = grid.samples()[..channels * 42].iter().map(|v| v & 0xc0).collect();
        let mut values = values;
        if alpha {
            let last = (channels - 1) * 42;
            for i in 0..42 {
                values[last + i] = if values[last + i] < 128 { 0 } else { 255 };
                let hole = values[last + i] == 0;
                (0..channels - 1).filter(|_| hole).for_each(|c| values[c * 42 + i] = 0);
            }
        }
        let samples = Samples::U8(Grid::from_vec(grid.domain(), channels, values).unwrap());
        Plane { alpha, ..Plane::new(Role::Color, samples) }
    };
    all.iter().map(part).collect()
}

#[test]
fn apng_of_every_layout_comes_back_bit_for_bit() {
    let folder = Folder::new("apng");
    for (depth, colors, alpha) in
        [(Depth::U8, 1, false), (Depth::U8, 3, true), (Depth::U16, 3, false), (Depth::U16, 1, true)]
    {
        let written = frames(depth, colors, alpha, [5, 6, 7]);
        let bytes = file(&folder, "a.png", &written, rate("30000/1001"));
        let mut reader = of(&bytes).unwrap();
        assert_eq!(reader.info().rate.unwrap().to_string(), "30000/1001");
        assert_eq!((reader.info().frames, reader.info().depth, reader.info().alpha), (5, depth, alpha));
        for _ in 0..2 {
            let read = all(&mut reader);
            assert!(read.len() == 5 && read.iter().zip(&written).all(|(a, b)| bits(a) == bits(b)));
            reader.rewind().unwrap();
        }
    }
    let picture = selvedge_io::encode(
        &frames(Depth::U8, 1, false, [1, 2, 2])[0],
        &selvedge_io::Metadata::default(),
        "a.png",
        &selvedge_io::WriteOptions::default(),
    );
    assert!(matches!(of(&picture.unwrap()).unwrap_err().problem, Problem::Clip(ClipProblem::Still)));
}

#[test]
fn parts_of_an_apng_lie_where_and_as_they_should() {
    // 3x1: all 10; then 20 over the middle, taken back; then half transparent 210 on the left, which is cleared at
    // last.
    let mut file = Vec::new();
    let mut info = png::Info::with_size(3, 1);
    (info.color_type, info.bit_depth) = (png::ColorType::GrayscaleAlpha, png::BitDepth::Eight);
    let mut encoder = png::Encoder::with_info(&mut file, info).unwrap();
    encoder.set_animated(4, 0).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[10, 255, 10, 255, 10, 255]).unwrap();
    writer.set_frame_dimension(1, 1).unwrap();
    writer.set_frame_position(1, 0).unwrap();
    writer.set_dispose_op(png::DisposeOp::Previous).unwrap();
    writer.write_image_data(&[20, 255]).unwrap();
    writer.set_frame_position(0, 0).unwrap();
    writer.set_dispose_op(png::DisposeOp::Background).unwrap();
    writer.set_blend_op(png::BlendOp::Over).unwrap();
    writer.write_image_data(&[210, 51]).unwrap();
    writer.set_frame_position(2, 0).unwrap();
    writer.set_blend_op(png::BlendOp::Source).unwrap();
    writer.write_image_data(&[30, 100]).unwrap();
    writer.finish().unwrap();
    let read = whole(&file).unwrap();
    let planes: Vec<Vec<u32>> = read.iter().map(bits).collect();
    assert_eq!(planes[0], [10, 10, 10, 255, 255, 255]);
    assert_eq!(planes[1], [10, 20, 10, 255, 255, 255]);
    assert_eq!(planes[2], [50, 10, 10, 255, 255, 255], "a fifth of 210 over 10");
    assert_eq!(planes[3], [0, 10, 30, 0, 255, 100]);
}

#[test]
fn gif_of_few_colours_comes_back_and_keeps_its_rate() {
    let folder = Folder::new("gif");
    for (channels, alpha) in [(1, false), (3, false), (4, true)] {
        let written = few(6, channels, alpha);
        let bytes = file(&folder, "a.gif", &written, rate("30"));
        let mut reader = of(&bytes).unwrap();
        assert_eq!((reader.info().frames, reader.info().alpha), (6, alpha));
        assert_eq!(reader.info().rate.unwrap().to_string(), "30");
        let read = all(&mut reader);
        for (a, b) in read.iter().zip(&written) {
            let (a, b) = (bits(a), bits(b));
            let grey = [&b[..], &b[..], &b[..]].concat();
            assert_eq!(a, if channels == 1 { grey } else { b });
        }
    }
}

#[test]
fn gif_of_many_colours_is_near_and_still_where_the_clip_is_still() {
    let folder = Folder::new("gif-many");
    let domain = Domain::open([32, 32]);
    let sample = |c: u32, y: u32, x: u32| [8 * x, 8 * y, 255 - 4 * (x + y)][c as usize] as u8;
    let values = (0..3).flat_map(|c| domain.positions().map(move |[y, x]| sample(c, y, x))).collect();
    let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, values).unwrap()));
    let bytes = file(&folder, "a.gif", &[plane.clone(), plane.clone()], rate("25"));
    let read = whole(&bytes).unwrap();
    assert_eq!(read[0], read[1], "the dither stands still");
    let off: Vec<u32> = bits(&read[0]).iter().zip(bits(&plane)).map(|(a, b)| a.abs_diff(b)).collect();
    let mean = f64::from(off.iter().sum::<u32>()) / off.len() as f64;
    assert!(mean < 9.0 && off.iter().max().is_some_and(|most| *most < 60), "{mean} {:?}", off.iter().max());
}

#[test]
fn gif_frames_lie_over_what_earlier_ones_leave() {
    use std::borrow::Cow;
    let mut file = Vec::new();
    let mut encoder = gif::Encoder::new(&mut file, 3, 1, &[0, 0, 0, 90, 90, 90, 200, 200, 200, 7, 7, 7]).unwrap();
    let mut frame = |left: u16, buffer: &'static [u8], dispose, transparent| {
        let frame = gif::Frame {
            left,
            width: buffer.len() as u16,
            height: 1,
            delay: 5,
            dispose,
            transparent,
            buffer: Cow::Borrowed(buffer),
            ..gif::Frame::default()
        };
        encoder.write_frame(&frame).unwrap();
    };
    frame(0, &[1, 1, 1], gif::DisposalMethod::Keep, None);
    frame(1, &[2], gif::DisposalMethod::Previous, None);
    frame(0, &[3, 2, 3], gif::DisposalMethod::Keep, Some(3));
    drop(encoder);
    let mut reader = of(&file).unwrap();
    assert_eq!(reader.info().rate.unwrap().to_string(), "20");
    let grey: Vec<Vec<u32>> = all(&mut reader).iter().map(|plane| bits(plane)[..3].to_vec()).collect();
    assert_eq!(grey, [[90, 90, 90], [90, 200, 90], [90, 200, 90]]);
}

#[test]
fn y4m_keeps_grey_and_comes_near_colours() {
    let folder = Folder::new("y4m");
    let grey = frames(Depth::U8, 1, false, [3, 5, 7]);
    let bytes = file(&folder, "a.y4m", &grey, rate("24000/1001"));
    assert!(bytes.starts_with(b"YUV4MPEG2 W7 H5 F24000:1001 Ip A1:1 Cmono"), "its header is what players expect");
    let mut reader = open(&folder.path("a.y4m")).unwrap();
    assert_eq!((reader.info().rate.unwrap().to_string().as_str(), reader.info().frames), ("24000/1001", 3));
    assert!(all(&mut reader).iter().zip(&grey).all(|(a, b)| bits(a) == bits(b)));
    let color = frames(Depth::U8, 3, false, [2, 5, 7]);
    let read = whole(&file(&folder, "b.y4m", &color, rate("25"))).unwrap();
    let off = read.iter().zip(&color).flat_map(|(a, b)| bits(a).into_iter().zip(bits(b)).map(|(a, b)| a.abs_diff(b)));
    assert!(off.max().is_some_and(|most| most <= 4), "limited range has fewer values");
    for channels in [1, 3] {
        let deep = frames(Depth::U16, channels, false, [2, 5, 7]);
        let read = whole(&file(&folder, "c.y4m", &deep, rate("25"))).unwrap();
        let off =
            read.iter().zip(&deep).flat_map(|(a, b)| bits(a).into_iter().zip(bits(b)).map(|(a, b)| a.abs_diff(b)));
        let most = if channels == 1 { 0 } else { 4 };
        assert!(off.max().is_some_and(|off| off <= most) && read[0].samples.depth() == Depth::U16, "{channels}");
    }
    let floats = write(&folder.path("d.y4m"), &frames(Depth::F32, 3, false, [1, 2, 2]), rate("25")).unwrap_err();
    assert!(floats.to_string().contains("float samples are not supported in y4m"), "{floats}");
}

#[test]
fn y4m_of_every_chroma_is_read_where_it_lies() {
    // 3x2 of limited range: luma rises, chroma is neutral but for one sample.
    let luma = [16, 60, 100, 140, 180, 235];
    let expected = luma.map(|v: u32| ((v - 16) * 255 * 2 + 219) / (2 * 219));
    for (tag, chroma) in [("C420jpeg", 2), ("C422", 4), ("C444", 6), ("Cmono XCOLORRANGE=LIMITED", 0)] {
        let mut bytes = format!("YUV4MPEG2 W3 H2 F25:1 Ip {tag}\nFRAME Ixyz\n").into_bytes();
        bytes.extend(luma.map(|v| v as u8));
        bytes.extend(std::iter::repeat_n(128, 2 * chroma));
        let read = whole(&bytes).unwrap();
        assert_eq!(bits(&read[0])[..6], expected, "{tag}");
        assert_eq!(read[0].samples.channels(), if chroma == 0 { 1 } else { 3 });
    }
    // The same of ten bits, low byte first, as samples of 16; the full range of mono by default.
    let deep = luma.map(|v: u32| ((4 * v - 64) * 65_535 * 2 + 876) / (2 * 876));
    for (tag, chroma) in [("C420p10", 2), ("C422p10", 4), ("C444p10", 6), ("Cmono10 XCOLORRANGE=LIMITED", 0)] {
        let mut bytes = format!("YUV4MPEG2 W3 H2 F25:1 Ip {tag}\nFRAME\n").into_bytes();
        bytes.extend(luma.iter().flat_map(|v| (4 * *v as u16).to_le_bytes()));
        bytes.extend(std::iter::repeat_n(512_u16.to_le_bytes(), 2 * chroma).flatten());
        assert_eq!(bits(&whole(&bytes).unwrap()[0])[..6], deep, "{tag}");
    }
    let full = [&b"YUV4MPEG2 W1 H1 F25:1 Ip Cmono12\nFRAME\n"[..], &4095_u16.to_le_bytes()].concat();
    assert_eq!(bits(&whole(&full).unwrap()[0]), [65_535]);
    let wrong = |text: &str| of(text.as_bytes()).unwrap_err().to_string();
    for tag in ["444p8", "444p17", "444alpha", "mono8", "411"] {
        let text = wrong(&format!("YUV4MPEG2 W2 H2 F25:1 C{tag}\nFRAME\n"));
        assert!(text.contains(&format!("chroma '{tag}' is not supported in y4m")), "{text}");
    }
    assert!(wrong("YUV4MPEG2 W2 H2 F25:1 It C444\n").contains("interlaced frames"));
    assert!(wrong("YUV4MPEG2 W0 H2 F25:1 C444\n").contains("0x2 px has no samples"));
    assert!(wrong("YUV4MPEG2 W99999999 H9999999 F25:1 C444\n").contains("over the cap"));
    assert!(wrong("YUV4MPEG2 W4294967295 H4294967295 F25:1 C444\n").contains("over the cap"));
    assert!(wrong("YUV4MPEG2 W2 H2 F1:0 C444\n").contains("'1:0' is no rate"));
    assert!(wrong("YUV4MPEG2 W2 H2 F25:1 C444\n").contains("it ends early"));
    assert!(wrong("moov").contains("ffmpeg -i FILE"));
}

#[test]
fn frames_unlike_the_first_are_written_nowhere() {
    let folder = Folder::new("unlike");
    let first = frames(Depth::U8, 3, false, [2, 4, 5]);
    let others = [frames(Depth::U8, 3, false, [1, 5, 4]), frames(Depth::U8, 1, false, [1, 4, 5])];
    for (name, other) in ["a.png", "a.gif", "a.y4m", "a_##_2k.png"].iter().zip(others.iter().cycle()) {
        let mut writer = write(&folder.path(name), &first, rate("25")).unwrap_or_else(|e| panic!("{name}: {e}"));
        let wrong = writer.frame(&other[0]).unwrap_err();
        assert!(matches!(wrong.problem, Problem::Clip(ClipProblem::Differs { number: 3, .. })), "{name}: {wrong}");
    }
}

#[test]
fn every_prefix_is_an_error() {
    let folder = Folder::new("prefix");
    for name in ["a.png", "a.gif", "a.y4m"] {
        let written = if name == "a.gif" { few(3, 3, false) } else { frames(Depth::U8, 3, false, [3, 4, 5]) };
        let bytes = file(&folder, name, &written, rate("25"));
        assert_eq!(whole(&bytes).unwrap().len(), 3);
        // Nobody needs the trailer of a GIF.
        let spare = if name == "a.gif" { 2 } else { 0 };
        for end in 0..bytes.len() - spare {
            match whole(&bytes[..end]) {
                Err(e) => assert!(!e.to_string().contains(char::is_control), "{e}"),
                // Whole frames are a clip: y4m does not say how many follow.
                Ok(read) => assert!(name == "a.y4m" && read.len() < 3, "{name} cut at {end} gave {}", read.len()),
            }
        }
    }
}

#[test]
fn ranges_choose_frames_by_place() {
    let folder = Folder::new("places");
    let written = frames(Depth::U8, 1, false, [7, 2, 2]);
    let path = folder.path("a.png");
    write(&path, &written, rate("25")).unwrap().finish().unwrap();
    let some =
        |range: &str| ClipReader::open(&path, &ClipOptions { range: range.parse().ok(), ..ClipOptions::default() });
    let mut reader = some("2-6x2").unwrap();
    assert_eq!(reader.info().frames, 3);
    assert_eq!(all(&mut reader), [1, 3, 5].map(|i: usize| written[i].clone()));
    reader.rewind().unwrap();
    assert_eq!(all(&mut reader).len(), 3);
    assert!(some("5-8").unwrap_err().to_string().contains("frame 8 is missing after 7"));
    // Of a GIF no more is decoded than is wanted, and no more than a clip may have.
    let path = folder.path("a.gif");
    write(&path, &few(7, 3, false), rate("25")).unwrap().finish().unwrap();
    let opened = |range: Option<&str>, samples: u64| {
        let limits = selvedge_core::Limits { samples, ..Default::default() };
        let frame = ReadOptions { limits, ..ReadOptions::default() };
        let range = range.and_then(|range| range.parse().ok());
        ClipReader::open(&path, &ClipOptions { range, frame, ..ClipOptions::default() })
    };
    let info = opened(None, u64::MAX).unwrap().info().clone();
    assert_eq!(info.frames, 7);
    let frame = u64::from(info.width) * u64::from(info.height);
    let refused = opened(None, 7 * frame - 1).unwrap_err().to_string();
    assert!(refused.contains("7 frames of") && refused.contains("over the cap"), "{refused}");
    let mut three = opened(Some("1-3"), 7 * frame - 1).unwrap();
    assert_eq!(all(&mut three).len(), 3);
    assert!(three.warnings().is_empty());
    assert!(opened(Some("5-8"), u64::MAX).unwrap_err().to_string().contains("frame 8 is missing after 7"));
}

#[test]
fn frames_that_are_shown_longer_than_others_are_told() {
    let folder = Folder::new("uneven");
    let write = |delays: &[u16]| {
        let mut file = Vec::new();
        let mut encoder = gif::Encoder::new(&mut file, 1, 1, &[0, 0, 0, 90, 90, 90]).unwrap();
        for &delay in delays {
            let buffer = std::borrow::Cow::Owned(vec![1]);
            encoder.write_frame(&gif::Frame { width: 1, height: 1, delay, buffer, ..gif::Frame::default() }).unwrap();
        }
        drop(encoder);
        std::fs::write(folder.path("a.gif"), &file).unwrap();
        let reader = ClipReader::open(folder.path("a.gif"), &ClipOptions::default()).unwrap();
        reader.warnings().iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert!(write(&[3, 3, 4]).is_empty(), "30 a second, rounded");
    assert!(write(&[10, 10, 200])[0].contains("shown longer than others"));
}

#[test]
fn flipbooks_hold_frames_row_by_row_with_their_borders_repeated() {
    let folder = Folder::new("flipbook");
    for (name, depth, pad) in [("a.png", Depth::U8, 0), ("b.png", Depth::U16, 2), ("c.exr", Depth::F16, 1)] {
        let written = frames(depth, 3, false, [6, 4, 5]);
        let book = Flipbook { pad, .."3x2".parse().unwrap() };
        let options = ClipWriteOptions { flipbook: Some(book), period: Some(6), ..rate("24") };
        write(&folder.path(name), &written, options).unwrap().finish().unwrap();
        let sheet = selvedge_io::read(folder.path(name), &ReadOptions::default()).unwrap().plane;
        assert_eq!(sheet.domain().shape, [2 * (4 + 2 * pad), 3 * (5 + 2 * pad)]);
        let options = ClipOptions { flipbook: Some(book), ..ClipOptions::default() };
        let read = all(&mut ClipReader::open(folder.path(name), &options).unwrap());
        assert!(read.len() == 6 && read.iter().zip(&written).all(|(a, b)| bits(a) == bits(b)), "{name}");
        let manifest = std::fs::read_to_string(folder.path(name).with_extension("json")).unwrap();
        for part in ["\"frames\": 6,", "\"columns\": 3", &format!("\"pad\": {pad}"), "\"rate\": [24, 1]"] {
            assert!(manifest.contains(part), "{part}: {manifest}");
        }
        assert_eq!(manifest.matches("\"frames\"").count(), 1);
    }
    let sheet = selvedge_io::read(folder.path("b.png"), &ReadOptions::default()).unwrap().plane;
    let value = |y: u32, x: u32| sheet.samples.value(0, sheet.domain().index([y, x]));
    assert_eq!(value(0, 0), value(2, 2), "the corner is repeated");
    assert_eq!(value(7, 8), value(5, 6), "at every corner");
    let open = |book: &str| {
        let options = ClipOptions { flipbook: book.parse().ok(), ..ClipOptions::default() };
        ClipReader::open(folder.path("a.png"), &options).unwrap_err().to_string()
    };
    assert!(open("4x2").contains("15x8 px are not 4x2 frames"));
    for wrong in ["", "8", "0x8", "8x", "8x8x8", "9999x1"] {
        assert!(wrong.parse::<Flipbook>().is_err(), "{wrong}");
    }
    let written = frames(Depth::U8, 3, false, [3, 4, 5]);
    let options = ClipWriteOptions { flipbook: "2x1".parse().ok(), ..ClipWriteOptions::default() };
    let full = write(&folder.path("d.png"), &written, options).unwrap_err().to_string();
    assert!(full.contains("3 frames are more than a flipbook of 2x1 holds"), "{full}");
}
