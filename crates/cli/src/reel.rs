//! A clip of which only some frames are held, or none: it is read again whenever others are wanted.

use std::borrow::Cow;
use std::cell::RefCell;
use std::ops::Range;
use std::path::PathBuf;

use selvedge_core::{
    Bytes, Depth, Domain, Encoder, Grid, Origin, Plane, Render as _, Samples, Source, SourceMap, SourceTable,
    Transform, reserve,
};
use selvedge_graphcut_textures::Error;
use selvedge_graphcut_textures::video::{Footage, Loop};
use selvedge_io::Fingerprint;
use selvedge_io::clip::{ClipInfo, ClipOptions, ClipReader, read_clip};

use crate::clips::ClipInput;
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;

/// A clip on its reel.
pub(crate) struct Reel<'a> {
    session: &'a Session<'a>,
    pub(crate) path: PathBuf,
    pub(crate) info: ClipInfo,
    reader: RefCell<ClipReader>,
    /// A second one for frames a period away, so that neither has to go back for each of them; a stream has none.
    other: Option<RefCell<ClipReader>>,
    table: SourceTable<3>,
    encoder: Encoder,
    /// Why frames could not be had.
    failed: RefCell<Option<Failure>>,
}

impl<'a> Reel<'a> {
    /// Whether a clip can be had frame by frame: not of one picture, nor of floats, whose features follow from all of
    /// its samples.
    pub(crate) fn holds(clip: &ClipInput) -> bool {
        matches!(clip.info().depth, Depth::U8 | Depth::U16) && !clip.info().container.starts_with("flipbook")
    }

    pub(crate) fn new(session: &'a Session<'a>, clip: ClipInput, options: &ClipOptions) -> Result<Self, Failure> {
        let (path, domain) = (clip.path().to_path_buf(), clip.domain());
        let is_file = path.as_os_str() != crate::stdio::STREAM && !crate::inputs::is_pipe(&path);
        let other = is_file.then(|| ClipReader::open(&path, options).map(RefCell::new)).transpose()?;
        let (info, mut reader) = (clip.info().clone(), clip.into_reader());
        let first = reader.next()?.into_iter().collect::<Vec<Plane<2>>>();
        let about = |e: selvedge_core::Error| Failure::from(e).about(&path);
        let encoder = Encoder::fit(&[first.as_slice()]).map_err(about)?;
        let table = SourceTable::new(vec![(Origin { exemplar: 0, transform: Transform::IDENTITY }, domain)]);
        let table = table.map_err(about)?;
        let (reader, failed) = (RefCell::new(reader), RefCell::default());
        Ok(Self { session, path, info, reader, other, table, encoder, failed })
    }

    /// Reads all of it once.
    pub(crate) fn pass(&self) -> Result<(), Failure> {
        (0..self.info.frames).try_for_each(|t| self.frame(&self.reader, t).map(drop))
    }

    /// All of it.
    pub(crate) fn whole(&self) -> Result<Plane<3>, Failure> {
        self.session.check_signal()?;
        let mut reader = self.reader.borrow_mut();
        reader.rewind()?;
        Ok(read_clip(&mut reader, &self.session.limits)?)
    }

    /// By frame, the file that it comes from, once all was read.
    pub(crate) fn frame_fingerprints(&self) -> Vec<Fingerprint> {
        self.reader.borrow().frame_fingerprints()
    }

    /// Once all was read, says what is odd about it, and notes it in the report. Answers with what tells the clip.
    pub(crate) fn noted(&self, report: &mut Report) -> Result<Fingerprint, Failure> {
        let reader = self.reader.borrow();
        for warning in reader.warnings() {
            self.session.warn(&self.path, warning);
        }
        let fingerprint = reader.fingerprint();
        self.session.expect(&fingerprint)?;
        report.inputs.push(crate::clips::noted(&self.path, &self.info, Some(&fingerprint.blake3)));
        Ok(fingerprint)
    }

    /// Why an error of its frames came about, or what it is by itself.
    pub(crate) fn failure(&self, error: impl Into<Failure>) -> Failure {
        self.failed.take().unwrap_or_else(|| error.into().about(&self.path))
    }

    fn frame(&self, reader: &RefCell<ClipReader>, frame: u32) -> Result<Plane<2>, Failure> {
        self.session.check_signal()?;
        let mut reader = reader.borrow_mut();
        reader.seek(frame)?;
        let ended = || Failure::new(3, format!("ends before frame {frame}")).about(&self.path);
        reader.next()?.ok_or_else(ended)
    }

