//! `--sheet`: the pictures of several runs beside each other, each with its number below it.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};

use crate::eyes;
use crate::failure::Failure;
use crate::thumbnail::Thumbnail;

/// Samples a side of the pictures in a sheet; larger ones are reduced.
const LARGEST: u32 = 384;
/// Paper around each picture.
const MARGIN: u32 = 8;
/// How many samples a dot of a digit has.
const DOT: u32 = 2;
/// Dots of a digit, and of the paper after it.
const DIGIT: [u32; 2] = [5, 3];

/// Rows of dots of 0 to 9, `.` and `/`, three bits each.
const DIGITS: [[u8; 5]; 12] = [
    [0b111, 0b101, 0b101, 0b101, 0b111],
    [0b010, 0b110, 0b010, 0b010, 0b111],
    [0b111, 0b001, 0b111, 0b100, 0b111],
    [0b111, 0b001, 0b111, 0b001, 0b111],
    [0b101, 0b101, 0b111, 0b001, 0b001],
    [0b111, 0b100, 0b111, 0b001, 0b111],
    [0b111, 0b100, 0b111, 0b101, 0b111],
    [0b111, 0b001, 0b010, 0b010, 0b010],
    [0b111, 0b101, 0b111, 0b101, 0b111],
    [0b111, 0b101, 0b111, 0b001, 0b111],
    [0b000, 0b000, 0b000, 0b000, 0b010],
    [0b001, 0b001, 0b010, 0b100, 0b100],
];

/// A picture as it stands in a sheet, and what is written under it.
pub(crate) type Cell = (Grid<u8, 2>, String);

/// A picture as small as a sheet shows it, so that no run's output is held whole for it.
///
/// # Errors
/// No memory for it.
pub(crate) fn cell(picture: &Plane<2>) -> Result<Grid<u8, 2>, Failure> {
    eyes::on_white(picture, LARGEST)
}

/// Bytes that cells take until their sheet is written: themselves, their places in it, and its file.
pub(crate) fn held(cells: &[Cell]) -> u64 {
    cells.iter().map(|(grid, _)| 3 * 3 * grid.domain().len() as u64).sum()
}

/// A contact sheet, 8-bit RGB: pictures in reading order, in so many columns or about as many as rows, and under each
/// its label.
///
/// # Errors
/// No memory for it.
pub(crate) fn sheet(cells: &[Cell], columns: Option<usize>) -> Result<Plane<2>, Failure> {
    Ok(Plane::new(Role::Color, Samples::U8(paper(cells, columns)?)))
}

fn paper(cells: &[Cell], columns: Option<usize>) -> Result<Grid<u8, 2>, Failure> {
    let columns = columns.or_else(|| (1..).find(|c| cells.len() <= c * c)).unwrap_or(1).max(1) as u32;
    let side = |axis: usize| cells.iter().map(|(grid, _)| grid.domain().shape[axis]).max().unwrap_or(1);
    let widest = cells.iter().map(|(_, label)| width(label)).max().unwrap_or(1);
    let cell = [side(0) + MARGIN + DIGIT[0] * DOT, side(1).max(widest)];
    let rows = (cells.len() as u32).div_ceil(columns);
    let shape = [rows * (cell[0] + MARGIN) + MARGIN, columns * (cell[1] + MARGIN) + MARGIN];
    let mut paper = Grid::try_filled(Domain::open(shape), 3, 255_u8)?;
    for (i, (picture, label)) in cells.iter().enumerate() {
        let at = [i as u32 / columns, i as u32 % columns];
        let corner = [0, 1].map(|axis| MARGIN + at[axis] * (cell[axis] + MARGIN));
        paste(&mut paper, corner, picture);
        write(&mut paper, [corner[0] + side(0) + MARGIN / 2, corner[1]], label);
    }
    Ok(paper)
}

