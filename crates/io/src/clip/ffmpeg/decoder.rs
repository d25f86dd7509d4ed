//! Clips that another program decodes.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, Stdio};
use std::time::Duration;

use selvedge_core::{Association, Plane};

use super::process::Process;
use super::{ffmpeg, named, not_started, pam};
use crate::clip::container::Container;
use crate::clip::info::{ClipInfo, Frames, Layout};
use crate::clip::problem::check_samples;
use crate::clip::rate::Rate;
use crate::clip::y4m;
use crate::codec::Context;
use crate::error::{Error, Problem};
use crate::header::Header;
use crate::read::open;
use crate::samples::zeros;
use crate::{Metadata, ReadOptions, Warning};

/// No frame of a sound file takes as long, even where its index stands at its end.
const PATIENCE: Duration = Duration::from_secs(60);

/// A clip, decoded from its begin as often as it is read.
pub(in super::super) struct Decoder {
    path: PathBuf,
    options: ReadOptions,
    /// That of each frame.
    header: Header,
    /// Frames that were handed over.
    read: u32,
    last: Option<u32>,
    running: Option<Running>,
    blake3: String,
    warnings: Vec<Warning>,
}

/// The program and its pipe.
struct Running {
    process: Process,
    pipe: BufReader<ChildStdout>,
}

impl Decoder {
    /// Decodes a file once to count its frames, up to the `last` that is wanted.
    pub(in super::super) fn open(
        path: &Path,
        container: Container,
        (options, last): (&ReadOptions, Option<u32>),
    ) -> Result<(ClipInfo, Self), Error> {
        Self::looked_at(path, container, options, last).map_err(|p| Error::new(path, p))
    }

    fn looked_at(
        path: &Path,
        container: Container,
        options: &ReadOptions,
        last: Option<u32>,
    ) -> Result<(ClipInfo, Self), Problem> {
        let blake3 = hash(open(path)?.0).map_err(|e| Problem::file_system(e, 0))?;
        let rate = rate(path)?;
        let mut running = Running::start(path, last)?;
        let Some(header) = running.header()? else {
            running.process.end()?;
            return Err(pam::damaged("it has no frames"));
        };
        Context::new(options, 0).check(&header)?;
        let mut frames = 0;
        let mut next = Some(header);
        while let Some(found) = next {
            same(path, frames + 1, &found, &header)?;
            frames += 1;
            check_samples((header.width, header.height), if last.is_none() { frames } else { 1 }, &options.limits)?;
            running.pass_over(header.bytes())?;
            next = running.header()?;
        }
        let mut warnings: Vec<_> = running.process.end()?.map(|line| Warning::Said { line }).into_iter().collect();
        if 3 <= header.channels {
            warnings.push(Warning::ChromaConverted);
        }
        let info = ClipInfo {
            width: header.width as u32,
            height: header.height as u32,
            frames,
            rate,
            channels: header.channels,
            alpha: header.alpha,
            association: Association::Straight,
            depth: header.depth,
            metadata: Metadata::default(),
            container: container.name().to_owned(),
        };
        let (path, options) = (path.to_path_buf(), options.clone());
        Ok((info, Self { path, options, header, read: 0, last, running: None, blake3, warnings }))
    }

    fn decoded(&mut self) -> Result<Option<Plane<2>>, Problem> {
        let running = match &mut self.running {
            Some(running) => running,
            none => none.insert(Running::start(&self.path, self.last)?),
        };
        let Some(found) = running.header()? else {
            let ended = self.running.take().map(|running| running.process.end());
            return ended.transpose().map(|_| None);
        };
        self.read += 1;
        same(&self.path, self.read, &found, &self.header)?;
        let mut bytes = zeros(self.header.bytes() as usize)?;
        running.bytes(&mut bytes)?;
        let mut plane = Plane::new(self.options.role, pam::samples(&self.header, &bytes)?);
        plane.alpha = self.header.alpha;
        Ok(Some(plane))
    }
}

