//! Files that claim, or unpack to, far more than they are: refused by their header, within little memory.

use std::fs;

use selvedge_core::Limits;
use selvedge_io::clip::{ClipOptions, ClipReader};
use selvedge_io::{ErrorKind, ReadOptions, Warning, decode, probe_bytes};
use selvedge_testkit::memory;

/// Of sizes that are allowed.
const SIDE: u32 = 16_000;
/// Each may take this many bytes.
const ROOM: u64 = 64 << 20;

/// The most bytes held so far, or since a reset; `None`, said aloud, where the system does not tell.
fn peak(reset: bool) -> Option<u64> {
    let peak = memory::peak();
    if reset && fs::write("/proc/self/clear_refs", "5").is_err() {
        eprintln!("SKIPPED: the peak of memory cannot be reset here");
        return None;
    }
    peak
}

pub(crate) fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
    chunk.extend(kind);
    chunk.extend(data);
    chunk.extend(crc32(&chunk[4..]).to_be_bytes());
    chunk
}

fn crc32(bytes: &[u8]) -> u32 {
    bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| c >> 1 ^ (0xedb8_8320 & (c & 1).wrapping_neg()))
    }) ^ u32::MAX
}

pub(crate) fn png(width: u32, height: u32, depth: u8, color: u8, rest: &[Vec<u8>]) -> Vec<u8> {
    let mut header = [width.to_be_bytes(), height.to_be_bytes()].concat();
    header.extend([depth, color, 0, 0, 0]);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    file.extend(chunk(b"IHDR", &header));
    rest.iter().for_each(|c| file.extend(c));
    file.extend(chunk(b"IEND", &[]));
    file
}

/// An uncompressed little-endian TIFF with nothing but these tags.
fn tiff(width: u32, height: u32, tile: Option<u32>) -> Vec<u8> {
    let mut tags = vec![(256, width), (257, height), (258, 8), (259, 1), (262, 1)];
    match tile {
        Some(side) => tags.extend([(322, side), (323, side), (324, 8), (325, 100)]),
        None => tags.extend([(273, 8), (278, height), (279, 100)]),
    }
    let mut file = b"II\x2a\0\x08\0\0\0".to_vec();
    file.extend((tags.len() as u16).to_le_bytes());
    for (tag, value) in tags {
        file.extend([(tag as u16).to_le_bytes(), 4_u16.to_le_bytes()].concat());
        file.extend([1_u32.to_le_bytes(), value.to_le_bytes()].concat());
    }
    file.extend([0; 4]);
    file
}

fn jpeg(width: u16, height: u16) -> Vec<u8> {
    let mut file = b"\xff\xd8\xff\xc0\0\x0b\x08".to_vec();
    file.extend([height.to_be_bytes(), width.to_be_bytes()].concat());
    file.extend(b"\x01\x01\x11\0\xff\xda\0\x08\x01\x01\0\0\x3f\0\xff\xd9");
    file
}

