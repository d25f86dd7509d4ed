//! YUV4MPEG2: raw frames of luma and chroma, as programs for clips hand them to each other. Mono, 4:2:0, 4:2:2
//! and 4:4:4 of 8 to 16 bits, of limited or full range; what has more than 8 bits is read as 16.

use std::io::{BufRead, BufReader, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use selvedge_core::{Association, Domain, Grid, Plane, Samples, try_vec};

use super::info::{ClipInfo, FrameEncoder, Frames};
use super::problem::ClipProblem;
use super::rate::Rate;
use super::yuv::{Coding, Matrix, Range};
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
    coding: Coding,
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

/// How fast a clip with this first line plays.
pub(super) fn rate_of(line: &str) -> Result<Option<Rate>, Problem> {
    Headline::parse(line).map(|head| head.rate)
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
                "F" => rate = Some(value.parse().map_err(|_| damaged(&format!("'{value}' is no rate")))?),
                "C" => chroma = value,
                "I" if !matches!(value, "p" | "?") => return Err(unsupported("interlaced frames".into())),
                "X" if value == "COLORRANGE=FULL" => range = Some(Range::Full),
                "X" if value == "COLORRANGE=LIMITED" => range = Some(Range::Limited),
                _ => {}
            }
        }
        let (sampled, bits) = bits_of(chroma).ok_or_else(|| unsupported(format!("chroma '{chroma}'")))?;
        let range = range.unwrap_or(if sampled == "mono" { Range::Full } else { Range::Limited });
        let chroma = Chroma(match sampled {
            "mono" => None,
            "420" | "420jpeg" | "420mpeg2" | "420paldv" => Some([2, 2]),
            "422" => Some([2, 1]),
            "444" => Some([1, 1]),
            _ => return Err(unsupported(format!("chroma '{chroma}'"))),
        });
        Ok(Self { width: sides[0], height: sides[1], rate, chroma, coding: Coding { range, bits } })
    }

    fn depth(&self) -> Depth {
        if self.coding.bits == 8 { Depth::U8 } else { Depth::U16 }
    }

    fn channels(&self) -> usize {
        if self.chroma.0.is_some() { 3 } else { 1 }
    }

    fn header(&self) -> Header {
        let (width, height) = (self.width.into(), self.height.into());
        Header { width, height, channels: self.channels(), alpha: false, depth: self.depth() }
    }

    /// Width and height of a chroma plane.
    fn chroma_size(&self) -> [usize; 2] {
        let [x, y] = self.chroma.0.unwrap_or([1, 1]);
        [(self.width as usize).div_ceil(x), (self.height as usize).div_ceil(y)]
    }

    /// Bytes of a frame at most, as the headline has it.
    fn claimed(&self) -> u64 {
        self.header().bytes()
    }

    /// Bytes of a frame.
    fn bytes(&self) -> usize {
        let luma = self.width as usize * self.height as usize;
        let [w, h] = self.chroma_size();
        (luma + if self.chroma.0.is_some() { 2 * w * h } else { 0 }) * self.depth().bytes() as usize
    }
}

impl Y4m {
    /// Opens a file, or takes what a stream has brought.
    pub(super) fn open(
        path: &Path,
        stream: Option<Box<dyn Input>>,
        options: &ReadOptions,
    ) -> Result<(ClipInfo, Self), Error> {
        Self::looked_at(path, stream, options).map_err(|p| Error::new(path, p))
    }