/// Lays a picture so that it begins at a corner.
fn paste(paper: &mut Grid<u8, 2>, corner: [u32; 2], picture: &Grid<u8, 2>) {
    for [y, x] in picture.domain().positions() {
        (0..3).for_each(|c| paper.set(c, [corner[0] + y, corner[1] + x], picture.get(c, [y, x])));
    }
}

/// A picture with a sheet of what else was made below it, numbered from 1.
///
/// # Errors
/// No memory for it.
pub(crate) fn below(picture: &Plane<2>, tried: &[Thumbnail]) -> Result<Plane<2>, Failure> {
    let cells = (1..).zip(tried).map(|(n, t)| Ok((cell(&t.picture)?, n.to_string())));
    let (above, below) =
        (eyes::on_white(picture, u32::MAX)?, paper(&cells.collect::<Result<Vec<Cell>, Failure>>()?, None)?);
    let [a, b] = [&above, &below].map(|grid| grid.domain().shape);
    let mut both = Grid::try_filled(Domain::open([a[0] + b[0], a[1].max(b[1])]), 3, 255_u8)?;
    paste(&mut both, [0, 0], &above);
    paste(&mut both, [a[0], 0], &below);
    Ok(Plane::new(Role::Color, Samples::U8(both)))
}

/// From one digit to the next.
const STEP: u32 = (DIGIT[1] + 1) * DOT;

/// How wide a label is.
fn width(label: &str) -> u32 {
    label.len() as u32 * STEP
}

/// Writes digits, points and strokes; anything else leaves room.
fn write(paper: &mut Grid<u8, 2>, [top, left]: [u32; 2], digits: &str) {
    for (i, digit) in digits.bytes().enumerate() {
        let known = b"0123456789./".iter().position(|&d| d == digit);
        let Some(rows) = known.map(|known| DIGITS[known]) else { continue };
        for [y, x] in Domain::open([DIGIT[0] * DOT, DIGIT[1] * DOT]).positions() {
            if rows[(y / DOT) as usize] >> (DIGIT[1] - 1 - x / DOT) & 1 == 1 {
                (0..3).for_each(|c| paper.set(c, [top + y, left + i as u32 * STEP + x], 0));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(shape: [u32; 2], value: u8) -> Grid<u8, 2> {
        let grid = Grid::try_filled(Domain::open(shape), 1, value).unwrap();
        cell(&Plane::new(Role::Color, Samples::U8(grid))).unwrap()
    }

    #[test]
    fn pictures_stand_in_reading_order_with_their_labels() {
        let pictures = [(grey([20, 30], 10), "7"), (grey([10, 30], 20), "10"), (grey([20, 30], 30), "4000000000")]
            .map(|(grid, label)| (grid, label.to_owned()));
        let Samples::U8(sheet) = sheet(&pictures, None).unwrap().samples else { unreachable!() };
        let cell = 20 + 8 + 10;
        assert_eq!(sheet.domain().shape, [2 * (cell + 8) + 8, 2 * 88 + 8], "as wide as ten digits");
        assert_eq!([[8, 8], [8, 96], [54, 8]].map(|at| sheet.get(1, at)), [10, 20, 30]);
        assert_eq!(sheet.get(0, [54, 96]), 255, "nothing stands last");
        // The upper stroke of a seven, and what is below it.
        assert_eq!([32, 35].map(|y| sheet.get(0, [y, 8])), [0, 255]);
        assert_eq!(sheet.get(2, [8 + 12, 96]), 255, "a lower picture ends earlier");
        // The last digit of the longest label: a nought's left stroke.
        assert_eq!([54 + 24, 54 + 26].map(|y| sheet.get(0, [y, 8 + 9 * STEP])), [0, 0]);
    }

    #[test]
    fn cells_are_small_and_count() {
        let large = grey([1000, 500], 9);
        assert_eq!(large.domain().shape, [384, 192]);
        assert_eq!(held(&[(large, "1".to_owned()), (grey([2, 2], 3), "2".to_owned())]), 9 * (384 * 192 + 4));
    }
}
