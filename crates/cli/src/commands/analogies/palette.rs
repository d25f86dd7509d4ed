//! The colours of maps of labels, also of such that were smoothed or compressed with losses.

use std::collections::{BTreeMap, BTreeSet};

use selvedge_core::{Domain, Grid, try_vec};

use crate::failure::Failure;

/// Labels at most; a map with more is a picture.
const MOST: usize = 64;
/// In maps of more colours than that, those that differ by no more than this in any channel are one: the noise of lossy
/// compression around flat colours.
const NEAR: u8 = 40;
/// There, a label has at least one sample of so many: what is rarer is taken for a mixture of two at their border. A
/// guess: smooth maps have mixtures above it, and are compared as they are (see `MOST`).
const RARE: usize = 100;

/// There, a colour that is not to be had is refused if one sample of so many has it: compression at borders makes
/// smaller parts of colours that no label has. A guess.
const LARGE: usize = 20;

/// Smoothed borders are mixtures so many samples away from what they part, at most: compression smears them by a few.
const BORDER: u32 = 3;

type Color = [u8; 3];

/// The labels' colours, the most frequent first, each with its samples.
#[derive(Debug, PartialEq)]
pub(in crate::commands) struct Palette {
    colors: Vec<(Color, usize)>,
    /// Whether there are no others.
    pub(in crate::commands) is_exact: bool,
}

impl Palette {
    /// The colours of maps that go together.
    pub(in crate::commands) fn of(maps: &[&Grid<u8, 2>]) -> Result<Self, Failure> {
        let mut counts: BTreeMap<Color, usize> = BTreeMap::new();
        for map in maps {
            (0..map.domain().len()).for_each(|i| *counts.entry(color(map, i)).or_default() += 1);
        }
        if counts.len() <= MOST {
            let mut exact: Vec<(Color, usize)> = counts.into_iter().collect();
            exact.sort_by_key(|&(color, count)| (std::cmp::Reverse(count), color));
            return Ok(Self { colors: exact, is_exact: true });
        }
        let all: usize = counts.values().sum();
        let mut counts: Vec<(Color, usize)> = counts.into_iter().collect();
        counts.sort_by_key(|&(color, count)| (std::cmp::Reverse(count), color));
        let mut found: Vec<(Color, usize)> = Vec::new();
        for (color, count) in counts {
            match found.iter().position(|(other, _)| apart(*other, color) <= NEAR) {
                Some(known) => found[known].1 += count,
                // Colours come in falling numbers: past this many nothing can be a label any more.
                None if found.len() < 16 * MOST => found.push((color, count)),
                None => {}
            }
        }
        let different = found.len();
        found.retain(|(_, count)| all <= *count * RARE);
        if (1..=MOST).contains(&found.len()) {
            return Ok(Self { colors: found, is_exact: false });
        }
        let what = format!("{different} colours are more than the {MOST} labels that there may be");
        Err(Failure::new(3, what).remedy("give a map of few flat colours, or use 'selvedge analogy'"))
    }

