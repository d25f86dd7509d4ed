//! TIFF against another reader's values, over compressions, depths, planar configurations, strips, tiles and
//! predictors; what is refused by its name, and what is left out aloud.

use selvedge_core::Samples;
use selvedge_io::{Picture, Problem, ReadOptions, Warning, decode, probe_bytes};

/// 19x17 px of `cobbles.png`, one file after the other.
const FILES: &[u8] = include_bytes!("../../../../fixtures/tiffs.bin");

/// Compression, depth, planar configuration (`separate` files are big-endian), strips of 5 rows or tiles of 16 px (in
/// u16 BigTIFF), predictor; the file's length; the first 16 digits of BLAKE3 of the interleaved little-endian samples
/// that tifffile gives.
const TIFFFILE: [(&str, usize, &str); 68] = [
    ("zstd-u8-contig-strips-plain", 1232, "59e22952e5feec07"),
    ("zstd-u8-contig-strips-pred", 1200, "59e22952e5feec07"),
    ("zstd-u8-contig-tiles-plain", 1309, "59e22952e5feec07"),
    ("zstd-u8-contig-tiles-pred", 1246, "59e22952e5feec07"),
    ("zstd-u8-separate-strips-plain", 1349, "59e22952e5feec07"),
    ("zstd-u8-separate-strips-pred", 1365, "59e22952e5feec07"),
    ("zstd-u8-separate-tiles-plain", 1533, "59e22952e5feec07"),
    ("zstd-u8-separate-tiles-pred", 1556, "59e22952e5feec07"),
    ("zstd-u16-contig-strips-plain", 2090, "e2d89d56383fcd01"),
    ("zstd-u16-contig-strips-pred", 1887, "e2d89d56383fcd01"),
    ("zstd-u16-contig-tiles-plain", 2313, "e2d89d56383fcd01"),
    ("zstd-u16-contig-tiles-pred", 2062, "e2d89d56383fcd01"),
    ("zstd-u16-separate-strips-plain", 2313, "e2d89d56383fcd01"),
    ("zstd-u16-separate-strips-pred", 2222, "e2d89d56383fcd01"),
    ("zstd-u16-separate-tiles-plain", 2646, "e2d89d56383fcd01"),
    ("zstd-u16-separate-tiles-pred", 2575, "e2d89d56383fcd01"),
    ("zstd-half-contig-strips-plain", 1824, "3e4bf954e6cfd6bd"),
    ("zstd-half-contig-strips-pred", 1845, "3e4bf954e6cfd6bd"),
    ("zstd-half-contig-tiles-plain", 1897, "3e4bf954e6cfd6bd"),
    ("zstd-half-contig-tiles-pred", 1920, "3e4bf954e6cfd6bd"),
    ("zstd-half-separate-strips-plain", 2171, "3e4bf954e6cfd6bd"),
    ("zstd-half-separate-strips-pred", 2106, "3e4bf954e6cfd6bd"),
    ("zstd-half-separate-tiles-plain", 2312, "3e4bf954e6cfd6bd"),
    ("zstd-half-separate-tiles-pred", 2391, "3e4bf954e6cfd6bd"),
    ("zstd-float-contig-strips-plain", 2691, "4bb458b8494a5a99"),
    ("zstd-float-contig-strips-pred", 1983, "4bb458b8494a5a99"),
    ("zstd-float-contig-tiles-plain", 2618, "4bb458b8494a5a99"),
    ("zstd-float-contig-tiles-pred", 2318, "4bb458b8494a5a99"),
    ("zstd-float-separate-strips-plain", 3632, "4bb458b8494a5a99"),
    ("zstd-float-separate-strips-pred", 2346, "4bb458b8494a5a99"),
    ("zstd-float-separate-tiles-plain", 3512, "4bb458b8494a5a99"),
    ("zstd-float-separate-tiles-pred", 3022, "4bb458b8494a5a99"),
    ("zlib-u8-contig-strips-plain", 1222, "59e22952e5feec07"),
    ("zlib-u8-contig-strips-pred", 1128, "59e22952e5feec07"),
    ("zlib-u8-separate-tiles-plain", 1478, "59e22952e5feec07"),
    ("zlib-u8-separate-tiles-pred", 1438, "59e22952e5feec07"),
    ("zlib-u16-contig-strips-plain", 2029, "e2d89d56383fcd01"),
    ("zlib-u16-contig-strips-pred", 1721, "e2d89d56383fcd01"),
    ("zlib-u16-separate-tiles-plain", 2594, "e2d89d56383fcd01"),
    ("zlib-u16-separate-tiles-pred", 2455, "e2d89d56383fcd01"),
    ("zlib-float-contig-strips-plain", 2631, "4bb458b8494a5a99"),
    ("zlib-float-contig-strips-pred", 1942, "4bb458b8494a5a99"),
    ("zlib-float-separate-tiles-plain", 3339, "4bb458b8494a5a99"),
    ("zlib-float-separate-tiles-pred", 3004, "4bb458b8494a5a99"),
    ("lzw-u8-contig-strips-plain", 1266, "59e22952e5feec07"),
    ("lzw-u8-contig-strips-pred", 1195, "59e22952e5feec07"),
    ("lzw-u8-separate-tiles-plain", 1633, "59e22952e5feec07"),
    ("lzw-u8-separate-tiles-pred", 1662, "59e22952e5feec07"),
    ("lzw-u16-contig-strips-plain", 1809, "e2d89d56383fcd01"),
    ("lzw-u16-contig-strips-pred", 1663, "e2d89d56383fcd01"),
    ("lzw-u16-separate-tiles-plain", 2582, "e2d89d56383fcd01"),
    ("lzw-u16-separate-tiles-pred", 2510, "e2d89d56383fcd01"),
    ("lzw-float-contig-strips-plain", 3109, "4bb458b8494a5a99"),
    ("lzw-float-contig-strips-pred", 2762, "4bb458b8494a5a99"),
    ("lzw-float-separate-tiles-plain", 4091, "4bb458b8494a5a99"),
    ("lzw-float-separate-tiles-pred", 3882, "4bb458b8494a5a99"),
    ("packbits-u8-contig-strips-plain", 1210, "59e22952e5feec07"),
    ("packbits-u8-separate-tiles-plain", 1641, "59e22952e5feec07"),
    ("packbits-u16-contig-strips-plain", 2179, "e2d89d56383fcd01"),
    ("packbits-u16-separate-tiles-plain", 2754, "e2d89d56383fcd01"),
    ("packbits-float-contig-strips-plain", 4150, "4bb458b8494a5a99"),
    ("packbits-float-separate-tiles-plain", 4577, "4bb458b8494a5a99"),
    ("None-u8-contig-strips-plain", 1193, "59e22952e5feec07"),
    ("None-u8-separate-tiles-plain", 3360, "59e22952e5feec07"),
    ("None-u16-contig-strips-plain", 2162, "e2d89d56383fcd01"),
    ("None-u16-separate-tiles-plain", 6576, "e2d89d56383fcd01"),
    ("None-float-contig-strips-plain", 4116, "4bb458b8494a5a99"),
    ("None-float-separate-tiles-plain", 12592, "4bb458b8494a5a99"),
];

