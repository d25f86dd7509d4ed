//! Surfaces as pictures: `--surface` and `--surface-from`.

use std::path::Path;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_graphcut_textures::video::{Jump, Surface};
use selvedge_io::{Format, Provenance};

use crate::failure::Failure;

/// When each pixel jumps, as a picture: of floats where its file holds no whole numbers.
pub(super) fn times(surface: &Surface, path: &Path) -> Result<Plane<2>, Failure> {
    let floats = Format::of_name(path) == Some(Format::Exr);
    let time = &surface.time;
    let samples = if floats { Samples::F32(time.map(f32::from)?) } else { Samples::U16(time.map(|v| v)?) };
    Ok(Plane::new(Role::Scalar, samples))
}

/// The same, from a picture.
pub(super) fn whole_numbers(plane: &Plane<2>) -> Result<Grid<u16, 2>, Failure> {
    let time: Vec<u16> = match &plane.samples {
        Samples::U8(grid) => grid.plane(0).iter().map(|v| u16::from(*v)).collect(),
        Samples::U16(grid) => grid.plane(0).to_vec(),
        Samples::F32(grid) if grid.plane(0).iter().all(|&v| f32::from(v as u16) == v) => {
            grid.plane(0).iter().map(|&v| v as u16).collect()
        }
        floats => {
            let what = format!("has {} samples, which are no numbers of frames", floats.depth().name());
            return Err(Failure::new(3, what).remedy("give the file that --surface wrote"));
        }
    };
    Ok(Grid::from_vec(Domain::open(plane.domain().shape), 1, time)?)
}

/// Refuses the surface of another jump, where its file tells of which it is.
pub(super) fn check(made: Option<&Provenance>, jump: &Jump) -> Result<(), Failure> {
    let mut words = made.map_or("", |made| &made.command).split(' ').skip_while(|word| *word != "--jump");
    let asked = format!("{},{}", jump.from, jump.to);
    match words.nth(1) {
        Some(of) if of != asked => {
            let failure = Failure::new(3, format!("is the surface of jump {of}, not of {asked}"));
            Err(failure.remedy(format!("use --jump {of}")))
        }
        _ => Ok(()),
    }
}