    fn looked_at(
        path: &Path,
        stream: Option<Box<dyn Input>>,
        options: &ReadOptions,
    ) -> Result<(ClipInfo, Self), Problem> {
        let mut input = match stream {
            Some(stream) => stream,
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
        // No memory for a frame that the file is too short for.
        if hasher.count() - start < head.bytes() as u64 {
            return Err(damaged("it ends early"));
        }
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
            depth: head.depth(),
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
        let samples = match head.depth() {
            Depth::U8 => Samples::U8(colours(head, |i| buffer[i].into(), |v| v as u8)?),
            _ => {
                let value = |i: usize| u16::from_le_bytes([buffer[2 * i], buffer[2 * i + 1]]);
                Samples::U16(colours(head, value, |v| v)?)
            }
        };
        Ok(Some(Plane::new(self.options.role, samples)))
    }
}

/// How chroma is sampled, by its name, and bits of a value: `420p10`, `mono16`.
fn bits_of(chroma: &str) -> Option<(&str, u32)> {
    let deep = |(sampled, bits): (_, &str)| {
        let bits = bits.parse().ok().filter(|bits| (9..=16).contains(bits))?;
        Some((sampled, bits))
    };
    match chroma.strip_prefix("mono") {
        Some("") => Some((chroma, 8)),
        Some(bits) => deep(("mono", bits)),
        // As in 420paldv, a p may be a letter of a name.
        None => chroma.split_once('p').and_then(deep).or(Some((chroma, 8))),
    }
}

/// The colours, or greys, of the values of a frame: luma, then chroma.
fn colours<T: Copy + Default>(
    head: Headline,
    value: impl Fn(usize) -> u16,
    sample: impl Fn(u16) -> T,
) -> Result<Grid<T, 2>, Problem> {
    let domain = head.header().domain();
    let mut grid = Grid::try_filled(domain, head.channels(), T::default())?;
    let Some([x, y]) = head.chroma.0 else {
        let to = grid.plane_mut(0).iter_mut().enumerate();
        to.for_each(|(i, to)| *to = sample(head.coding.grey(value(i))));
        return Ok(grid);
    };
    let [w, h] = head.chroma_size();
    let (luma, matrix) = (domain.len(), Matrix::of_height(head.height));
    for i in 0..luma {
        let (row, column) = (i / head.width as usize, i % head.width as usize);
        let at = luma + row / y * w + column / x;
        let rgb = matrix.rgb(head.coding, [value(i), value(at), value(at + w * h)]);
        (0..3).for_each(|c| grid.plane_mut(c)[i] = sample(rgb[c]));
    }
    Ok(grid)
}

impl Frames for Y4m {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        let decoded = self.decoded();
        decoded.map_err(|p| Error::new(&self.path, p))
    }

    fn skip(&mut self) -> Result<bool, Error> {
        let passed =
            try_vec(self.head.bytes(), 0_u8).map_err(Problem::Core).and_then(|mut buffer| self.raw(&mut buffer));
        passed.map_err(|p| Error::new(&self.path, p))
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
        let (channels, depth) = (plane.samples.channels(), plane.samples.depth());
        if plane.alpha || !matches!(channels, 1 | 3) {
            return Err(unsupported("alpha or a number of channels other than 1 and 3".into()));
        }
        let Domain { shape: [height, width], .. } = plane.domain();
        if !self.begun {
            let chroma = match (channels, depth) {
                (1, Depth::U8) => "mono XCOLORRANGE=FULL",
                (1, _) => "mono16 XCOLORRANGE=FULL",
                (_, Depth::U8) => "444 XCOLORRANGE=LIMITED",
                _ => "444p16 XCOLORRANGE=LIMITED",
            };
            let (num, den) = (self.rate.num(), self.rate.den());
            writeln!(self.file, "{MAGIC} W{width} H{height} F{num}:{den} Ip A1:1 C{chroma}").map_err(full)?;
            self.begun = true;
        }
        self.file.write_all(b"FRAME\n").map_err(full)?;
        let values = match &plane.samples {
            Samples::U8(grid) => values(grid, 8, |v| [v as u8])?,
            Samples::U16(grid) => values(grid, 16, u16::to_le_bytes)?,
            floats => return Err(unsupported(format!("{} samples", floats.depth().name()))),
        };
        self.file.write_all(&values).map_err(full)
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, Problem> {
        Ok(self.file.into_bytes())
    }
}

/// The bytes of a frame: greys as they are, colours as luma and chroma of limited range.
fn values<T: Copy + Into<u16>, const N: usize>(
    grid: &Grid<T, 2>,
    bits: u32,
    bytes_of: impl Fn(u16) -> [u8; N],
) -> Result<Vec<u8>, Problem> {
    let n = grid.domain().len();
    let mut bytes = try_vec(grid.channels() * n * N, 0_u8)?;
    let mut put = |at: usize, v: u16| bytes[at * N..][..N].copy_from_slice(&bytes_of(v));
    if grid.channels() == 1 {
        grid.plane(0).iter().enumerate().for_each(|(i, &v)| put(i, v.into()));
        return Ok(bytes);
    }
    let (coding, matrix) = (Coding { range: Range::Limited, bits }, Matrix::of_height(grid.domain().shape[0]));
    for i in 0..n {
        let yuv = matrix.yuv(coding, [0, 1, 2].map(|c| grid.plane(c)[i].into()));
        (0..3).for_each(|c| put(c * n + i, yuv[c]));
    }
    Ok(bytes)
}
