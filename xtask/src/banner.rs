//! The banner: a word whose letters are merged from copies of one picture over a backdrop, each by strokes, and then
//! into one. A letter that comes again is made once. `[Kwatra03 6B]`

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_testkit::{from_png, to_png};

use crate::outcome::Outcome;
use crate::program;
use crate::tree::root;

const WORD: &str = "SELVEDGE";
/// Seven rows of five pixels each, the left one first.
const LETTERS: [(char, [u8; 7]); 6] = [
    ('D', [0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110]),
    ('E', [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111]),
    ('G', [0b01111, 0b10000, 0b10000, 0b10011, 0b10001, 0b10001, 0b01111]),
    ('L', [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111]),
    ('S', [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110]),
    ('V', [0b10001, 0b10001, 0b10001, 0b10001, 0b01010, 0b01010, 0b00100]),
];
/// Side of a pixel of a letter, rows and columns of its picture, and the margins around it.
const PIXEL: i32 = 14;
const CELL: [u32; 2] = [136, 104];
const MARGIN: [i32; 2] = [(CELL[0] as i32 - 7 * PIXEL) / 2, (CELL[1] as i32 - 5 * PIXEL) / 2];
/// Letters show stones so many samples inside of their outline, and the backdrop so many outside: between, seams may go
/// around whole stones.
const INSIDE: i32 = 3;
const OUTSIDE: i32 = 5;

const STONES: &str = "fixtures/cobbles.png";
const BACKDROP: &str = "fixtures/plaster.png";
const YELLOW: [u8; 3] = [255, 255, 0];
const BLUE: [u8; 3] = [0, 0, 255];

/// The pictures: stones, backdrop, strokes and what was merged of one letter, and the whole word.
pub(crate) struct Banner {
    pub(crate) letter: [String; 4],
    pub(crate) word: String,
}

/// Makes it in a folder below the root.
pub(crate) fn make(selvedge: &Path, folder: &str) -> Result<Banner, String> {
    let file = |name: &str| format!("{folder}/{name}.png");
    let width = CELL[1] * WORD.len() as u32;
    run(selvedge, &format!("synthesize {BACKDROP} --mend none --size {width}x{} -o {}", CELL[0], file("backdrop")))?;
    let (backdrop, stones) = (read(&file("backdrop"))?, read(STONES)?);
    let mut places: BTreeMap<char, Vec<u32>> = BTreeMap::new();
    WORD.chars().zip(0..).for_each(|(letter, at)| places.entry(letter).or_default().push(at));
    for (letter, at) in &places {
        write(&file(&format!("{letter}-backdrop")), &part(&backdrop, [0, at[0] * CELL[1]], CELL)?)?;
        write(&file(&format!("{letter}-stones")), &part(&stones, [10, 20 + 11 * at[0]], CELL)?)?;
        write(&file(&format!("{letter}-strokes")), &strokes(&[(*letter, YELLOW)])?)?;
        let [below, above, strokes] = ["backdrop", "stones", "strokes"].map(|of| file(&format!("{letter}-{of}")));
        let colors = "--color #0000ff=1 --color #ffff00=2";
        let line = format!("merge {below} {above} --strokes {strokes} {colors} -o {}", file(&letter.to_string()));
        run(selvedge, &line)?;
    }
    // What a letter's own strokes gave to stones stays stone, all else is free again.
    let of_word: Vec<_> = WORD.chars().zip(1..).map(|(letter, n)| (letter, [255, 255, n])).collect();
    write(&file("strokes"), &strokes(&of_word)?)?;
    let mut line =
        format!("merge {} --strokes {} --color #0000ff=1 -o {}", file("backdrop"), file("strokes"), file("word"));
    for (letter, n) in WORD.chars().zip(0..) {
        line += &format!(" {} --at {},0 --color #ffff{:02x}={}", file(&letter.to_string()), n * CELL[1], n + 1, n + 2);
    }
    run(selvedge, &line)?;
    let letter = ["S-stones", "S-backdrop", "S-strokes", "S"].map(file);
    Ok(Banner { letter, word: file("word") })
}

