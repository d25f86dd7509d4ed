//! A clip that loops: `loop CLIP OUT`, by the libraries alone.
#![forbid(unsafe_code)]

use std::error::Error;

use selvedge_core::{Exemplars, Render as _, Run};
use selvedge_graphcut_textures::video::{FrameDistances, looped};
use selvedge_io::clip::{ClipOptions, ClipReader, ClipWriteOptions, ClipWriter, frame_of, read_clip};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [clip, out] = &args[..] else { return Err("usage: loop CLIP OUT".into()) };
    let run = Run::seeded(0);
    let mut reader = ClipReader::open(clip, &ClipOptions::default())?;
    let frames = read_clip(&mut reader, &run.limits)?;
    let exemplars = Exemplars::of(&[std::slice::from_ref(&frames)])?;
    let jumps = FrameDistances::new(&exemplars, &Default::default(), &run)?.best(&Default::default(), &run)?;
    let woven = looped(&exemplars, &jumps, &Default::default(), &run)?;
    let rendered = woven.result.map()?.render(&[&frames])?;
    let options = ClipWriteOptions { rate: reader.info().rate, ..ClipWriteOptions::default() };
    let period = woven.result.jump.period();
    let mut writer = ClipWriter::create(out, period, reader.info().metadata.clone(), options)?;
    for t in 0..period {
        writer.frame(&frame_of(&rendered, t)?)?;
    }
    Ok(writer.finish()?)
}
