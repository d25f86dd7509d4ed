//! The frame and its tables, as markers tell them [B.2].

use super::components::Component;
use super::entropy::Huffman;
use super::{damaged, unsupported};
use crate::error::Problem;

/// The order in which coefficients are stored: row by row places of the zigzag [A.3.6].
pub(super) const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6, 7, 14, 21,
    28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54,
    47, 55, 62, 63,
];

/// What a frame header says.
pub(super) struct Frame {
    pub(super) progressive: bool,
    pub(super) width: u32,
    pub(super) height: u32,
    /// The largest sampling factors, vertical and horizontal.
    pub(super) most: [u32; 2],
    pub(super) components: Vec<Component>,
}

impl Frame {
    /// Whether a marker begins a frame; c4, c8 and cc among those of frames mean something else.
    pub(super) fn begins_with(marker: u8) -> bool {
        matches!(marker, 0xc0..=0xcf | 0xf7) && !matches!(marker, 0xc4 | 0xc8 | 0xcc)
    }

    /// Reads a frame header [B.2.2]. What is sound but not decoded is refused by its name.
    pub(super) fn parse(marker: u8, segment: &[u8]) -> Result<Self, Problem> {
        match marker {
            0xc0..=0xc2 => {}
            0xc3 | 0xf7 => return Err(unsupported("lossless coding")),
            0xc9 | 0xca => return Err(unsupported("arithmetic coding")),
            0xcb => return Err(unsupported("lossless arithmetic coding")),
            _ => return Err(unsupported("hierarchical coding")),
        }
        let [precision, h1, h0, w1, w0, count, rest @ ..] = segment else {
            return Err(damaged("a short frame header"));
        };
        if *precision != 8 {
            return Err(match precision {
                12 => unsupported("samples of 12 bits"),
                _ => damaged("samples of an impossible depth"),
            });
        }
        let [height, width] = [[*h1, *h0], [*w1, *w0]].map(|b| u32::from(u16::from_be_bytes(b)));
        if height == 0 {
            return Err(unsupported("a height that is told after the samples"));
        }
        let (count, (listed, [])) = (usize::from(*count), rest.as_chunks::<3>()) else {
            return Err(damaged("a frame header of the wrong length"));
        };
        if listed.len() != count {
            return Err(damaged("a frame header of the wrong length"));
        }
        if !matches!(count, 1 | 3 | 4) {
            return Err(unsupported(&format!("a picture of {count} components")));
        }
        if (1..count).any(|i| listed[..i].iter().any(|c| c[0] == listed[i][0])) {
            return Err(unsupported("several components of one name"));
        }
        let factors = listed.iter().map(|c| [u32::from(c[1] & 15), u32::from(c[1] >> 4)]);
        if factors.clone().flatten().any(|f| !(1..=4).contains(&f)) || listed.iter().any(|c| 3 < c[2]) {
            return Err(damaged("sampling factors or tables out of range"));
        }
        let most = [0, 1].map(|axis| factors.clone().map(|f| f[axis]).max().unwrap_or(1));
        // Of a single component the factors mean nothing: it has no other to be sampled against [A.2.2].
        let factors = factors.map(|f| if count == 1 { [1; 2] } else { f });
        let most = if count == 1 { [1; 2] } else { most };
        let components =
            listed.iter().zip(factors).map(|(c, f)| Component::new(c[0], f, most, [height, width], c[2])).collect();
        Ok(Self { progressive: marker == 0xc2, width, height, most, components })
    }
}

/// Tables that later segments replace and scans use.
#[derive(Default)]
pub(super) struct Tables {
    pub(super) quantization: [Option<[u16; 64]>; 4],
    /// Of DC and AC.
    pub(super) huffman: [[Option<Huffman>; 4]; 2],
    /// Units between two restart markers; 0 if there are none.
    pub(super) restart_interval: u32,
}

impl Tables {
    /// Quantization tables, row by row [B.2.4.1].
    pub(super) fn quantization(&mut self, mut segment: &[u8]) -> Result<(), Problem> {
        while let [head, rest @ ..] = segment {
            let (wide, place) = (usize::from(head >> 4), usize::from(head & 15));
            let bytes = rest.get(..64 * (wide + 1)).filter(|_| wide < 2 && place < 4);
            let bytes = bytes.ok_or_else(|| damaged("a quantization table"))?;
            let mut table = [0; 64];
            for (i, at) in ZIGZAG.iter().enumerate() {
                let value = &bytes[i * (wide + 1)..][..wide + 1];
                table[usize::from(*at)] = value.iter().fold(0, |v, b| v << 8 | u16::from(*b));
            }
            self.quantization[place] = Some(table);
            segment = &rest[bytes.len()..];
        }
        Ok(())
    }

    /// Huffman tables [B.2.4.2].
    pub(super) fn huffman(&mut self, mut segment: &[u8]) -> Result<(), Problem> {
        let wrong = || damaged("a huffman table");
        while let [head, rest @ ..] = segment {
            let (class, place) = (usize::from(head >> 4), usize::from(head & 15));
            let (counts, rest) = rest.split_first_chunk::<16>().ok_or_else(wrong)?;
            let n = counts.iter().map(|c| usize::from(*c)).sum();
            let symbols = rest.get(..n).filter(|_| class < 2 && place < 4 && n <= 256).ok_or_else(wrong)?;
            self.huffman[class][place] = Some(Huffman::new(counts, symbols).ok_or_else(wrong)?);
            segment = &rest[n..];
        }
        Ok(())
    }

    /// The restart interval [B.2.4.4].
    pub(super) fn restart(&mut self, segment: &[u8]) -> Result<(), Problem> {
        let [high, low] = segment else { return Err(damaged("a restart interval")) };
        self.restart_interval = u16::from_be_bytes([*high, *low]).into();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_decoded_is_called_by_its_name() {
        let header = [8, 0, 9, 0, 7, 1, 1, 0x11, 0];
        let said = |marker, at: usize, value| {
            let mut header = header;
            header[at] = value;
            Frame::parse(marker, &header).err().map(|p| p.to_string()).unwrap_or_default()
        };
        for marker in [0xc0, 0xc1, 0xc2] {
            assert_eq!(said(marker, 0, 8), "");
            assert_eq!(said(marker, 0, 12), "samples of 12 bits are not supported in jpeg");
        }
        for (marker, name) in [(0xc3, "lossless"), (0xf7, "lossless"), (0xc9, "arithmetic"), (0xca, "arithmetic")] {
            assert_eq!(said(marker, 0, 8), format!("{name} coding is not supported in jpeg"));
        }
        for marker in [0xc5, 0xc6, 0xc7, 0xcd, 0xce, 0xcf] {
            assert_eq!(said(marker, 0, 8), "hierarchical coding is not supported in jpeg");
        }
        let twice = [8, 0, 9, 0, 7, 3, 1, 0x11, 0, 1, 0x11, 0, 2, 0x11, 0];
        let twice = Frame::parse(0xc0, &twice).err().map(|p| p.to_string());
        assert_eq!(twice.as_deref(), Some("several components of one name are not supported in jpeg"));
        assert!(said(0xc0, 7, 0x51).contains("factors"));
        assert!(said(0xc0, 2, 0).contains("told after"));
        assert!(said(0xc0, 5, 2).contains("wrong length"));
    }
}
