//! What errors say.

use super::words::plain;
use super::*;

#[test]
fn file_numbers_and_remedy_in_one_line() {
    let error = Error::new(Path::new("dir/a\nb.png"), Problem::damaged(Format::Png, "row\n7"));
    assert_eq!(error.to_string(), r"'dir/a\nb.png': damaged png file (row\n7); write or copy the file again");
    assert_eq!((error.kind(), error.remedy().as_str()), (ErrorKind::Input, "write or copy the file again"));
    let error = Error::new(Path::new("a"), selvedge_core::Error::Allocation { bytes: 9 });
    assert_eq!(error.to_string(), "'a': no memory for 9 bytes; use a smaller size");
    assert_eq!(error.kind(), ErrorKind::Memory);
}

#[test]
fn decoders_speak_plainly() {
    let crc = "CRC error: expected 0x1 have 0x2 while decoding ChunkType { type: IDAT, critical: true, private: false, \
               reserved: false, safecopy: false } chunk.";
    assert_eq!(plain(crc), "CRC error: expected 0x1 have 0x2 while decoding IDAT chunk");
    assert_eq!(plain("\"Missing samples\""), "missing samples");
    assert_eq!(plain("Invalid color type 1."), "invalid color type 1");
    assert_eq!(plain("ChunkType { type: "), "ChunkType { type:");
    assert_eq!([plain(""), plain("É"), plain("A")], ["", "É", "A"]);
}

#[test]
fn the_systems_refusals_have_kinds() {
    let kind = |e: io::ErrorKind| Problem::file_system(e.into(), 1).kind();
    for full in [io::ErrorKind::StorageFull, io::ErrorKind::QuotaExceeded, io::ErrorKind::FileTooLarge] {
        assert_eq!(kind(full), ErrorKind::NoSpace);
    }
    assert_eq!(kind(io::ErrorKind::OutOfMemory), ErrorKind::Memory);
    for other in [io::ErrorKind::NotFound, io::ErrorKind::ReadOnlyFilesystem, io::ErrorKind::Other] {
        assert_eq!(kind(other), ErrorKind::FileSystem);
    }
}

#[test]
fn what_a_decoder_says_is_not_said_twice() {
    for (sentence, what) in [
        ("Photometric interpretation CIELab is unsupported", "Photometric interpretation CIELab"),
        ("12 bits per channel not supported", "12 bits per channel"),
        ("unsupported data type.", "data type"),
        ("tile rows", "tile rows"),
        ("The image format `32-bit_rle_xyze` is not supported", "`32-bit_rle_xyze`"),
        ("The decoder for Hdr does not support the format features Orientation +Y +X", "Orientation +Y +X"),
        ("yet unimplemented compression method: HTJ2K", "compression method: HTJ2K"),
    ] {
        assert_eq!(subject(sentence), what);
    }
}

#[test]
fn one_is_and_several_are() {
    for (what, verb) in [
        ("samples of 12 bits", "are"),
        ("8-bit Int samples", "are"),
        ("metadata over 16 MiB", "is"),
        ("a file of more than 4000 scans", "is"),
        ("choosing layers or channels", "is"),
        ("compression by huffman codes", "is"),
        ("arithmetic coding", "is"),
    ] {
        assert_eq!(super::verb(what), verb, "{what}");
    }
}
