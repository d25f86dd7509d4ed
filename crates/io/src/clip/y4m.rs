//! YUV4MPEG2: raw frames of luma and chroma, as programs for clips hand them to each other. 8 bits; mono, 4:2:0, 4:2:2
//! and 4:4:4, of limited or full range.

use std::io::{BufRead, BufReader, Cursor, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use selvedge_core::{Association, Domain, Grid, Plane, Samples, try_vec};

use super::info::{ClipInfo, FrameEncoder, Frames};
use super::problem::ClipProblem;
use super::rate::Rate;
use super::yuv::{Matrix, Range};
use crate::codec::{Context, Input};
use crate::error::{Error, Problem};
use crate::header::Header;
use crate::read::open;
use crate::sink::Sink;
use crate::{Depth, Metadata, ReadOptions, Warning};

const MAGIC: &str = "YUV4MPEG2";
/// No line of a header is longer.
const LONGEST: u64 = 4096;

/// How chroma is sampled: every so many samples along x and y. `None` for mono.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Chroma(Option<[usize; 2]>);

/// What the first line says.
#[derive(Clone, Copy, Debug)]
struct Headline {
    width: u32,
    height: u32,
    rate: Option<Rate>,
    chroma: Chroma,
    range: Range,
}

/// A clip, read frame by frame.
pub(super) struct Y4m {
    path: PathBuf,
    input: Box<dyn Input>,
    head: Headline,
    /// Where the first frame begins.
    start: u64,
    options: ReadOptions,
    blake3: String,
    warnings: Vec<Warning>,
}

/// Whether a file begins as one does.
pub(super) fn is_y4m(start: &[u8]) -> bool {
    start.starts_with(MAGIC.as_bytes())
}

fn damaged(cause: &str) -> Problem {
    ClipProblem::Damaged { container: "y4m", cause: cause.to_owned() }.into()
}

fn unsupported(what: String) -> Problem {
    ClipProblem::Unsupported { container: "y4m", what }.into()
}

impl Headline {
    fn parse(line: &str) -> Result<Self, Problem> {
        let mut words = line.split(' ');
        if words.next() != Some(MAGIC) {
            return Err(damaged("it does not begin as such"));
        }
        let (mut sides, mut rate, mut chroma, mut range) = ([0_u32; 2], None, "420jpeg", None);
        for word in words.filter(|word| !word.is_empty()) {
            let (tag, value) = word.split_at(word.chars().next().map_or(0, char::len_utf8));
            let side = || value.parse().map_err(|_| damaged("its size is no number"));
            match tag {
                "W" => sides[0] = side()?,
                "H" => sides[1] = side()?,
                // 0:0 is what programs write that know no rate.
                "F" if value == "0:0" => {}
                "F" => rate = Some(value.parse()?),
                "C" => chroma = value,
                "I" if !matches!(value, "p" | "?") => return Err(unsupported("interlaced frames".into())),
                "X" if value == "COLORRANGE=FULL" => range = Some(Range::Full),
                "X" if value == "COLORRANGE=LIMITED" => range = Some(Range::Limited),
                _ => {}
            }
        }
        let range = range.unwrap_or(if chroma == "mono" { Range::Full } else { Range::Limited });
        let chroma = Chroma(match chroma {
            "mono" => None,
            "420" | "420jpeg" | "420mpeg2" | "420paldv" => Some([2, 2]),
            "422" => Some([2, 1]),
            "444" => Some([1, 1]),
            other => return Err(unsupported(format!("chroma '{other}'"))),
        });
        Ok(Self { width: sides[0], height: sides[1], rate, chroma, range })
    }

    fn channels(&self) -> usize {
        if self.chroma.0.is_some() { 3 } else { 1 }
    }

    fn header(&self) -> Header {
        let (width, height) = (self.width.into(), self.height.into());
        Header { width, height, channels: self.channels(), alpha: false, depth: Depth::U8 }
    }

    /// Width and height of a chroma plane.
    fn chroma_size(&self) -> [usize; 2] {
        let [x, y] = self.chroma.0.unwrap_or([1, 1]);
        [(self.width as usize).div_ceil(x), (self.height as usize).div_ceil(y)]
    }

    /// Bytes of a frame at most, as the headline has it.
    fn claimed(&self) -> u64 {
        u64::from(self.width).saturating_mul(self.height.into()).saturating_mul(self.channels() as u64)
    }

    /// Bytes of a frame.
    fn bytes(&self) -> usize {
        let luma = self.width as usize * self.height as usize;
        let [w, h] = self.chroma_size();
        luma + if self.chroma.0.is_some() { 2 * w * h } else { 0 }
    }
}

impl Y4m {
    /// Opens a file, or takes the bytes of a stream.
    pub(super) fn open(path: &Path, bytes: Option<Vec<u8>>, options: &ReadOptions) -> Result<(ClipInfo, Self), Error> {
        Self::looked_at(path, bytes, options).map_err(|p| Error::new(path, p))
    }

    fn looked_at(path: &Path, bytes: Option<Vec<u8>>, options: &ReadOptions) -> Result<(ClipInfo, Self), Problem> {
        let mut input: Box<dyn Input> = match bytes {
            Some(bytes) => Box::new(Cursor::new(bytes)),
            None => Box::new(BufReader::new(open(path)?.0)),
        };
        let system = |e| Problem::file_system(e, 0);
        let line = line(&mut *input)?;
        let head = Headline::parse(&line)?;
        // What it claims may be more than numbers hold, and is no size before it was checked.
        Context::new(options, head.claimed()).check(&head.header())?;
        let start = input.stream_position().map_err(system)?;
        // Frames are counted, and all bytes are hashed, before any is used.
        input.rewind().map_err(system)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(&mut input).map_err(system)?;
        input.seek(SeekFrom::Start(start)).map_err(system)?;
        let mut own = Self {
            path: path.to_path_buf(),
            input,
            head,
            start,
            options: options.clone(),
            blake3: hasher.finalize().to_hex().to_string(),
            warnings: Vec::new(),
        };
        let mut frames = 0;
        let mut buffer = try_vec(head.bytes(), 0_u8)?;
        while own.raw(&mut buffer)? {
            frames += 1;
        }
        if frames == 0 {
            return Err(damaged("it ends early"));
        }
        own.input.seek(SeekFrom::Start(start)).map_err(system)?;
        if head.chroma.0.is_some() {
            own.warnings.push(Warning::ChromaConverted);
        }
        let info = ClipInfo {
            width: head.width,
            height: head.height,
            frames,
            rate: head.rate,
            channels: head.channels(),
            alpha: false,
            association: Association::Straight,
            depth: Depth::U8,
            metadata: Metadata::default(),
            container: "y4m".to_owned(),
        };
        Ok((info, own))
    }

    /// The next frame's bytes; false at the end.
    fn raw(&mut self, buffer: &mut [u8]) -> Result<bool, Problem> {
        if self.input.fill_buf().map_err(|e| Problem::file_system(e, 0))?.is_empty() {
            return Ok(false);
        }
        let line = line(&mut *self.input)?;
        if line != "FRAME" && !line.starts_with("FRAME ") {
            return Err(damaged("a frame does not begin as such"));
        }
        match self.input.read_exact(buffer) {
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Err(damaged("it ends early")),
            read => read.map(|()| true).map_err(|e| Problem::file_system(e, 0)),
        }
    }

    fn decoded(&mut self) -> Result<Option<Plane<2>>, Problem> {
        let head = self.head;
        let mut buffer = try_vec(head.bytes(), 0_u8)?;
        if !self.raw(&mut buffer)? {
            return Ok(None);
        }
        let domain = head.header().domain();
        let mut grid = Grid::try_filled(domain, head.channels(), 0_u8)?;
        let (luma, chroma) = buffer.split_at(domain.len());
        match head.chroma.0 {
            None => grid.plane_mut(0).iter_mut().zip(luma).for_each(|(to, v)| *to = head.range.grey(*v)),
            Some([x, y]) => {
                let [w, h] = head.chroma_size();
                let (cb, cr) = chroma.split_at(w * h);
                let matrix = Matrix::of_height(head.height);
                for (i, v) in luma.iter().enumerate() {
                    let (row, column) = (i / head.width as usize, i % head.width as usize);
                    let at = row / y * w + column / x;
                    let rgb = matrix.rgb(head.range, [*v, cb[at], cr[at]]);
                    (0..3).for_each(|c| grid.plane_mut(c)[i] = rgb[c]);
                }
            }
        }
        Ok(Some(Plane::new(self.options.role, Samples::U8(grid))))
    }
}

impl Frames for Y4m {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        let decoded = self.decoded();
        decoded.map_err(|p| Error::new(&self.path, p))
    }

    fn rewind(&mut self) -> Result<(), Error> {
        let start = SeekFrom::Start(self.start);
        self.input.seek(start).map(drop).map_err(|e| Error::new(&self.path, Problem::file_system(e, 0)))
    }

    fn blake3(&self) -> String {
        self.blake3.clone()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}

/// A line without its end.
fn line(input: &mut dyn Input) -> Result<String, Problem> {
    let mut bytes = Vec::new();
    input.take(LONGEST).read_until(b'\n', &mut bytes).map_err(|e| Problem::file_system(e, 0))?;
    if bytes.pop() != Some(b'\n') {
        return Err(damaged("it ends early"));
    }
    String::from_utf8(bytes).map_err(|_| damaged("its header is no text"))
}

/// A clip that grows by frames: mono for grey, else 4:4:4 of limited range, in which no chroma is lost.
pub(super) struct Y4mWriter {
    file: Sink,
    rate: Rate,
    begun: bool,
}

impl Y4mWriter {
    pub(super) fn new(rate: Rate) -> Self {
        Self { file: Sink::default(), rate, begun: false }
    }
}

impl FrameEncoder for Y4mWriter {
    fn frame(&mut self, plane: &Plane<2>) -> Result<(), Problem> {
        let full = |e| Problem::file_system(e, 0);
        let Samples::U8(grid) = &plane.samples else {
            return Err(unsupported(format!("{} samples", plane.samples.depth().name())));
        };
        if plane.alpha || !matches!(grid.channels(), 1 | 3) {
            return Err(unsupported("alpha or a number of channels other than 1 and 3".into()));
        }
        let Domain { shape: [height, width], .. } = grid.domain();
        if !self.begun {
            let chroma = if grid.channels() == 1 { "mono XCOLORRANGE=FULL" } else { "444 XCOLORRANGE=LIMITED" };
            let (num, den) = (self.rate.num(), self.rate.den());
            writeln!(self.file, "{MAGIC} W{width} H{height} F{num}:{den} Ip A1:1 C{chroma}").map_err(full)?;
            self.begun = true;
        }
        self.file.write_all(b"FRAME\n").map_err(full)?;
        if grid.channels() == 1 {
            return self.file.write_all(grid.plane(0)).map_err(full);
        }
        let n = grid.domain().len();
        let (mut bytes, matrix) = (try_vec(3 * n, 0_u8)?, Matrix::of_height(height));
        for i in 0..n {
            let yuv = matrix.yuv(Range::Limited, [0, 1, 2].map(|c| grid.plane(c)[i]));
            (0..3).for_each(|c| bytes[c * n + i] = yuv[c]);
        }
        self.file.write_all(&bytes).map_err(full)
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, Problem> {
        Ok(self.file.into_bytes())
    }
}