fn claims() -> Vec<(&'static str, Vec<u8>)> {
    let mut gif = b"GIF89a\xff\xff\xff\xff\0\0\0,\0\0\0\0\xff\xff\xff\xff\0\x02".to_vec();
    gif.extend([0, b';']);
    let mut later = b"GIF89a\x01\0\x01\0\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x01\0\x01\0\0\x02\x02\x44\x01\0".to_vec();
    later.extend(b",\0\0\0\0\xff\xff\xff\xff\0\x02\x02\x44\x01\0;");
    let mut bmp = b"BM\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
    bmp.extend([(1_u32 << 30).to_le_bytes(), (1_u32 << 30).to_le_bytes()].concat());
    bmp.extend(b"\x01\0\x18\0");
    bmp.resize(58, 0);
    let mut webp = b"RIFF\x12\0\0\0WEBPVP8L\x05\0\0\0\x2f".to_vec();
    webp.extend(((16_383_u32 - 1) | ((16_383 - 1) << 14)).to_le_bytes());
    webp.push(0);
    let mut tga = b"\0\0\x0a\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x20\0".to_vec();
    tga.extend([0x83, 1, 2, 3, 4]);
    vec![
        ("tga of 65,535 squared", tga),
        ("png of 60,000 squared", png(60_000, 60_000, 8, 2, &[chunk(b"IDAT", &[0; 8])])),
        ("png of 2^31 - 1 by 1", png(i32::MAX as u32, 1, 8, 2, &[chunk(b"IDAT", &[0; 8])])),
        ("png of 2^31 - 1 squared", png(i32::MAX as u32, i32::MAX as u32, 16, 6, &[chunk(b"IDAT", &[0; 8])])),
        ("png within the caps, over the budget", png(60_000, 4_000, 16, 6, &[chunk(b"IDAT", &[0; 8])])),
        ("tiff of 2^32 - 1 squared", tiff(u32::MAX, u32::MAX, None)),
        ("tiff within the caps, over the budget", tiff(60_000, 4_000, None)),
        ("tiff of one sample in a huge tile", tiff(1, 1, Some(1 << 30))),
        ("jpeg of 65,535 squared", jpeg(65_535, 65_535)),
        ("hdr of 2 * 10^9", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n\x02\x02".to_vec()),
        ("gif of 65,535 squared", gif),
        ("gif whose second frame is 65,535 squared", later),
        ("bmp of 2^30 squared", bmp),
        ("webp of 16,383 squared", webp),
    ]
}

/// Sizes that are allowed, over data that end at once.
fn small_claims() -> Vec<(&'static str, Vec<u8>)> {
    let idat = || chunk(b"IDAT", &[0x78, 0x9c, 0x63]);
    let palette = chunk(b"PLTE", &[1, 2, 3]);
    let bmp = |bits: u8, packed: u8| {
        let mut bmp = b"BM\x76\0\0\0\0\0\0\0\x76\0\0\0\x28\0\0\0".to_vec();
        bmp.extend([SIDE.to_le_bytes(), SIDE.to_le_bytes()].concat());
        bmp.extend([1, 0, bits, 0, packed]);
        bmp.resize(46, 0);
        bmp.extend([16, 0, 0, 0]);
        bmp.resize(120, 0);
        bmp
    };
    let mut gif = b"GIF89a".to_vec();
    gif.extend([SIDE as u16; 2].map(u16::to_le_bytes).concat());
    gif.extend(b"\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0");
    gif.extend([SIDE as u16; 2].map(u16::to_le_bytes).concat());
    gif.extend(b"\0\x02\x01\x44");
    let tga = |kind: u8, bits: u8| {
        let mut tga = vec![0, u8::from(kind % 8 == 1), kind, 0, 0, 1, 0, 24, 0, 0, 0, 0];
        tga.extend([SIDE as u16; 2].map(u16::to_le_bytes).concat());
        tga.extend([bits, 0, 1, 2, 3, 4]);
        tga
    };
    let hdr = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {SIDE} +X {SIDE}\n\x02\x02");
    let mut progressive = jpeg(SIDE as u16, SIDE as u16);
    progressive[3] = 0xc2;
    vec![
        ("png", png(SIDE, SIDE, 8, 2, &[idat()])),
        ("deep png", png(SIDE, SIDE, 16, 6, &[idat()])),
        ("palette png", png(SIDE, SIDE, 8, 3, &[palette, idat()])),
        ("hdr", hdr.into_bytes()),
        ("bmp", bmp(24, 0)),
        ("bmp with alpha", bmp(32, 0)),
        ("palette bmp", bmp(8, 0)),
        ("packed bmp", bmp(8, 1)),
        ("tiff", tiff(SIDE, SIDE, None)),
        ("tiled tiff", tiff(SIDE, SIDE, Some(SIDE))),
        ("jpeg", jpeg(SIDE as u16, SIDE as u16)),
        ("progressive jpeg", progressive),
        ("gif", gif),
        ("tga", tga(2, 24)),
        ("packed tga", tga(10, 32)),
        ("palette tga", tga(1, 8)),
        ("packed palette tga", tga(9, 8)),
    ]
}

#[test]
fn bombs_do_not_go_off() {
    const TEST: &str = "bombs::bombs_do_not_go_off";
    match memory::case(TEST) {
        Some(_) => set_off(),
        None => eprintln!("{}", memory::alone(TEST, "")),
    }
}

/// In a process of its own.
fn set_off() {
    let limits = Limits { memory: 256 << 20, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let bounded = |name: &str, before: Option<u64>| {
        if let (Some(before), Some(after)) = (before, peak(false)) {
            assert!(after <= before + ROOM, "{name}: {before} to {after} bytes");
        }
    };
    peak(true);
    for (name, bytes) in claims() {
        let before = peak(false);
        let refused = match decode(&bytes, "x", &options) {
            // A padded tile of which one sample is in the file can be read without ever making the rest.
            Ok(picture) if name.contains("tile") => {
                assert_eq!(picture.plane.domain().len(), 1);
                continue;
            }
            read => read.expect_err(name),
        };
        assert!(matches!(refused.kind(), ErrorKind::Input | ErrorKind::Memory), "{name}: {refused}");
        assert!(bytes.len() < 200, "{name}: too large for a claim");
        let _ = probe_bytes(&bytes, "x", &options);
        bounded(name, before);
        eprintln!("{name}: {refused}");
    }

    // Within all caps: as much memory as rows that are there, which are none.
    let wide = ReadOptions::default();
    for (name, bytes) in small_claims() {
        peak(true);
        let before = memory::held();
        assert!(decode(&bytes, "x", &wide).is_err(), "{name}");
        bounded(name, before);
    }
    peak(true);
    let before = memory::held();
    let y4m = format!("YUV4MPEG2 W{SIDE} H{SIDE} F25:1 C444\nFRAME\n").into_bytes();
    assert!(ClipReader::of_bytes(y4m, "x", &ClipOptions::default()).is_err());
    bounded("y4m", before);

    // 64 MiB of profile in 64 KiB: the picture is fine without it.
    let profile = vec![0; 64 << 20];
    let mut info = png::Info::with_size(4, 4);
    (info.color_type, info.icc_profile) = (png::ColorType::Rgb, Some(profile.into()));
    let mut file = Vec::new();
    let mut writer = png::Encoder::with_info(&mut file, info).unwrap().write_header().unwrap();
    writer.write_image_data(&[9; 48]).unwrap();
    drop(writer);
    assert!(file.len() < 1 << 20);
    let before = peak(true).and_then(|_| peak(false));
    let picture = decode(&file, "x", &options).unwrap();
    assert_eq!((picture.metadata.icc, &picture.warnings[..]), (None, &[Warning::ProfileLeftOut][..]));
    assert_eq!(probe_bytes(&file, "x", &options).unwrap().warnings, [Warning::ProfileLeftOut]);
    bounded("packed profile", before);

    let texts: Vec<Vec<u8>> = (0..2_000).map(|_| chunk(b"tEXt", &[b'x'; 1_000])).collect();
    let mut wanted = texts.clone();
    wanted.push(chunk(b"IDAT", &[0x78, 0x01, 0x01, 2, 0, 0xfd, 0xff, 0, 7, 0, 9, 0, 8]));
    assert!(decode(&png(1, 1, 8, 0, &wanted), "x", &options).is_ok());
    let heavy = png(1, 1, 8, 0, &[chunk(b"iTXt", &[b'x'; 20 << 20])]);
    assert_eq!(decode(&heavy, "x", &options).unwrap_err().kind(), ErrorKind::Input);
}
