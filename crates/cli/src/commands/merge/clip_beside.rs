//! Pictures that say what of clips shows: masks, strokes and what is kept, one for all frames or one a frame.

use std::path::{Path, PathBuf};

use selvedge_core::{Domain, Exemplars, Grid, Plane, Role};
use selvedge_graphcut_textures::labels::Label;
use selvedge_io::Fingerprint;

use super::Merge;
use super::strokes::keep;
use crate::clips::{self, Clip, is_pattern};
use crate::exemplars::NO_MASK;
use crate::failure::{Failure, n};
use crate::ground::check_size;
use crate::inputs::{self, Input, white};
use crate::options::NonFinite;
use crate::report::Report;
use crate::session::Session;

/// What is read beside clips, and noted.
pub(super) struct Beside<'a> {
    pub(super) session: &'a Session<'a>,
    pub(super) report: &'a mut Report,
    pub(super) nonfinite: NonFinite,
    pub(super) others: Vec<Fingerprint>,
}

/// Frames that a picture has to fit, whose they are, and what to do if it does not.
type Fits<'t> = (Domain<3>, &'t str, &'t str);

impl Beside<'_> {
    /// The picture that holds for all frames, or one a frame, with their files.
    fn held(&mut self, path: &Path, (domain, of, remedy): Fits<'_>) -> Result<Vec<(PathBuf, Plane<2>)>, Failure> {
        let [frames, shape @ ..] = domain.shape;
        let files = if is_pattern(path) { clips::files(path, None)? } else { vec![path.to_path_buf()] };
        if is_pattern(path) && files.len() != frames as usize {
            let what = format!("{}, but the clips have {frames}", n("frame", files.len()));
            return Err(Failure::new(3, what).about(path).remedy("give one picture for all frames, or one for each"));
        }
        let options = inputs::options(self.session.limits, Role::Scalar, self.nonfinite);
        let (mut all, mut read) = (Vec::new(), Vec::new());
        for file in files {
            let picture = Input::new(self.session, &file)?.read(self.session, &options, self.report)?;
            check_size(&file, picture.plane.domain().shape, Some(shape), of, remedy)?;
            read.push(inputs::fingerprint(&file, &picture));
            all.push((file, picture.plane));
        }
        if is_pattern(path) {
            // By the name that the command has, it is found again.
            let whole = clips::fingerprint(path, &read);
            self.session.expect(&whole)?;
            read.push(whole);
        }
        self.others.append(&mut read);
        Ok(all)
    }

    /// Where it is white, in every frame.
    pub(super) fn white(&mut self, path: &Path, fits: Fits<'_>) -> Result<Grid<bool, 3>, Failure> {
        let mut all = Vec::new();
        for (file, plane) in self.held(path, fits)? {
            all.extend_from_slice(white(&plane, &file)?.samples());
        }
        let mut whole = Grid::try_filled(fits.0, 1, false)?;
        whole.samples_mut().iter_mut().enumerate().for_each(|(i, to)| *to = all[i % all.len()]);
        Ok(whole)
    }
}

impl Merge {
    /// By clip, where it may show; `None` for everywhere.
    pub(super) fn masks_of_clips(
        &self,
        beside: &mut Beside<'_>,
        clips: &[Clip],
    ) -> Result<Vec<Option<Grid<bool, 3>>>, Failure> {
        let masks = self.weaving.input.mask.iter().map(Some).chain(std::iter::repeat(None));
        let read = |(clip, mask): (&Clip, Option<&PathBuf>)| {
            let mask = mask.filter(|mask| mask.as_os_str() != NO_MASK);
            let fits = (clip.plane.domain(), "the frames that it masks have", "give a mask of that size");
            mask.map(|mask| beside.white(mask, fits)).transpose()
        };
        clips.iter().zip(masks).map(read).collect()
    }

    /// Where nothing is fused; `None` for nowhere.
    pub(super) fn unfused(&self, beside: &mut Beside<'_>, output: Domain<3>) -> Result<Option<Grid<bool, 3>>, Failure> {
        let fits = (output, "the output has", "give a mask of that size");
        self.fuse_keep.of(self.blending)?.map(|path| beside.white(path, fits)).transpose()
    }

    /// By place, which clips may show; none if all may everywhere.
    pub(super) fn only_of_clips(
        &self,
        beside: &mut Beside<'_>,
        (exemplars, labels, output): (&Exemplars<3>, &[Label<3>], Domain<3>),
    ) -> Result<Option<Grid<u64, 3>>, Failure> {
        if self.strokes.is_none() && self.keep.is_empty() {
            return Ok(None);
        }
        let mut only = Grid::try_filled(output, 1, u64::MAX >> (64 - labels.len()))?;
        let painted = self.strokes.iter().map(|path| (path.as_path(), None));
        let kept = self.keep.chunks(2).map(|pair| (Path::new(&pair[1]), pair[0].parse::<usize>().ok()));
        for (path, number) in painted.chain(kept) {
            let mut wanted: Vec<u8> = Vec::new();
            for (file, plane) in beside.held(path, (output, "the output has", "paint over a frame of that size"))? {
                // No number is above 64.
                match number {
                    None => wanted.extend(self.wanted(&file, &plane)?.into_iter().map(|n| n.unwrap_or(0) as u8)),
                    Some(number) => {
                        wanted.extend(white(&plane, &file)?.samples().iter().map(|&w| u8::from(w) * number as u8));
                    }
                }
            }
            let at = |i: usize| usize::from(wanted[i % wanted.len()]);
            keep(&mut only, (exemplars, labels), path, |i| Some(at(i)).filter(|number| 0 < *number))?;
        }
        Ok(Some(only))
    }
}