    /// Frame `t` of a loop.
    pub(crate) fn of_loop(&self, looped: &Loop, t: u32) -> Result<Plane<2>, Failure> {
        let (shown, map) = looped.frame(t)?;
        let reader = |&frame: &u32| match &self.other {
            Some(other) if frame != looped.jump.to + t => other,
            _ => &self.reader,
        };
        let planes = shown.iter().map(|frame| self.frame(reader(frame), *frame)).collect::<Result<Vec<_>, _>>()?;
        let [plane] = planes.as_slice() else { return Ok(map.render(&planes.iter().collect::<Vec<_>>())?) };
        Ok(plane.clone())
    }

    /// Frames of what was woven of it: those that they show pass by once.
    pub(crate) fn of_map(&self, map: &SourceMap<3>, frames: Range<u32>) -> Result<Vec<Plane<2>>, Failure> {
        let pixels = map.domain().strides()[0];
        let shown = &map.ids.plane(0)[frames.start as usize * pixels..frames.end as usize * pixels];
        let of = self.info.width as usize * self.info.height as usize;
        let source = |place: &u32| shown[*place as usize].get() as usize;
        let mut places = Vec::new();
        reserve(&mut places, shown.len())?;
        places.extend(0..shown.len() as u32);
        places.sort_unstable_by_key(source);
        let mut made: Vec<Plane<2>> = Vec::new();
        for part in places.chunk_by(|a, b| source(a) / of == source(b) / of) {
            let from = self.frame(&self.reader, (source(&part[0]) / of) as u32)?;
            if made.is_empty() {
                let [_, height, width] = map.domain().shape;
                let (channels, depth) = (from.samples.channels(), from.samples.depth());
                let samples = Samples::try_zeros(Domain::open([height, width]), channels, depth)?;
                made = vec![Plane { samples, ..from.clone() }; frames.len()];
            }
            for place in part {
                let (t, to) = (*place as usize / pixels, *place as usize % pixels);
                copy((&mut made[t].samples, to), (&from.samples, source(place) % of));
            }
        }
        Ok(made)
    }

    fn features(&self, frames: Range<u32>) -> Result<Source<3>, Failure> {
        let ClipInfo { height, width, alpha, .. } = self.info;
        let domain = Domain::open([frames.end - frames.start, height, width]);
        let mut features = Grid::try_filled(domain, self.encoder.weights().len(), 0_u8)?;
        let mut valid = alpha.then(|| Grid::try_filled(domain, 1, true)).transpose()?;
        let pixels = domain.strides()[0];
        for (at, frame) in (0..).step_by(pixels).zip(frames) {
            let plane = self.frame(&self.reader, frame)?;
            let encoded = self.encoder.encode(std::slice::from_ref(&plane))?;
            let channels = 0..encoded.channels();
            channels.for_each(|c| features.plane_mut(c)[at..][..pixels].copy_from_slice(encoded.plane(c)));
            if let (Some(all), Some(of)) = (&mut valid, plane.validity()?) {
                all.plane_mut(0)[at..][..pixels].copy_from_slice(of.plane(0));
            }
        }
        Ok(Source { features, valid: valid.map(Into::into), origin: self.table.sources()[0].0 })
    }

    /// An upper bound of what readers hold: frames while they are decoded, and the files of animations.
    pub(crate) fn bytes(clip: &ClipInput) -> Bytes {
        let [frames, ..] = clip.domain().shape;
        let frame = Bytes(clip.bytes().0 / u64::from(frames.max(1)));
        let whole = matches!(clip.info().container.as_str(), "gif" | "apng" | "webp");
        let file = std::fs::metadata(clip.path()).map_or(0, |file| file.len());
        clip.held() + frame * 12 + Bytes(2 * file) * u64::from(whole)
    }
}

impl Footage for Reel<'_> {
    fn table(&self) -> &SourceTable<3> {
        &self.table
    }

    fn weights(&self) -> &[u8] {
        self.encoder.weights()
    }

    fn stretch(&self, frames: Range<u32>) -> Result<Cow<'_, Source<3>>, Error> {
        let frame = frames.start;
        self.features(frames).map(Cow::Owned).map_err(|failure| {
            self.failed.replace(Some(failure));
            Error::Unread { frame }
        })
    }
}

/// Copies a pixel.
fn copy((to, at): (&mut Samples<2>, usize), (from, of): (&Samples<2>, usize)) {
    fn channels<T: Copy>((to, at): (&mut Grid<T, 2>, usize), (from, of): (&Grid<T, 2>, usize)) {
        (0..from.channels()).for_each(|c| to.plane_mut(c)[at] = from.plane(c)[of]);
    }
    match (to, from) {
        (Samples::U8(to), Samples::U8(from)) => channels((to, at), (from, of)),
        (Samples::U16(to), Samples::U16(from)) | (Samples::F16(to), Samples::F16(from)) => {
            channels((to, at), (from, of));
        }
        (Samples::F32(to), Samples::F32(from)) => channels((to, at), (from, of)),
        _ => unreachable!("frames of a clip are of one depth"),
    }
}
