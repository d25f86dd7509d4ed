//! Portable arbitrary maps: raw frames, each with a header of its own. `[netpbm, pam(5)]`

use std::io::{BufRead, Read as _};

use selvedge_core::Samples;

use crate::Depth;
use crate::clip::problem::ClipProblem;
use crate::error::Problem;
use crate::header::Header;
use crate::samples::deinterleave;

/// No header is longer.
const LONGEST: u64 = 1024;

/// What is wrong with frames that were handed over.
pub(super) fn damaged(cause: &str) -> Problem {
    ClipProblem::Damaged { container: "pam", cause: cause.to_owned() }.into()
}

/// The header of the next frame; `None` at the end.
pub(super) fn header(input: &mut impl BufRead) -> Result<Option<Header>, Problem> {
    if input.fill_buf().map_err(|e| Problem::file_system(e, 0))?.is_empty() {
        return Ok(None);
    }
    let mut lines = input.take(LONGEST);
    let (mut sides, mut channels, mut most, mut kind) = ([0_u64; 2], 0, 0, String::new());
    for number in 0.. {
        let mut line = String::new();
        lines.read_line(&mut line).map_err(|_| damaged("its header is no text"))?;
        let Some(line) = line.strip_suffix('\n') else { return Err(damaged("it ends early")) };
        let (tag, value) = line.split_once(' ').unwrap_or((line, ""));
        let parsed = || value.parse::<u32>().map_err(|_| damaged("its header has no numbers"));
        match tag {
            "P7" if number == 0 => {}
            _ if number == 0 => return Err(damaged("a frame does not begin as such")),
            "WIDTH" => sides[0] = parsed()?.into(),
            "HEIGHT" => sides[1] = parsed()?.into(),
            "DEPTH" => channels = parsed()? as usize,
            "MAXVAL" => most = parsed()?,
            "TUPLTYPE" => kind = value.to_owned(),
            "ENDHDR" => break,
            _ => {}
        }
    }
    let depth = match (most, channels) {
        (0xff, 1..=4) => Depth::U8,
        (0xffff, 1..=4) => Depth::U16,
        _ => {
            let what = format!("frames of {channels} channels up to {most}");
            return Err(ClipProblem::Unsupported { container: "ffmpeg's pipe", what }.into());
        }
    };
    Ok(Some(Header { width: sides[0], height: sides[1], channels, alpha: kind.ends_with("_ALPHA"), depth }))
}

/// The samples of a frame; those of 16 bits have the upper byte first.
pub(super) fn samples(header: &Header, bytes: &[u8]) -> Result<Samples<2>, Problem> {
    Ok(match header.depth {
        Depth::U8 => Samples::U8(deinterleave(header, bytes, |b: [u8; 1]| b[0])?),
        _ => Samples::U16(deinterleave(header, bytes, u16::from_be_bytes)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_and_every_shorter_one_is_refused() {
        let whole = b"P7\nWIDTH 3\nHEIGHT 2\nDEPTH 4\nMAXVAL 65535\nTUPLTYPE RGB_ALPHA\nENDHDR\n";
        let read = |bytes: &[u8]| header(&mut &bytes[..]);
        let found = read(whole).unwrap().unwrap();
        assert_eq!(found, Header { width: 3, height: 2, channels: 4, alpha: true, depth: Depth::U16 });
        assert_eq!(read(b"").unwrap(), None);
        for end in 1..whole.len() {
            assert!(read(&whole[..end]).is_err(), "{end}");
        }
        for wrong in ["P6\n", "P7\nWIDTH -1\n", "P7\nDEPTH 5\nMAXVAL 255\nENDHDR\n", "P7\nDEPTH 1\nMAXVAL 1\nENDHDR\n"]
        {
            assert!(read(wrong.as_bytes()).is_err(), "{wrong}");
        }
    }
}