    /// Their names, the most frequent first.
    pub(in crate::commands) fn names(&self) -> impl Iterator<Item = String> + use<'_> {
        self.colors.iter().map(|(color, _)| hex(*color))
    }

    pub(super) fn color(&self, label: usize) -> Color {
        self.colors[label].0
    }

    pub(super) fn len(&self) -> usize {
        self.colors.len()
    }

    /// Refuses colours that are wanted in a map but not there, unless they are mixtures at borders; of maps of more
    /// colours than labels those of a large part of it, unless they are mixtures of any two.
    pub(super) fn check(&self, wanted: &Self, map: &Grid<u8, 2>) -> Result<(), Failure> {
        let is_missing = |color: &Color| self.colors.iter().all(|(own, _)| NEAR < apart(*own, *color));
        let is_exact = self.is_exact && wanted.is_exact;
        let is_small = |count: usize| count.saturating_mul(LARGE) < map.domain().len();
        let is_spared = |&(color, count): &(Color, usize)| match is_exact {
            true => self.mixes(color, map),
            false => is_small(count) || self.is_between_any(color),
        };
        let missing: Vec<&(Color, usize)> =
            wanted.colors.iter().filter(|found| is_missing(&found.0) && !is_spared(found)).collect();
        if missing.is_empty() {
            return Ok(());
        }
        let what = format!(
            "no label of the exemplar has the colour {}; it asks for {}, the exemplar has {}",
            missing.iter().map(|(c, _)| hex(*c)).collect::<Vec<_>>().join(", "),
            wanted.listed(),
            self.listed()
        );
        Err(Failure::new(3, what).remedy("use the colours of --labels in --target"))
    }

    /// True for a colour that lies between those of two labels.
    fn is_between_any(&self, mixture: Color) -> bool {
        let pairs = |a: usize| (a + 1..self.len()).map(move |b| [a, b]);
        (0..self.len()).flat_map(pairs).any(|pair| is_between(mixture, pair.map(|label| self.color(label))))
    }

    /// True for a colour that a map has nowhere but between two labels, and that lies between theirs: smoothing makes
    /// such, and the mixtures that compression makes of them.
    fn mixes(&self, mixture: Color, map: &Grid<u8, 2>) -> bool {
        let [height, width] = map.domain().shape;
        let around = |[y, x]: [u32; 2]| {
            let rows = y.saturating_sub(BORDER)..(y + BORDER + 1).min(height);
            let columns = x.saturating_sub(BORDER)..(x + BORDER + 1).min(width);
            let colors = rows.flat_map(move |y| columns.clone().map(move |x| color(map, (y * width + x) as usize)));
            let near = |seen: Color| self.colors.iter().position(|(own, _)| apart(*own, seen) <= NEAR);
            colors.filter_map(near).collect::<BTreeSet<usize>>()
        };
        let mixed = |labels: &BTreeSet<usize>| {
            let pairs = labels.iter().flat_map(|a| labels.range(a + 1..).map(move |b| [*a, *b]));
            pairs.into_iter().any(|pair| is_between(mixture, pair.map(|label| self.colors[label].0)))
        };
        let places = map.domain().positions().enumerate().filter(|(i, _)| color(map, *i) == mixture);
        places.into_iter().all(|(_, at)| mixed(&around(at)))
    }

    fn listed(&self) -> String {
        self.colors.iter().map(|(c, count)| format!("{} ({count} px)", hex(*c))).collect::<Vec<_>>().join(", ")
    }

    /// The label of each sample, and how many samples have another colour than it.
    pub(in crate::commands) fn nearest(&self, map: &Grid<u8, 2>) -> Result<(Vec<u8>, usize), Failure> {
        let mut labels = try_vec(map.domain().len(), 0_u8)?;
        let mut changed = 0;
        for (i, label) in labels.iter_mut().enumerate() {
            let own = color(map, i);
            let nearest = self.colors.iter().enumerate().min_by_key(|(_, (c, _))| distance(*c, own));
            let (number, (found, _)) = nearest.expect("a palette has a colour");
            (*label, changed) = (number as u8, changed + usize::from(*found != own));
        }
        Ok((labels, changed))
    }

    /// Labels as their colours.
    pub(super) fn colored(&self, domain: Domain<2>, labels: &[u8]) -> Result<Grid<u8, 2>, Failure> {
        let mut out = Grid::try_filled(domain, 3, 0)?;
        for c in 0..3 {
            let of = |label: u8| self.colors[usize::from(label)].0[c];
            out.plane_mut(c).iter_mut().zip(labels).for_each(|(to, &label)| *to = of(label));
        }
        Ok(out)
    }

    /// Labels as one channel each.
    pub(super) fn one_hot(&self, domain: Domain<2>, labels: &[u8]) -> Result<Grid<u8, 2>, Failure> {
        let mut out = Grid::try_filled(domain, self.len(), 0)?;
        for c in 0..self.len() {
            out.plane_mut(c)
                .iter_mut()
                .zip(labels)
                .for_each(|(to, &label)| *to = if usize::from(label) == c { 255 } else { 0 });
        }
        Ok(out)
    }
}

/// A sample's colour; of a grey map thrice its value.
fn color(map: &Grid<u8, 2>, i: usize) -> Color {
    std::array::from_fn(|c| map.plane(c.min(map.channels() - 1))[i])
}

fn apart(a: Color, b: Color) -> u8 {
    a.into_iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}

/// True for a colour no farther than `NEAR` from the line between two others.
fn is_between(mixture: Color, [a, b]: [Color; 2]) -> bool {
    let along = |c: usize| i64::from(b[c]) - i64::from(a[c]);
    let from_a = |c: usize| i64::from(mixture[c]) - i64::from(a[c]);
    let length: i64 = (0..3).map(|c| along(c).pow(2)).sum();
    let part = (0..3).map(|c| along(c) * from_a(c)).sum::<i64>().clamp(0, length);
    (0..3).all(|c| (from_a(c) * length - along(c) * part).abs() <= i64::from(NEAR) * length)
}

fn distance(a: Color, b: Color) -> u32 {
    a.into_iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
}

fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(colors: &[Color]) -> Grid<u8, 2> {
        let samples = (0..3).flat_map(|c| colors.iter().map(move |color| color[c])).collect();
        Grid::from_vec(Domain::open([1, colors.len() as u32]), 3, samples).unwrap()
    }

    #[test]
    fn mixtures_and_noise_are_no_labels() {
        let (red, blue) = ([250, 0, 0], [0, 0, 250]);
        let mixtures: Vec<Color> = (0..80).map(|i| [2 * i + 41, i, 205 - 2 * i]).collect();
        let colors = [&[red; 5000][..], &[[240, 9, 3]; 5], &mixtures, &[blue; 4000]].concat();
        let palette = Palette::of(&[&map(&colors)]).unwrap();
        assert_eq!(palette.colors.iter().map(|(color, _)| *color).collect::<Vec<_>>(), [red, blue]);
        let (labels, changed) = palette.nearest(&map(&[[240, 9, 3], [120, 0, 130], blue])).unwrap();
        assert_eq!((labels, changed), (vec![0, 1, 1], 2));
        assert_eq!(palette.one_hot(Domain::open([1, 2]), &[1, 0]).unwrap().samples(), [0, 255, 255, 0]);
        assert_eq!(palette.colored(Domain::open([1, 2]), &[1, 0]).unwrap(), map(&[blue, red]));
    }

    #[test]
    fn what_is_wanted_and_not_there_is_told_with_both_palettes() {
        let have = Palette::of(&[&map(&[[250, 0, 0]; 9])]).unwrap();
        let wanted = Palette::of(&[&map(&[[[0, 250, 0]; 8].as_slice(), &[[250, 0, 0]; 7]].concat())]).unwrap();
        let asked = map(&[[[0, 250, 0]; 8].as_slice(), &[[250, 0, 0]; 7]].concat());
        let failure = have.check(&wanted, &asked).unwrap_err();
        let expected = "no label of the exemplar has the colour #00fa00; it asks for #00fa00 (8 px), #fa0000 (7 px), the \
                        exemplar has #fa0000 (9 px)";
        assert_eq!((failure.exit, failure.message.as_str()), (3, expected));
        assert!(have.check(&have, &map(&[[250, 0, 0]; 9])).is_ok());
    }

    #[test]
    fn what_lies_between_two_labels_and_on_their_border_is_no_label_that_is_missing() {
        let (red, blue, mixed, green) = ([255, 0, 0], [0, 0, 255], [128, 0, 128], [0, 255, 0]);
        let have = Palette::of(&[&map(&[[red; 9], [blue; 9]].concat())]).unwrap();
        let asks = |colors: &[Color]| {
            let asked = map(colors);
            have.check(&Palette::of(&[&asked]).unwrap(), &asked).is_ok()
        };
        assert!(asks(&[&[red; 6][..], &[mixed], &[blue; 6]].concat()), "smoothed");
        assert!(asks(&[&[red; 6][..], &[[201, 15, 64]], &[[51, 0, 174]], &[blue; 6]].concat()), "compressed");
        assert!(!asks(&[&[red; 6][..], &[green], &[blue; 6]].concat()), "on the border, and between no others");
        assert!(!asks(&[&[red; 6][..], &[mixed; 9], &[blue; 6]].concat()), "a region of its own");
        assert!(!asks(&[&[mixed][..], &[blue; 12]].concat()), "at the border of one label");
    }

    #[test]
    fn of_compressed_maps_colours_are_missing_too() {
        let (red, blue, green) = ([250, 0, 0], [0, 0, 250], [0, 250, 0]);
        // More colours than labels: noise, and mixtures of all shares.
        let noisy = |colors: [Color; 2]| {
            let noise = |color: Color, i: usize| color.map(|v| v.saturating_add((i % 9) as u8).saturating_sub(4));
            let mixed = |i: usize| {
                std::array::from_fn(|c| {
                    ((usize::from(colors[0][c]) * (99 - i) + usize::from(colors[1][c]) * i) / 99) as u8
                })
            };
            let flat = colors.into_iter().flat_map(|color| (0..500).map(move |i| noise(color, i)));
            map(&flat.chain((0..100).map(mixed)).collect::<Vec<_>>())
        };
        let have = Palette::of(&[&noisy([red, blue])]).unwrap();
        let asks = |colors: [Color; 2]| {
            let asked = noisy(colors);
            have.check(&Palette::of(&[&asked]).unwrap(), &asked)
        };
        assert!(!have.is_exact && asks([blue, red]).is_ok() && asks([red, [128, 0, 128]]).is_ok());
        assert!(asks([red, green]).unwrap_err().message.starts_with("no label of the exemplar has the colour #0"));
    }

    #[test]
    fn of_a_few_flat_colours_each_is_a_label() {
        let colors = [&[[9, 9, 9]; 5000][..], &[[12, 9, 9]; 1]].concat();
        assert_eq!(Palette::of(&[&map(&colors)]).unwrap().len(), 2);
    }

    #[test]
    fn pictures_are_no_maps_of_labels() {
        let colors: Vec<Color> =
            (0..7000_u32).map(|i| [(i % 5 * 60) as u8, (i / 5 % 5 * 60) as u8, (i / 25 % 4 * 60) as u8]).collect();
        assert!(Palette::of(&[&map(&colors)]).unwrap_err().message.starts_with("100 colours are more than the 64"));
        // None of them has its hundredth.
        let colors: Vec<Color> =
            (0..4320_u32).map(|i| [i % 6, i / 6 % 6, i / 36 % 6].map(|v| (v * 51) as u8)).collect();
        assert!(Palette::of(&[&map(&colors)]).unwrap_err().message.starts_with("216 colours are more than the 64"));
    }
}
