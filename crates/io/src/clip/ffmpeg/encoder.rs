//! Clips that another program encodes.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Stdio};
use std::time::Duration;

use selvedge_core::{Association, Domain, Grid, Plane, Samples};

use super::process::Process;
use super::{ffmpeg, named, not_started};
use crate::atomic::{Part, part_beside};
use crate::clip::container::Container;
use crate::clip::info::FrameEncoder;
use crate::clip::problem::ClipProblem;
use crate::clip::rate::Rate;
use crate::error::Problem;
use crate::samples::zeros;
use crate::{Depth, associate};

/// Slow codecs think about many frames at once before they take another.
const PATIENCE: Duration = Duration::from_secs(600);

/// A clip that grows by frames. The program writes a part beside the file, which is read and gone at the end.
pub(in super::super) struct Encoder {
    path: PathBuf,
    muxer: &'static str,
    usual: &'static [&'static str],
    options: Option<Vec<String>>,
    rate: Rate,
    running: Option<Running>,
}

struct Running {
    process: Process,
    pipe: ChildStdin,
    part: Part,
}

impl Encoder {
    /// Nothing runs before the first frame.
    pub(in super::super) fn new(
        (path, container): (&Path, Container),
        options: Option<Vec<String>>,
        rate: Rate,
    ) -> Self {
        let usual: &[&str] = match container {
            Container::Webm => &["-c:v", "libvpx-vp9", "-crf", "20", "-b:v", "0"],
            Container::Avi => &["-c:v", "mpeg4", "-q:v", "2"],
            Container::Mkv => &["-c:v", "libx264", "-crf", "16"],
            _ => &["-c:v", "libx264", "-crf", "16", "-movflags", "+faststart"],
        };
        let (path, muxer) = (path.to_path_buf(), container.muxer().unwrap_or_default());
        Self { path, muxer, usual, options, rate, running: None }
    }

    /// Encodes one black frame, so that codecs, options and sizes that do not go together are refused before any work.
    pub(in super::super) fn tried(
        mut self,
        (colors, alpha): (usize, bool),
        depth: Depth,
        shape: [u32; 2],
    ) -> Result<(), Problem> {
        let (domain, channels) = (Domain::open(shape), colors + usize::from(alpha));
        let n = domain.len() * channels;
        let samples = match depth {
            Depth::U8 => Samples::U8(Grid::from_vec(domain, channels, zeros(n)?)?),
            Depth::U16 => Samples::U16(Grid::from_vec(domain, channels, zeros(n)?)?),
            _ => return Err(unsupported(format!("{} samples", depth.name()))),
        };
        let (role, association) = (selvedge_core::Role::Color, Association::Straight);
        self.frame(&Plane { role, samples, alpha, association })?;
        Box::new(self).finish().map(drop)
    }

    fn start(&self, plane: &Plane<2>) -> Result<Running, Problem> {
        let Domain { shape: [height, width], .. } = plane.domain();
        let part = part_beside(&self.path).map_err(|e| Problem::file_system(e, 0))?;
        let mut command = ffmpeg();
        command.args(["-f", "rawvideo", "-pixel_format", pixels(plane)?, "-video_size", &format!("{width}x{height}")]);
        command.args(["-framerate", &format!("{}/{}", self.rate.num(), self.rate.den()), "-i", "pipe:0"]);
        match &self.options {
            Some(options) => command.args(options),
            None => command.args(self.usual).args(usual_colours([height, width])),
        };
        // No date and no version: the same frames are the same bytes.
        command.args(["-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", self.muxer, "-y"]).arg(named(part.file()));
        command.stdin(Stdio::piped()).stdout(Stdio::null());
        let (process, pipe, _) = Process::start(&mut command, (PATIENCE, true)).map_err(|e| not_started(e, true))?;
        let pipe = pipe.ok_or_else(|| Problem::file_system(std::io::ErrorKind::BrokenPipe.into(), 0))?;
        Ok(Running { process, pipe, part })
    }
}

/// What all players show: chroma at half the size where sides are even, and the colours of large screens, which the
/// file says as well.
fn usual_colours(shape: [u32; 2]) -> Vec<&'static str> {
    let even = shape.iter().all(|side| side.is_multiple_of(2));
    let filter = "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+bitexact";
    let colours = ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"];
    let sampled = ["-vf", filter, "-pix_fmt", if even { "yuv420p" } else { "yuv444p" }];
    sampled.into_iter().chain(colours).collect()
}

/// How the program calls such samples.
fn pixels(plane: &Plane<2>) -> Result<&'static str, Problem> {
    let (depth, channels) = (plane.samples.depth(), plane.samples.channels());
    Ok(match (depth, channels, plane.alpha) {
        (Depth::U8, 1, false) => "gray",
        (Depth::U16, 1, false) => "gray16le",
        (Depth::U8, 2, true) => "ya8",
        (Depth::U16, 2, true) => "ya16le",
        (Depth::U8, 3, false) => "rgb24",
        (Depth::U16, 3, false) => "rgb48le",
        (Depth::U8, 4, true) => "rgba",
        (Depth::U16, 4, true) => "rgba64le",
        (Depth::U8 | Depth::U16, ..) => return Err(unsupported(format!("a clip of {channels} channels"))),
        _ => return Err(unsupported(format!("{} samples", depth.name()))),
    })
}

fn unsupported(what: String) -> Problem {
    ClipProblem::Unsupported { container: "what ffmpeg is handed", what }.into()
}

fn interleaved<T: Copy, const N: usize>(
    grid: &Grid<T, 2>,
    bytes_of: impl Fn(T) -> [u8; N],
) -> Result<Vec<u8>, Problem> {
    let (n, channels) = (grid.domain().len(), grid.channels());
    let mut bytes = zeros(n * channels * N)?;
    for c in 0..channels {
        let to = bytes.chunks_exact_mut(N).skip(c).step_by(channels);
        to.zip(grid.plane(c)).for_each(|(to, v)| to.copy_from_slice(&bytes_of(*v)));
    }
    Ok(bytes)
}

impl FrameEncoder for Encoder {
    fn frame(&mut self, plane: &Plane<2>) -> Result<(), Problem> {
        let plane = &associate(plane, Association::Straight)?.plane;
        if self.running.is_none() {
            self.running = Some(self.start(plane)?);
        }
        let bytes = match &plane.samples {
            Samples::U8(grid) => interleaved(grid, |v| [v])?,
            Samples::U16(grid) => interleaved(grid, u16::to_le_bytes)?,
            floats => return Err(unsupported(format!("{} samples", floats.depth().name()))),
        };
        let Some(Running { process, pipe, .. }) = &mut self.running else { return Ok(()) };
        let written = process.waiting(|| pipe.write_all(&bytes));
        written.map_err(|e| match self.running.take().map(|running| running.process.end()) {
            Some(Err(problem)) => problem,
            _ => Problem::file_system(e, 0),
        })
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<u8>, Problem> {
        let Some(Running { process, pipe, part }) = self.running.take() else { return Ok(Vec::new()) };
        drop(pipe);
        process.end()?;
        fs::read(part.file()).map_err(|e| Problem::file_system(e, 0))
    }
}
