//! JPEG against libjpeg's values, and against what was put in, over all sampling factors and kinds of scans.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, Picture, Problem, ReadOptions, Warning, WriteOptions, decode, encode};

/// 27x21 px of `cobbles.png`, one file after the other.
const FILES: &[u8] = include_bytes!("../../../../fixtures/jpegs.bin");

/// Sampling factors, or colours, and scans: `il` interleaved, `ni` one a component, `mix` luma alone and chroma
/// together, `prog` progressive; the file's length; the first 16 digits of BLAKE3 of the interleaved samples that
/// libjpeg-turbo gives. CMYK is turned into RGB by multiplication, rounded.
const LIBJPEG: [(&str, usize, &str); 56] = [
    ("1x1-1x1-1x1-il", 547, "93436f2d750afa04"),
    ("1x1-1x1-1x1-mix", 577, "93436f2d750afa04"),
    ("1x1-1x1-1x1-ni", 614, "93436f2d750afa04"),
    ("1x1-1x1-1x1-prog", 789, "93436f2d750afa04"),
    ("1x1-2x1-1x2-il", 417, "1f7ced6a8069fe77"),
    ("1x1-2x1-1x2-mix", 438, "1f7ced6a8069fe77"),
    ("1x1-2x1-1x2-ni", 481, "1f7ced6a8069fe77"),
    ("1x1-2x1-1x2-prog", 665, "1f7ced6a8069fe77"),
    ("1x1-2x2-2x2-il", 436, "3cd8fb35dad1eb5b"),
    ("1x1-2x2-2x2-mix", 457, "3cd8fb35dad1eb5b"),
    ("1x1-2x2-2x2-ni", 499, "3cd8fb35dad1eb5b"),
    ("1x1-2x2-2x2-prog", 686, "3cd8fb35dad1eb5b"),
    ("1x2-1x1-1x1-il", 541, "dfb659ccd385bf07"),
    ("1x2-1x1-1x1-mix", 560, "dfb659ccd385bf07"),
    ("1x2-1x1-1x1-ni", 603, "dfb659ccd385bf07"),
    ("1x2-1x1-1x1-prog", 781, "dfb659ccd385bf07"),
    ("1x3-1x1-1x1-il", 513, "d6abc499af777d3a"),
    ("1x3-1x1-1x1-mix", 533, "d6abc499af777d3a"),
    ("1x3-1x1-1x1-ni", 577, "d6abc499af777d3a"),
    ("1x3-1x1-1x1-prog", 745, "d6abc499af777d3a"),
    ("1x4-2x2-1x1-il", 449, "241fa87254f98d46"),
    ("1x4-2x2-1x1-mix", 462, "241fa87254f98d46"),
    ("1x4-2x2-1x1-ni", 510, "241fa87254f98d46"),
    ("1x4-2x2-1x1-prog", 692, "241fa87254f98d46"),
    ("2x1-1x1-1x1-il", 518, "a4a4c0edc610890c"),
    ("2x1-1x1-1x1-mix", 539, "a4a4c0edc610890c"),
    ("2x1-1x1-1x1-ni", 581, "a4a4c0edc610890c"),
    ("2x1-1x1-1x1-prog", 749, "a4a4c0edc610890c"),
    ("2x2-1x1-1x1-il", 510, "10d7a8ba9330083e"),
    ("2x2-1x1-1x1-mix", 528, "10d7a8ba9330083e"),
    ("2x2-1x1-1x1-ni", 569, "10d7a8ba9330083e"),
    ("2x2-1x1-1x1-prog", 744, "10d7a8ba9330083e"),
    ("2x2-1x1-2x1-il", 525, "e9ac044a548605b0"),
    ("2x2-1x1-2x1-mix", 543, "e9ac044a548605b0"),
    ("2x2-1x1-2x1-ni", 585, "e9ac044a548605b0"),
    ("2x2-1x1-2x1-prog", 760, "e9ac044a548605b0"),
    ("2x4-1x2-2x1-mix", 535, "18d66e60cd562624"),
    ("2x4-1x2-2x1-ni", 577, "18d66e60cd562624"),
    ("3x1-1x1-3x1-il", 539, "799328d111c66d43"),
    ("3x1-1x1-3x1-mix", 555, "799328d111c66d43"),
    ("3x1-1x1-3x1-ni", 596, "799328d111c66d43"),
    ("3x1-1x1-3x1-prog", 771, "799328d111c66d43"),
    ("3x3-1x1-3x1-mix", 523, "4d71682b64e97e76"),
    ("3x3-1x1-3x1-ni", 566, "4d71682b64e97e76"),
    ("4x1-1x1-1x1-il", 503, "fc130e1c8d67b70f"),
    ("4x1-1x1-1x1-mix", 522, "fc130e1c8d67b70f"),
    ("4x1-1x1-1x1-ni", 563, "fc130e1c8d67b70f"),
    ("4x1-1x1-1x1-prog", 733, "fc130e1c8d67b70f"),
    ("4x2-1x1-2x1-mix", 519, "f148fe8f1dbb6d63"),
    ("4x2-1x1-2x1-ni", 560, "f148fe8f1dbb6d63"),
    ("4x4-2x2-1x4-mix", 527, "efc5f0b4165beaf9"),
    ("4x4-2x2-1x4-ni", 567, "efc5f0b4165beaf9"),
    ("cmyk", 719, "5b2e4c788ad29e62"),
    ("grey-il", 352, "52298ed4cbc9cb8c"),
    ("rgb-il", 703, "5b2e4c788ad29e62"),
    ("ycck", 523, "0ecd22098a2b54e4"),
];

