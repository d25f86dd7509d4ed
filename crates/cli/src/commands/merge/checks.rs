//! What options of `merge` may not be.

use selvedge_core::Depth;

use super::Merge;
use super::strokes::hex;
use crate::failure::{Failure, n};
use crate::harmonise::Layout;
use crate::outputs;

impl Merge {
    /// Refuses what is wrong by itself.
    pub(super) fn validate(&self) -> Result<(), Failure> {
        let (pictures, places) = (self.weaving.input.exemplars.len(), self.at.len());
        if !(2..=64).contains(&pictures) {
            return Err(Failure::new(2, format!("{} to merge", n("picture", pictures))).remedy("give from 2 to 64"));
        }
        if places != 0 && places != pictures - 1 {
            let what = format!("{} of --at for {}", n("place", places), n("further picture", pictures - 1));
            return Err(Failure::new(2, what).remedy("give one for each after the first"));
        }
        if self.gain && !self.weaving.with.matched.is_empty() {
            let failure = Failure::new(2, "--gain would even the pictures and not the planes of --match");
            return Err(failure.remedy("leave one of both out"));
        }
        self.check_numbers(pictures)
    }

    /// Refuses a file that holds no numbers of pictures.
    pub(super) fn check_label_map(&self) -> Result<(), Failure> {
        let Some(path) = &self.label_map else { return Ok(()) };
        let numbers = (Layout { colors: 1, alpha: false }, Depth::U8);
        outputs::check_held((path, outputs::format(path, None, None)?), [1, 1], numbers, None)
    }

    /// Numbers of pictures are those of pictures that there are.
    fn check_numbers(&self, pictures: usize) -> Result<(), Failure> {
        let colors = self.color.iter().map(|color| (color.picture, format!("--color '{color}'")));
        let kept = self.keep.chunks(2).map(|pair| (pair[0].parse().unwrap_or(0), format!("--keep {}", pair[0])));
        for (number, what) in colors.chain(kept) {
            if !(1..=pictures).contains(&number) {
                let what = format!("{what} is none of {}", n("picture", pictures));
                return Err(Failure::new(2, what).remedy(format!("use a number from 1 to {pictures}")));
            }
        }
        for (i, color) in self.color.iter().enumerate() {
            if self.color[..i].iter().any(|other| other.rgb == color.rgb) {
                let failure = Failure::new(2, format!("{} stands for two pictures", hex(color.rgb)));
                return Err(failure.remedy("give each colour once"));
            }
            if color.rgb == [0; 3] {
                let failure = Failure::new(2, "black is what may show any picture");
                return Err(failure.remedy("paint with another colour"));
            }
        }
        if self.strokes.is_some() && self.color.is_empty() {
            let failure = Failure::new(2, "no colour of --strokes stands for a picture");
            return Err(failure.remedy("give --color '#RRGGBB=N' for each"));
        }
        Ok(())
    }
}
