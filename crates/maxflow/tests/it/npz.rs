//! Arrays of 32-bit integers in NumPy's `.npz`: a ZIP archive of `.npy` files.

use std::path::Path;

/// The named arrays of an archive.
pub(crate) struct Arrays(Vec<u8>);

impl Arrays {
    pub(crate) fn read(path: &Path) -> Self {
        Self(std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
    }

    fn number(&self, at: usize, bytes: usize) -> usize {
        self.0[at..at + bytes].iter().rev().fold(0, |n, &byte| n << 8 | usize::from(byte))
    }

    /// The values of one array. Walks the archive's directory.
    pub(crate) fn get(&self, name: &str) -> Vec<i64> {
        let end = self.0.windows(4).rposition(|w| w == b"PK\x05\x06").expect("the end of the directory");
        let mut entry = self.number(end + 16, 4);
        for _ in 0..self.number(end + 10, 2) {
            let [name_len, extra, comment] = [28, 30, 32].map(|at| self.number(entry + at, 2));
            if self.0[entry + 46..][..name_len] == *format!("{name}.npy").as_bytes() {
                return values(&self.inflate(self.number(entry + 42, 4), self.number(entry + 20, 4)));
            }
            entry += 46 + name_len + extra + comment;
        }
        panic!("no array {name:?}")
    }

    /// The file whose local header stands at `header`, `packed` bytes long.
    fn inflate(&self, header: usize, packed: usize) -> Vec<u8> {
        let data = header + 30 + self.number(header + 26, 2) + self.number(header + 28, 2);
        let packed = &self.0[data..][..packed];
        match self.number(header + 8, 2) {
            0 => packed.to_vec(),
            _ => miniz_oxide::inflate::decompress_to_vec(packed).expect("a deflated file"),
        }
    }
}

/// The values of a `.npy` file of little-endian 32-bit integers.
fn values(file: &[u8]) -> Vec<i64> {
    let header = usize::from(u16::from_le_bytes([file[8], file[9]]));
    let kind = String::from_utf8_lossy(&file[10..10 + header]);
    assert!(file.starts_with(b"\x93NUMPY\x01") && kind.contains("<i4"), "{kind}");
    let (numbers, rest) = file[10 + header..].as_chunks();
    assert!(rest.is_empty());
    numbers.iter().map(|&bytes| i32::from_le_bytes(bytes).into()).collect()
}
