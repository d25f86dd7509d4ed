//! What `animate` is to make, and whether it can be.

use std::path::PathBuf;

use selvedge_core::Domain;
use selvedge_io::Metadata;
use selvedge_io::clip::{ClipName, ClipWriteOptions, ClipWriter};
use selvedge_texture_optimization::{Animation, Options};

use super::flow::Flows;
use super::{Animate, FRAMES};
use crate::exemplars::Headers;
use crate::failure::Failure;
use crate::harmonise::Layout;
use crate::session::Session;
use crate::size::{Size, Tile};
use crate::{clips, outputs};

impl Animate {
    /// Options of the frames after the first one.
    pub(super) fn options(&self) -> Result<Animation, Failure> {
        let default = Animation::default();
        let frame = Options { schedule: self.schedule.0.clone(), iterations: self.iterations, ..default.frame };
        let options = Animation { frame, lambda: self.lambda, ..default };
        options.validate()?;
        Ok(options)
    }

    /// How many frames there are: those of vectors, and the first one, which comes again where the last flow leads to
    /// it; else those of a clip that is the exemplar, its `period`.
    pub(super) fn count(&self, flows: Option<&Flows>, period: Option<u32>) -> Result<u32, Failure> {
        let of_flows = flows.map(Flows::len).filter(|len| 1 < *len);
        let of_flows = of_flows.map(|len| len + u32::from(self.close.is_none()));
        let frames = self.frames.or(of_flows).or(period).unwrap_or(FRAMES);
        if let Some(period) = period.filter(|period| self.close.is_some() && !frames.is_multiple_of(*period)) {
            let what = format!("--close after {frames} frames, where a clip of {period} has not come around");
            let around = frames.next_multiple_of(period);
            return Err(Failure::new(2, what).remedy(format!("use --frames {around}, or leave --close out")));
        }
        match self.close.filter(|close| frames <= *close) {
            Some(close) => {
                let what = format!("--close {close} leaves no frame as it is, of {frames}");
                let less = if 1 < frames { format!("use --close {} or less, or ", frames - 1) } else { String::new() };
                Err(Failure::new(2, what).remedy(format!("{less}ask for more --frames")))
            }
            None => Ok(frames),
        }
    }

    /// The frames' domain: that of the vectors, with which the size typed must agree.
    pub(super) fn domain(&self, headers: &Headers, flows: Option<&Flows>) -> Result<Domain<2>, Failure> {
        let first = headers.domains()[0].shape;
        let typed = self.size.map(|size| size.shape(first));
        let of_flow = flows.map(|flows| flows.after(0).domain().shape);
        if let (Some([h, w]), Some([fh, fw])) = (typed, of_flow)
            && [h, w] != [fh, fw]
        {
            let what = format!("the flow has {fw}x{fh} vectors, but --size asks for {w}x{h} px");
            return Err(Failure::new(3, what).remedy("leave --size out, or give a flow of that size"));
        }
        let shape = of_flow.or(typed).unwrap_or_else(|| Size::Factor(2.0).shape(first));
        Ok(Tile::domain(self.tile, shape))
    }

    /// What frames have: alpha as well, if a body does not fill them.
    pub(super) fn layout(&self, headers: &Headers) -> Layout {
        Layout { alpha: headers.layout.alpha || self.body.is_some(), ..headers.layout }
    }

    /// How the clip is written.
    pub(super) fn write_options(&self) -> ClipWriteOptions {
        let encode = self.encode.arguments();
        ClipWriteOptions { rate: self.rate, encode, ..ClipWriteOptions::default() }
    }

    /// Refuses what could not be written, before any work.
    pub(super) fn check_outputs(
        &self,
        session: &Session<'_>,
        headers: &Headers,
        (output, frames): (Domain<2>, u32),
        read: &[PathBuf],
    ) -> Result<(), Failure> {
        let path = self.path();
        if self.kept.is_asked() && ClipName::parse(&path).is_none() {
            let what =
                "--checkpoint and --resume go on after frames that are there, and a container is written at its end";
            return Err(Failure::new(2, what).remedy("name frames by a pattern, such as 'name.####.png'"));
        }
        let writer = ClipWriter::create(&path, frames, Metadata::default(), self.write_options())?;
        let layout = self.layout(headers);
        clips::check_held(&writer, (layout.channels(), layout.alpha), headers.depth, output.shape)?;
        clips::tell_left_over(session, &writer);
        // Frames that it goes on from are its own.
        let is_own = |file: &PathBuf| session.global.no_clobber && self.kept.is_resumed() && file.is_file();
        outputs::check(session, &writer.files().into_iter().filter(|file| !is_own(file)).collect::<Vec<_>>(), read)
    }
}
