//! Cut and mutated files of every format: an error or a picture, never a panic.

use std::panic;
use std::sync::Once;

use crate::common::{made, plane, profile};
use selvedge_core::{Depth, Domain, Limits, Plane, Rng, Seed};
use selvedge_io::{Format, Metadata, ReadOptions, WriteOptions, decode, encode, probe_bytes};

/// Small files of each format that can be written, and of those that cannot, with all the metadata they carry.
fn files() -> Vec<(Format, Vec<u8>)> {
    let metadata = Metadata { icc: Some(profile(b"RGB ")), ..made() };
    let mut files = Vec::new();
    for format in Format::ALL {
        for &depth in format.depths() {
            let alpha = matches!(format, Format::Png | Format::Exr);
            let samples = plane(depth, 3, alpha, [9, 11]);
            let samples = Plane { association: format.association().unwrap_or_default(), ..samples };
            let bytes = encode(&samples, &metadata, format!("a.{format}"), &WriteOptions::default());
            files.push((format, bytes.unwrap()));
        }
    }
    files.push((Format::Gif, GIF.to_vec()));
    files.push((Format::Bmp, BMP.to_vec()));
    files
}

/// 2x2, a palette of four.
const GIF: &[u8] = b"GIF89a\x02\0\x02\0\x91\0\0\0\0\0\xff\0\0\0\xff\0\0\0\xff!\xf9\x04\0\0\0\0\0\
,\0\0\0\0\x02\0\x02\0\0\x02\x03\x44\x34\x05\0;";

/// 1x1, 24 bits.
const BMP: &[u8] = b"BM\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\x18\0\0\0\0\0\x04\0\0\0\
\x13\x0b\0\0\x13\x0b\0\0\0\0\0\0\0\0\0\0\x01\x02\x03\0";

fn options() -> ReadOptions {
    let limits = Limits { memory: 64 << 20, side: 4096, samples: 1 << 20 };
    ReadOptions { limits, ..ReadOptions::default() }
}

/// Reads and probes; errors are one line and point at the file.
fn look(bytes: &[u8]) -> Option<Domain<2>> {
    let picture = decode(bytes, "x", &options());
    let info = probe_bytes(bytes, "x", &options());
    if let Err(e) = &picture {
        let line = e.to_string();
        assert!(line.starts_with("'x': ") && !line.contains(char::is_control), "{line}");
    }
    let domain = picture.ok()?.plane.domain();
    assert_eq!([info.as_ref().unwrap().height, info.unwrap().width], domain.shape);
    Some(domain)
}

/// Panics of decoders are caught; their words would only fill the screen.
fn quietly() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let print = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if info.location().is_some_and(|l| l.file().starts_with("crates/io")) {
                print(info);
            }
        }));
    });
}

#[test]
fn whole_files_load_prefixes_do_not() {
    quietly();
    let mut prefixes = 0;
    for (format, bytes) in files() {
        assert!(look(&bytes).is_some(), "{format}");
        for end in 0..bytes.len() {
            prefixes += 1;
            let read = look(&bytes[..end]);
            // Formats with a trailer that nobody needs may do without its last bytes.
            let spare = match format {
                Format::Gif => 1,
                Format::Bmp => 1,
                // The end marker.
                Format::Jpeg => 2,
                Format::Webp => 1,
                // How it was made, a directory of one tag, and the footer.
                Format::Tga => made().provenance.unwrap().to_string().len() + 12 + 26,
                _ => 0,
            };
            assert!(read.is_none() || bytes.len() - spare <= end, "{format} cut at {end} of {}", bytes.len());
        }
    }
    assert!(10_000 < prefixes, "{prefixes}");
}

#[test]
fn mutations_never_panic() {
    quietly();
    let mut rng = Seed(2).rng();
    let mut read = 0;
    for (format, bytes) in files() {
        for _ in 0..1_500 {
            let mut mutant = bytes.clone();
            for _ in 0..=rng.below(4) {
                mutate(&mut mutant, &mut rng);
            }
            if format == Format::Png && rng.below(2) == 0 {
                repair(&mut mutant);
            }
            read += usize::from(look(&mutant).is_some());
        }
    }
    assert!(1_000 < read, "only {read} mutants could be read: the mutations are too coarse to reach far");
}

fn mutate(bytes: &mut Vec<u8>, rng: &mut Rng) {
    if bytes.is_empty() {
        return;
    }
    let at = rng.below(bytes.len() as u32) as usize;
    match rng.below(6) {
        0 => bytes[at] = rng.below(256) as u8,
        1 => bytes[at] ^= 1 << rng.below(8),
        2 => bytes[at] = [0, 1, 127, 128, 255][rng.below(5) as usize],
        3 => {
            bytes.remove(at);
        }
        4 => bytes.insert(at, rng.below(256) as u8),
        _ => {
            let end = (at + 4).min(bytes.len());
            bytes[at..end].fill([0, 255][rng.below(2) as usize]);
        }
    }
}

/// Checksums would stop nearly every mutant before it reaches the decoder.
fn repair(png: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = png.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        let len = u32::from_be_bytes(*head) as usize;
        let Some(chunk) = png.get(at + 4..).and_then(|rest| rest.get(..len + 4)) else { return };
        let crc = crc32(chunk).to_be_bytes();
        let Some(place) = png.get_mut(at + 8 + len..at + 12 + len) else { return };
        place.copy_from_slice(&crc);
        at += 12 + len;
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = crc >> 1 ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    !crc
}

#[test]
fn the_repair_is_a_repair() {
    let (_, png) = &files()[0];
    let mut broken = png.clone();
    let last = broken.len() - 1;
    broken[last] ^= 1;
    assert!(decode(&broken, "x", &options()).is_err());
    repair(&mut broken);
    assert_eq!(&broken, png);
    assert_eq!(files()[1].0, Format::Png);
    let depth = decode(&files()[1].1, "x", &options()).unwrap().plane.samples.depth();
    assert_eq!(depth, Depth::U16);
}