/// Two photographs that overlap, what is merged of them, and where the seam runs, in a folder below the root.
/// `[Kwatra03 6B]`
pub(crate) fn overlap(selvedge: &Path, folder: &str) -> Result<[String; 4], String> {
    let [left, right] = ["left", "right"].map(|side| format!("fixtures/coffee/{side}.jpg"));
    let [merged, explained, seam] =
        ["coffee", "coffee-explained", "coffee-seam"].map(|of| format!("{folder}/{of}.png"));
    run(selvedge, &format!("merge {left} {right} --at auto -o {merged} --explain {explained}"))?;
    // Nothing of it is transparent; and the first of what explains a map is the picture under its seams.
    let made = read(&merged)?;
    let shape = made.domain().shape;
    write(&merged, &part(&made, [0, 0], shape)?)?;
    write(&seam, &part(&read(&explained)?, [0, 0], shape)?)?;
    Ok([left, right, merged, seam])
}

/// Strokes of letters side by side, each in its colour, and black where any may show. Blue is the last column, so that
/// the backdrop shows at all, and of one letter what is far from it.
fn strokes(letters: &[(char, [u8; 3])]) -> Result<Plane<2>, String> {
    let domain = Domain::open([CELL[0], CELL[1] * letters.len() as u32]);
    let color = |[y, x]: [u32; 2]| {
        let (letter, color) = letters[(x / CELL[1]) as usize];
        let at = [y as i32, (x % CELL[1]) as i32];
        let around =
            |reach: i32| (-reach..=reach).flat_map(move |v| (-reach..=reach).map(move |u| [at[0] + v, at[1] + u]));
        let is_far = letters.len() == 1 && !around(OUTSIDE).any(|at| is_ink(letter, at));
        if around(INSIDE).all(|at| is_ink(letter, at)) {
            color
        } else if is_far || x + 1 == domain.shape[1] {
            BLUE
        } else {
            [0; 3]
        }
    };
    let colors: Vec<[u8; 3]> = domain.positions().map(color).collect();
    let samples = (0..3).flat_map(|c| colors.iter().map(move |color| color[c])).collect();
    let grid = Grid::from_vec(domain, 3, samples).map_err(|e| e.to_string())?;
    Ok(Plane::new(Role::Color, Samples::U8(grid)))
}

fn is_ink(letter: char, at: [i32; 2]) -> bool {
    let [row, column] = [0, 1].map(|a| (at[a] - MARGIN[a]).div_euclid(PIXEL));
    let rows = LETTERS.iter().find(|(other, _)| *other == letter).map(|(_, rows)| rows);
    (0..7).contains(&row) && (0..5).contains(&column) && rows.is_some_and(|r| r[row as usize] >> (4 - column) & 1 == 1)
}

/// The colours of a part of a picture of 8 bits.
fn part(picture: &Plane<2>, start: [u32; 2], shape: [u32; 2]) -> Result<Plane<2>, String> {
    let Samples::U8(from) = &picture.samples else { return Err("8 bits a sample, please".into()) };
    let at = |[y, x]: [u32; 2]| [start[0] + y, start[1] + x];
    let cell = Domain::open(shape);
    let channels = picture.color_channels();
    let samples = (0..channels).flat_map(|c| cell.positions().map(move |p| from.get(c, at(p)))).collect();
    let grid = Grid::from_vec(cell, channels, samples).map_err(|e| e.to_string())?;
    Ok(Plane::new(Role::Color, Samples::U8(grid)))
}

fn run(selvedge: &Path, line: &str) -> Outcome {
    let output = program::run(selvedge, line.split(' '))?;
    program::check(output.status.success(), || String::from_utf8_lossy(&output.stderr).into_owned())
}

fn read(path: &str) -> Result<Plane<2>, String> {
    let file = fs::read(root().join(path)).map_err(|e| format!("{path}: {e}"))?;
    from_png(Role::Color, &file).map_err(|e| format!("{path}: {e}"))
}

fn write(path: &str, plane: &Plane<2>) -> Outcome {
    fs::write(root().join(path), to_png(plane)).map_err(|e| format!("{path}: {e}"))
}