impl Running {
    fn start(path: &Path, last: Option<u32>) -> Result<Self, Problem> {
        let mut command = reading(path);
        command.args(last.map(|last| format!("-frames:v={last}")).iter().flat_map(|text| text.split('=')));
        // Raw frames in whichever of these depths holds them, converted alike on all machines.
        command.args([
            "-sws_flags",
            "accurate_rnd+full_chroma_int+bitexact",
            "-f",
            "image2pipe",
            "-c:v",
            "pam",
            "pipe:1",
        ]);
        Self::of(&mut command)
    }

    fn of(command: &mut Command) -> Result<Self, Problem> {
        command.stdin(Stdio::null()).stdout(Stdio::piped());
        let (process, _, pipe) = Process::start(command, (PATIENCE, false)).map_err(|e| not_started(e, false))?;
        let pipe = pipe.ok_or_else(|| Problem::file_system(io::ErrorKind::BrokenPipe.into(), 0))?;
        Ok(Self { process, pipe: BufReader::with_capacity(1 << 16, pipe) })
    }

    fn header(&mut self) -> Result<Option<Header>, Problem> {
        let Self { process, pipe } = self;
        process.waiting(|| pipe.fill_buf().map(drop)).map_err(|e| Problem::file_system(e, 0))?;
        pam::header(pipe)
    }

    fn bytes(&mut self, bytes: &mut [u8]) -> Result<(), Problem> {
        let Self { process, pipe } = self;
        process.waiting(|| pipe.read_exact(bytes)).map_err(|_| pam::damaged("it ends early"))
    }

    fn pass_over(&mut self, bytes: u64) -> Result<(), Problem> {
        let Self { process, pipe } = self;
        let passed = process.waiting(|| io::copy(&mut pipe.take(bytes), &mut io::sink()));
        if passed.is_ok_and(|passed| passed == bytes) { Ok(()) } else { Err(pam::damaged("it ends early")) }
    }
}

/// What reads the pictures of a file, and of no other place that the file may name.
fn reading(path: &Path) -> Command {
    let mut command = ffmpeg();
    command.args(["-protocol_whitelist", "file,pipe", "-i"]).arg(named(path)).args(["-map", "0:v:0"]);
    command
}

/// How fast it plays: in the header of a clip of one frame.
fn rate(path: &Path) -> Result<Option<Rate>, Problem> {
    let mut command = reading(path);
    command.args(["-frames:v", "1", "-pix_fmt", "yuv420p", "-f", "yuv4mpegpipe", "pipe:1"]);
    let mut running = Running::of(&mut command)?;
    let mut bytes = Vec::new();
    let Running { process, pipe } = &mut running;
    process.waiting(|| pipe.take(4096).read_until(b'\n', &mut bytes)).map_err(|e| Problem::file_system(e, 0))?;
    process.waiting(|| io::copy(pipe, &mut io::sink())).map_err(|e| Problem::file_system(e, 0))?;
    running.process.end()?;
    let line = String::from_utf8(bytes).unwrap_or_default();
    y4m::rate_of(line.trim_end())
}

/// Refuses another frame than the first.
fn same(path: &Path, number: u32, found: &Header, first: &Header) -> Result<(), Problem> {
    let layout = |of: &Header| Layout {
        width: of.width as u32,
        height: of.height as u32,
        channels: of.channels,
        alpha: of.alpha,
        association: Association::Straight,
        depth: of.depth,
    };
    layout(first).check(path, number, &layout(found)).map_err(|e| e.problem)
}

fn hash(file: File) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(file)?;
    Ok(hasher.finalize().to_hex().to_string())
}

impl Frames for Decoder {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        let decoded = self.decoded();
        decoded.map_err(|p| Error::new(&self.path, p))
    }

    fn rewind(&mut self) -> Result<(), Error> {
        (self.running, self.read) = (None, 0);
        Ok(())
    }

    fn blake3(&self) -> String {
        self.blake3.clone()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}
