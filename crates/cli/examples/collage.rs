//! Pictures in two columns: `collage OUT LEFT RIGHT [LEFT RIGHT]...`. Makes the strip in README.md; 8-bit RGB alone.
#![forbid(unsafe_code)]

use std::error::Error;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, ReadOptions, WriteOptions, read, write};

/// White pixels between pictures.
const GAP: u32 = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, names @ ..] = &args[..] else { return Err("usage: collage OUT LEFT RIGHT [LEFT RIGHT]...".into()) };
    let pictures = names.iter().map(|name| Ok(read(name, &ReadOptions::default())?.plane));
    let pictures = pictures.collect::<Result<Vec<Plane<2>>, selvedge_io::Error>>()?;
    let collage = two_columns(&pictures)?;
    write(out, &collage, &Metadata::default(), &WriteOptions { quality: 90, ..WriteOptions::default() })?;
    Ok(())
}

fn two_columns(pictures: &[Plane<2>]) -> Result<Plane<2>, Box<dyn Error>> {
    let widest =
        |column: usize| pictures.iter().skip(column).step_by(2).map(|p| p.domain().shape[1]).max().unwrap_or(0);
    let height = |row: &[Plane<2>]| row.iter().map(|p| p.domain().shape[0]).max().unwrap_or(0);
    let total: u32 = pictures.chunks(2).map(|row| height(row) + GAP).sum();
    let domain = Domain::open([total.saturating_sub(GAP), widest(0) + GAP + widest(1)]);
    let mut collage = Grid::try_filled(domain, 3, 255_u8)?;
    let mut top = 0;
    for row in pictures.chunks(2) {
        for (picture, left) in row.iter().zip([0, widest(0) + GAP]) {
            let Samples::U8(samples) = &picture.samples else { return Err("8 bits a sample, please".into()) };
            if samples.channels() != 3 {
                return Err(format!("3 channels, please, not {}", samples.channels()).into());
            }
            for at in samples.domain().positions() {
                for c in 0..3 {
                    collage.set(c, [at[0] + top, at[1] + left], samples.get(c, at));
                }
            }
        }
        top += height(row) + GAP;
    }
    Ok(Plane::new(Role::Color, Samples::U8(collage)))
}
