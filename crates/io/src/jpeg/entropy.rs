//! Bits between markers, and Huffman codes in them [F.2.2].

use super::damaged;
use crate::Format;
use crate::error::Problem;

/// The bits of one scan. They end at a marker or with the file.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The next bits, the first one highest; below `count` of them follow bits that are right or 0.
    buffer: u64,
    count: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, buffer: 0, count: 0 }
    }

    /// Where the next marker is to be looked for.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    fn fill(&mut self) {
        // Eight bytes at once where none of them is stuffed or a marker.
        if let Some(word) = self.bytes.get(self.at..).and_then(<[u8]>::first_chunk::<8>)
            && !word.contains(&0xff)
        {
            self.buffer |= u64::from_be_bytes(*word) >> self.count;
            let taken = (63 - self.count) / 8;
            self.at += taken as usize;
            self.count += taken * 8;
            return;
        }
        while self.count <= 48 {
            let (byte, len) = match self.bytes.get(self.at..).unwrap_or_default() {
                [0xff, 0, ..] => (0xff, 2),
                [0xff, ..] | [] => return,
                [byte, ..] => (*byte, 1),
            };
            self.at += len;
            self.buffer |= u64::from(byte) << (56 - self.count);
            self.count += 8;
        }
    }

    fn take(&mut self, n: u32) -> Result<(), Problem> {
        if self.count < n {
            return Err(if self.at < self.bytes.len() && self.at + 1 != self.bytes.len() {
                damaged("a scan ends early")
            } else {
                Problem::ends_early(Format::Jpeg)
            });
        }
        self.buffer <<= n;
        self.count -= n;
        Ok(())
    }

    /// The next `n` bits, at most 16.
    #[inline]
    pub(super) fn bits(&mut self, n: u32) -> Result<i32, Problem> {
        if n == 0 {
            return Ok(0);
        }
        if self.count < n {
            self.fill();
        }
        let value = (self.buffer >> (64 - n)) as i32;
        self.take(n)?;
        Ok(value)
    }

    /// A signed number of `n` bits [F.2.2.1, EXTEND].
    #[inline]
    pub(super) fn signed(&mut self, n: u32) -> Result<i32, Problem> {
        let value = self.bits(n)?;
        Ok(if n != 0 && value < 1 << (n - 1) { value - (1 << n) + 1 } else { value })
    }

    /// The symbol of the next code.
    #[inline]
    pub(super) fn symbol(&mut self, code: &Huffman) -> Result<u8, Problem> {
        if self.count < 16 {
            self.fill();
        }
        let [len, symbol] = code.short[(self.buffer >> (64 - SHORT)) as usize];
        if len != 0 {
            self.take(len.into())?;
            return Ok(symbol);
        }
        let next = (self.buffer >> 48) as u32;
        // A code of `len` bits lies below the limit of its length, which is that of all shorter ones.
        for len in SHORT + 1..=16 {
            if next < code.limits[len as usize] {
                let place = (next >> (16 - len)) as i32 + code.places[len as usize];
                self.take(len)?;
                return code.symbols.get(place as usize).copied().ok_or_else(|| damaged("an unknown code"));
            }
        }
        self.take(16)?;
        Err(damaged("an unknown code"))
    }

    /// Passes over the restart marker of this number.
    pub(super) fn restart(&mut self, number: u8) -> Result<(), Problem> {
        (self.buffer, self.count) = (0, 0);
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let fill = rest.iter().take_while(|b| **b == 0xff).count();
        match rest.get(fill) {
            Some(marker) if 0 < fill && *marker == 0xd0 + number % 8 => {
                self.at += fill + 1;
                Ok(())
            }
            Some(_) => Err(damaged("a restart marker is missing")),
            None => Err(Problem::ends_early(Format::Jpeg)),
        }
    }
}

/// Codes of up to this many bits are looked up.
const SHORT: u32 = 9;

/// A Huffman code [C].
pub(super) struct Huffman {
    /// Length, 0 if longer than `SHORT`, and symbol of the code that these bits begin with.
    short: Vec<[u8; 2]>,
    /// One more than the greatest code of each length, as the first of 16 bits.
    limits: [u32; 17],
    /// What is added to a code to find its symbol.
    places: [i32; 17],
    symbols: Vec<u8>,
}

impl Huffman {
    /// `counts` tells how many codes there are of each length from 1 to 16; `None` if there are more than can be.
    pub(super) fn new(counts: &[u8; 16], symbols: &[u8]) -> Option<Self> {
        let mut code =
            Self { short: vec![[0; 2]; 1 << SHORT], limits: [0; 17], places: [0; 17], symbols: symbols.to_vec() };
        let (mut next, mut place) = (0_u32, 0_usize);
        for (len, &count) in (1_u32..).zip(counts) {
            code.places[len as usize] = place as i32 - next as i32;
            for _ in 0..count {
                if len <= SHORT {
                    let (first, same) = (next << (SHORT - len), 1 << (SHORT - len));
                    let entries = code.short.get_mut(first as usize..(first + same) as usize)?;
                    entries.fill([len as u8, *symbols.get(place)?]);
                }
                (next, place) = (next + 1, place + 1);
            }
            if 1 << len < next {
                return None;
            }
            code.limits[len as usize] = next << (16 - len);
            next <<= 1;
        }
        (place <= symbols.len()).then_some(code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_read_as_its_symbol() {
        // One code of each length but the last, which has two: 0, 10, 110, ...
        let mut counts = [1; 16];
        counts[15] = 2;
        let symbols: Vec<u8> = (0..17).collect();
        let code = Huffman::new(&counts, &symbols).unwrap();
        for symbol in 0..17_u32 {
            let len = (symbol + 1).min(16);
            let bits = u64::MAX.checked_shl(64 - symbol.min(16)).unwrap_or(0);
            let bytes = bits.to_be_bytes().map(|b| if b == 0xff { vec![0xff, 0] } else { vec![b] }).concat();
            assert_eq!(Bits::new(&bytes, 0).symbol(&code).ok(), Some(symbol as u8), "{len} bits");
        }
        counts[0] = 3;
        assert!(Huffman::new(&counts, &symbols).is_none(), "three codes of one bit");
    }

    #[test]
    fn bits_end_with_their_scan() {
        let mut bits = Bits::new(b"\xa5\xff\0\xff\xd1\x80", 0);
        assert_eq!([4, 4, 8].map(|n| bits.bits(n).ok()), [Some(10), Some(5), Some(255)]);
        assert!(bits.bits(1).is_err(), "a marker");
        assert!(bits.restart(2).is_err());
        bits.restart(9).unwrap();
        assert_eq!(bits.signed(2).ok(), Some(2));
        assert_eq!(bits.signed(2).ok(), Some(-3));
    }
}