fn load(bytes: &[u8]) -> Result<Picture, Problem> {
    decode(bytes, "x.tif", &ReadOptions::default()).map_err(|e| e.problem)
}

fn little_endian(samples: &Samples<2>) -> Vec<u8> {
    match samples {
        Samples::U8(g) => g.to_interleaved().unwrap(),
        Samples::U16(g) | Samples::F16(g) => {
            g.to_interleaved().unwrap().into_iter().flat_map(u16::to_le_bytes).collect()
        }
        Samples::F32(g) => g.to_interleaved().unwrap().into_iter().flat_map(f32::to_le_bytes).collect(),
    }
}

/// The files by name.
fn files() -> impl Iterator<Item = (&'static str, &'static [u8], &'static str)> {
    let mut rest = FILES;
    TIFFFILE.into_iter().map(move |(name, len, hash)| {
        let (file, after) = rest.split_at(len);
        rest = after;
        (name, file, hash)
    })
}

#[test]
fn samples_are_those_of_another_reader() {
    let mut wrong = Vec::new();
    for (name, file, hash) in files() {
        match load(file) {
            Ok(picture) if blake3::hash(&little_endian(&picture.plane.samples)).to_hex()[..16] == *hash => {
                assert_eq!(picture.warnings, [], "{name}");
            }
            other => wrong.push(format!("{name}: {:?}", other.map(|_| "other samples"))),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn cut_and_flipped_zstd_is_damage() {
    let (_, file, _) = files().find(|(name, ..)| *name == "zstd-u8-contig-strips-plain").unwrap();
    for end in 0..file.len() {
        let _ = load(&file[..end]);
        for value in [0, 255] {
            let mut other = file.to_vec();
            other[end] = value;
            let _ = load(&other);
        }
    }
    let mut short = file.to_vec();
    short.truncate(file.len() - 10);
    assert!(matches!(load(&short), Err(Problem::Damaged { .. })));
}

/// A little-endian file of one strip, 2x1 px, of one value a tag.
fn tiff(tags: &[(u16, u32)], data: &[u8]) -> Vec<u8> {
    let mut tags: Vec<(u16, u32)> = [&[(256, 2), (257, 1), (278, 1)], tags].concat();
    let data_at = 8 + 2 + 12 * (tags.len() as u32 + 2) + 4;
    tags.extend([(273, data_at), (279, data.len() as u32)]);
    tags.sort_unstable();
    let mut file = b"II\x2a\0\x08\0\0\0".to_vec();
    file.extend((tags.len() as u16).to_le_bytes());
    for (tag, value) in tags {
        file.extend([tag.to_le_bytes(), 3_u16.to_le_bytes()].concat());
        file.extend([1_u32.to_le_bytes(), value.to_le_bytes()].concat());
    }
    file.extend([0; 4]);
    file.extend(data);
    file
}

#[test]
fn compressions_that_nobody_here_unpacks_have_their_names() {
    let said = [
        (7, "jpeg"),
        (6, "jpeg"),
        (34_925, "lzma"),
        (50_001, "webp"),
        (34_712, "jpeg 2000"),
        (50_002, "jpeg xl"),
        (4_711, "method 4711"),
    ];
    for (method, name) in said {
        let refused = load(&tiff(&[(258, 8), (259, method), (262, 1)], &[1, 2])).unwrap_err();
        assert_eq!(refused.to_string(), format!("compression by {name} is not supported in tiff"));
    }
}

#[test]
fn channels_that_are_left_out_are_told() {
    let extra = |kind: u32| tiff(&[(258, 8), (259, 1), (262, 2), (277, 4), (338, kind)], &[1, 2, 3, 4, 5, 6, 7, 8]);
    let unspecified = load(&extra(0)).unwrap();
    assert_eq!(little_endian(&unspecified.plane.samples), [1, 2, 3, 5, 6, 7]);
    let [Warning::ChannelsLeftOut { what }] = &unspecified.warnings[..] else { panic!("{:?}", unspecified.warnings) };
    assert_eq!(what, "1 of its 4 channels is neither colour nor alpha and left out; 'file.tif[4]' reads it");
    let info = probe_bytes(&extra(0), "x.tif", &ReadOptions::default()).unwrap();
    assert_eq!(info.warnings, unspecified.warnings);
    for kind in [1, 2] {
        let alpha = load(&extra(kind)).unwrap();
        assert_eq!(little_endian(&alpha.plane.samples), [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!((alpha.plane.alpha, alpha.warnings), (true, vec![]));
        assert_eq!(alpha.plane.is_premultiplied(), kind == 1);
    }
}

/// A file of 2x1 px of 8 bits, with these kinds of channels beside its colours; one or two, as they stand in the tag.
fn beside(colors: u32, kinds: &[u8], data: &[u8]) -> Vec<u8> {
    let photometric = if colors == 1 { 1 } else { 2 };
    let channels = colors + kinds.len() as u32;
    let mut file = tiff(&[(258, 8), (259, 1), (262, photometric), (277, channels), (338, 0)], data);
    // Bytes in place of one short.
    let at = file.windows(4).position(|tag| tag == [82, 1, 3, 0]).unwrap();
    file[at + 2] = 1;
    file[at + 4] = kinds.len() as u8;
    file[at + 8..][..kinds.len()].copy_from_slice(kinds);
    file
}

#[test]
fn alpha_is_found_among_all_channels_beside_grey_and_rgb() {
    let all: Vec<u8> = (1..=12).collect();
    for (colors, kinds, kept, alpha, left) in [
        (1, &[0, 2][..], &[0, 2][..], Some(false), "1 of its 3 channels is 2"),
        (1, &[2, 0], &[0, 1], Some(false), "1 of its 3 channels is 3"),
        (1, &[1, 0], &[0, 1], Some(true), "1 of its 3 channels is 3"),
        (1, &[0, 0], &[0], None, "2 of its 3 channels are 2"),
        (1, &[0], &[0], None, "1 of its 2 channels is 2"),
        (1, &[0, 0, 2], &[0, 3], Some(false), "2 of its 4 channels are 2"),
        (3, &[0, 2], &[0, 1, 2, 4], Some(false), "1 of its 5 channels is 4"),
        (3, &[0, 1], &[0, 1, 2, 4], Some(true), "1 of its 5 channels is 4"),
        (3, &[2, 0], &[0, 1, 2, 3], Some(false), "1 of its 5 channels is 5"),
        (3, &[0, 0, 2], &[0, 1, 2, 5], Some(false), "2 of its 6 channels are 4"),
    ] {
        let n = colors as usize + kinds.len();
        let file = beside(colors, kinds, &all[..2 * n]);
        let picture = load(&file).unwrap_or_else(|e| panic!("{colors} {kinds:?}: {e}"));
        let values: Vec<u8> = [0, n].iter().flat_map(|at| kept.iter().map(move |c| at + c)).map(|i| all[i]).collect();
        assert_eq!(little_endian(&picture.plane.samples), values, "{colors} {kinds:?}");
        let found = picture.plane.alpha.then_some(picture.plane.is_premultiplied());
        assert_eq!(found, alpha, "{colors} {kinds:?}");
        let beyond = |warning: &&Warning| !matches!(warning, Warning::BeyondAlpha { .. });
        let told: Vec<String> = picture.warnings.iter().filter(beyond).map(Warning::to_string).collect();
        let (count, first) = left.rsplit_once(' ').unwrap();
        let reads = if count.ends_with("is") { "it" } else { "the first" };
        let told_left = format!("{count} neither colour nor alpha and left out; 'file.tif[{first}]' reads {reads}");
        assert_eq!(told, [told_left], "{colors} {kinds:?}");
        let info = probe_bytes(&file, "x.tif", &ReadOptions::default()).unwrap();
        assert_eq!((info.channels, info.alpha), (kept.len(), alpha.is_some()), "{colors} {kinds:?}");
        for c in 0..n {
            let options = ReadOptions { channels: Some((c + 1).to_string()), ..ReadOptions::default() };
            let one = decode(&file, "x.tif", &options).unwrap();
            assert_eq!((little_endian(&one.plane.samples), one.warnings), (vec![all[c], all[n + c]], vec![]));
        }
    }
}

#[test]
fn channels_are_chosen_by_their_numbers() {
    let extra = |kind: u32| tiff(&[(258, 8), (259, 1), (262, 2), (277, 4), (338, kind)], &[1, 2, 3, 4, 5, 6, 7, 8]);
    let chosen = |kind: u32, channels: &str| {
        let options = ReadOptions { channels: Some(channels.to_owned()), ..ReadOptions::default() };
        let header = probe_bytes(&extra(kind), "x.tif", &options).map_err(|e| e.message())?;
        let picture = decode(&extra(kind), "x.tif", &options).map_err(|e| e.message())?;
        assert_eq!((header.channels, header.alpha), (picture.plane.samples.channels(), picture.plane.alpha));
        assert_eq!((header.association, &header.warnings), (picture.plane.association, &picture.warnings));
        assert_eq!(picture.warnings, []);
        Ok::<_, String>((little_endian(&picture.plane.samples), picture.plane.alpha, picture.plane.is_premultiplied()))
    };
    assert_eq!(chosen(0, "4"), Ok((vec![4, 8], false, false)));
    assert_eq!(chosen(0, "1, 2,3,4"), Ok((vec![1, 2, 3, 4, 5, 6, 7, 8], false, false)));
    assert_eq!(chosen(1, "3,4"), Ok((vec![3, 4, 7, 8], true, true)));
    assert_eq!(chosen(2, "4,1"), Ok((vec![4, 1, 8, 5], false, false)));
    for wrong in ["0", "5", "R", "", "1,,2", "99999999999999999999"] {
        assert!(chosen(0, wrong).is_err_and(|what| what.ends_with("it holds 1, 2, 3, 4")), "{wrong}");
    }
    // Every file that is read has each of its channels by number.
    for (name, file, _) in files() {
        let whole = load(file).unwrap().plane;
        for c in 0..3 {
            let options = ReadOptions { channels: Some((c + 1).to_string()), ..ReadOptions::default() };
            let one = decode(file, "x.tif", &options).unwrap_or_else(|e| panic!("{name}: {e}")).plane;
            let same = (0..whole.domain().len()).all(|i| one.samples.value(0, i) == whole.samples.value(c, i));
            assert!(same && one.samples.channels() == 1, "{name}, channel {c}");
        }
    }
}