fn load(bytes: &[u8]) -> Result<Picture, Problem> {
    decode(bytes, "x.jpg", &ReadOptions::default()).map_err(|e| e.problem)
}

fn interleaved(picture: &Picture) -> Vec<u8> {
    let Samples::U8(grid) = &picture.plane.samples else { panic!("not 8 bits") };
    grid.to_interleaved().unwrap()
}

/// The files by name.
fn files() -> impl Iterator<Item = (&'static str, &'static [u8], &'static str)> {
    let mut rest = FILES;
    LIBJPEG.into_iter().map(move |(name, len, hash)| {
        let (file, after) = rest.split_at(len);
        rest = after;
        (name, file, hash)
    })
}

#[test]
fn samples_are_those_of_libjpeg() {
    for (name, file, hash) in files() {
        let picture = load(file).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(&blake3::hash(&interleaved(&picture)).to_hex()[..16], hash, "{name}");
        assert_eq!(picture.plane.domain().shape, [21, 27]);
        let inks = ["cmyk", "ycck"].contains(&name);
        assert_eq!(picture.warnings, if inks { vec![Warning::CmykConverted] } else { vec![] }, "{name}");
    }
}

/// A slope of luma or chroma, at a place of the picture.
fn slope(component: usize, y: f64, x: f64) -> f64 {
    [60.0 + 1.5 * x + y, 150.0 - 0.8 * x + 0.4 * y, 100.0 + 0.5 * x + 0.9 * y][component]
}

/// A grey JPEG's tables before its frame, its Huffman tables, and its entropy-coded data.
fn parts(jpeg: &[u8]) -> (Vec<u8>, Vec<u8>, Vec<u8>) {
    let (mut quantization, mut huffman, mut at) = (Vec::new(), Vec::new(), 2);
    loop {
        let len = 2 + usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]]));
        let segment = &jpeg[at..at + len];
        at += len;
        match segment[1] {
            0xdb => quantization.extend(segment),
            0xc4 => huffman.extend(segment),
            0xda => return (quantization, huffman, jpeg[at..jpeg.len() - 2].to_vec()),
            _ => {}
        }
    }
}

