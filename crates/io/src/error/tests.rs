//! What errors say.

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
