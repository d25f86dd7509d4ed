//! Pictures in rows: `collage OUT LEFT RIGHT... [/ LEFT RIGHT...]...`. The first of each row stands in a column of its
//! own. Makes the strip in README.md; 8 bits, grey or RGB.
#![forbid(unsafe_code)]

use std::error::Error;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, ReadOptions, WriteOptions, read, write};

/// White pixels between pictures.
const GAP: u32 = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, names @ ..] = &args[..] else {
        return Err("usage: collage OUT LEFT RIGHT... [/ LEFT RIGHT...]...".into());
    };
    let picture = |name: &String| Ok(read(name, &ReadOptions::default())?.plane);
    let row = |names: &[String]| names.iter().map(picture).collect::<Result<Vec<Plane<2>>, selvedge_io::Error>>();
    let rows = names.split(|name| name == "/").map(row).collect::<Result<Vec<_>, _>>()?;
    let collage = in_rows(&rows)?;
    write(out, &collage, &Metadata::default(), &WriteOptions { quality: 90, ..WriteOptions::default() })?;
    Ok(())
}

fn in_rows(rows: &[Vec<Plane<2>>]) -> Result<Plane<2>, Box<dyn Error>> {
    let width = |p: &Plane<2>| p.domain().shape[1];
    let left = rows.iter().filter_map(|row| row.first()).map(width).max().unwrap_or(0);
    let right = |row: &Vec<Plane<2>>| row.iter().skip(1).map(|p| width(p) + GAP).sum::<u32>();
    let widest = rows.iter().map(right).max().unwrap_or(0);
    let height = |row: &Vec<Plane<2>>| row.iter().map(|p| p.domain().shape[0]).max().unwrap_or(0);
    let total: u32 = rows.iter().map(|row| height(row) + GAP).sum();
    let mut collage = Grid::try_filled(Domain::open([total.saturating_sub(GAP), left + widest]), 3, 255_u8)?;
    let mut top = 0;
    for row in rows {
        let mut x = 0;
        for (i, picture) in row.iter().enumerate() {
            draw(&mut collage, picture, [top, x])?;
            x += GAP + if i == 0 { left } else { width(picture) };
        }
        top += height(row) + GAP;
    }
    Ok(Plane::new(Role::Color, Samples::U8(collage)))
}

/// Draws a picture with its top left corner at a place.
fn draw(collage: &mut Grid<u8, 2>, picture: &Plane<2>, [top, left]: [u32; 2]) -> Result<(), Box<dyn Error>> {
    let Samples::U8(samples) = &picture.samples else { return Err("8 bits a sample, please".into()) };
    let grey = match samples.channels() {
        3 => false,
        1 => true,
        n => return Err(format!("1 or 3 channels, please, not {n}").into()),
    };
    for at in samples.domain().positions() {
        for c in 0..3 {
            collage.set(c, [at[0] + top, at[1] + left], samples.get(if grey { 0 } else { c }, at));
        }
    }
    Ok(())
}