/// A baseline file of three components with these vertical and horizontal factors, one scan each.
fn of_components([height, width]: [u32; 2], factors: [[u32; 2]; 3]) -> Vec<u8> {
    let most = [0, 1].map(|axis| factors.iter().map(|f| f[axis]).max().unwrap());
    let mut frame = b"\xff\xc0\0\x11\x08".to_vec();
    frame.extend([(height as u16).to_be_bytes(), (width as u16).to_be_bytes()].concat());
    frame.push(3);
    let (mut head, mut scans) = (b"\xff\xd8".to_vec(), Vec::new());
    for (c, [v, h]) in factors.into_iter().enumerate() {
        let size = [(height * v).div_ceil(most[0]), (width * h).div_ceil(most[1])];
        let steps = [f64::from(most[0]) / f64::from(v), f64::from(most[1]) / f64::from(h)];
        let domain = Domain::open(size);
        let at = |[y, x]: [u32; 2]| [(f64::from(y) + 0.5) * steps[0] - 0.5, (f64::from(x) + 0.5) * steps[1] - 0.5];
        let values = domain.positions().map(at).map(|[y, x]| (slope(c, y, x) + 0.5) as u8).collect();
        let grey = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, values).unwrap()));
        let options = WriteOptions { quality: 100, ..WriteOptions::default() };
        let (quantization, huffman, data) = parts(&encode(&grey, &Metadata::default(), "x.jpg", &options).unwrap());
        if c == 0 {
            head.extend(quantization);
            scans.extend(huffman);
        }
        frame.extend([c as u8 + 1, (h << 4 | v) as u8, 0]);
        scans.extend([0xff, 0xda, 0, 8, 1, c as u8 + 1, 0, 0, 63, 0]);
        scans.extend(data);
    }
    [head, frame, scans, b"\xff\xd9".to_vec()].concat()
}

#[test]
fn every_sampling_factor_shows_what_was_put_in() {
    let shape = [35, 43];
    let all: Vec<[u32; 2]> = (1..5).flat_map(|v| (1..5).map(move |h| [v, h])).collect();
    for (i, luma) in all.iter().enumerate() {
        for (k, blue) in all.iter().enumerate() {
            let factors = [*luma, *blue, all[(i + 5 * k) % 16]];
            let picture = load(&of_components(shape, factors)).unwrap_or_else(|e| panic!("{factors:?}: {e}"));
            let Samples::U8(grid) = &picture.plane.samples else { unreachable!() };
            for at in grid.domain().positions() {
                let [y, cb, cr] = [0, 1, 2].map(|c| slope(c, f64::from(at[0]), f64::from(at[1])));
                let (cb, cr) = (cb - 128.0, cr - 128.0);
                let expected = [y + 1.402 * cr, y - 0.344_14 * cb - 0.714_14 * cr, y + 1.772 * cb];
                for (c, expected) in expected.into_iter().enumerate() {
                    let off = f64::from(grid.get(c, at)) - expected.clamp(0.0, 255.0);
                    // A sample of a component may cover four, of which the slope's greatest step is 1.5.
                    assert!(off.abs() < 8.0, "{factors:?}: {off} at {at:?} in channel {c}");
                }
            }
        }
    }
}

#[test]
fn of_what_is_missing_only_the_end_marker_may_be() {
    for (name, file, _) in files() {
        let whole = load(file).unwrap();
        for cut in [1, 2] {
            let picture = load(&file[..file.len() - cut]).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(picture.plane, whole.plane, "{name}");
            assert!(picture.warnings.contains(&Warning::EndMarkerMissing), "{name}");
        }
        for cut in (4..file.len() - 2).step_by(7) {
            let refused = load(&file[..file.len() - cut]).expect_err(name);
            assert!(matches!(refused, Problem::Damaged { .. }), "{name} without {cut} bytes: {refused}");
        }
    }
}

#[test]
fn arithmetic_coding_is_not_damage() {
    let refused = load(include_bytes!("../../../../fixtures/arithmetic.jpg")).unwrap_err();
    assert_eq!(refused.to_string(), "arithmetic coding is not supported in jpeg");
}
