//! The columns and their names.

/// What a synthesis is like, beside its exemplar. Lower is closer to it unless said otherwise; see each column's
/// formula.
///
/// *Contrast* is the standard deviation of the exemplar's samples, root mean square of the channels by weight. A
/// *distance* of two windows is their root mean square difference over the contrast of the exemplar at that size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Columns {
    /// Mean distance of windows of 8 px to the nearest of the exemplar, of 2,000 windows drawn at full size (fewer of
    /// exemplars over 512^2, 320 at least). `[Kwatra05 eq. 1]`
    pub coherence: f64,
    /// The same of all windows of 16 px (8 px at half size), 8 px apart.
    pub coherence_2: f64,
    /// The same of all windows of 32 px (8 px at a quarter of the size), 8 px apart.
    pub coherence_4: f64,
    /// The same of all windows of 64 px (16 px at a quarter of the size), 16 px apart: are the parts in an order that
    /// the exemplar has? 0 where the exemplar holds no such window.
    pub arrangement: f64,
    /// Mean of the twentieth of the windows at half size that are farthest from the exemplar: the worst places.
    pub worst: f64,
    /// As `coherence_2`, from the exemplar to the output: what is missing.
    pub completeness_2: f64,
    /// As `coherence_4`, from the exemplar to the output.
    pub completeness_4: f64,
    /// How unevenly the exemplar's parts are used, in bits: the Kullback-Leibler divergence of the windows' nearest
    /// places at half size, in boxes of 16 px, from an even use. 0 is even.
    pub unevenness: f64,
    /// Mean number of other windows of 64 px, at least 32 px away, that are the same place of the exemplar within 4 px:
    /// visible repeats.
    pub repeats: f64,
    /// By how much the exemplar's strongest periods are weaker in the output, at most two of them, the largest loss:
    /// from 0 (kept, or the exemplar has none) to about 1.
    pub lattice: f64,
    /// Share of windows of 16 px with less variance than a tenth of the exemplar's has, less that tenth: washed-out or
    /// empty places. From -0.1 to 0.9.
    pub bland: f64,
    /// `log2` of the mean second difference, output over exemplar: below 0 is blurred, above broken or noisy.
    pub sharpness: f64,
    /// Wasserstein-1 distance of the samples' distributions in the mean of the channels, over the contrast.
    pub colour: f64,
    /// `log2` of the variance of means of 32 px, output over exemplar: light and shade that were lost (below 0) or
    /// heaped up.
    pub shade: f64,
    /// Mean distance of windows of 8 px across the wrap over that of the worst twentieth elsewhere, less 1, 0.05 added
    /// to both; the larger of the periodic axes. 0 where it is no worse than the worst seams are, or nothing wraps.
    pub wrap: f64,
    /// `log2` of the output's side over the exemplar's, by area: 1 for twice as wide and high.
    pub scale: f64,
    /// What only the map tells.
    pub seams: Option<Seams>,
}

/// What the source map tells of the seams.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seams {
    /// Mean price of a seam by difference `[Kwatra03 eq. 1]`, over that of samples that meet by chance.
    pub colour: f64,
    /// The same by difference over gradients `[Kwatra03 eq. 5]`.
    pub gradient: f64,
    /// Price of all seams by difference for each hundred samples of the output, over that of one chance meeting.
    pub energy: f64,
    /// Edges that cross seams and are not carried on: the sum over seams of how much the gradients along the seam
    /// differ between both patches, for each sample of the output, over the exemplar's mean gradient.
    pub torn: f64,
    /// Seams for each sample of the output: 2 where no sample continues another.
    pub density: f64,
    /// Share of the exemplars' valid samples that are used.
    pub used: f64,
}

impl Columns {
    /// Names and values, in a fixed order; columns of the map last, and only where there is one.
    pub fn named(&self) -> Vec<(&'static str, f64)> {
        let mut all = vec![
            ("coherence", self.coherence),
            ("coherence_2", self.coherence_2),
            ("coherence_4", self.coherence_4),
            ("arrangement", self.arrangement),
            ("worst", self.worst),
            ("completeness_2", self.completeness_2),
            ("completeness_4", self.completeness_4),
            ("unevenness", self.unevenness),
            ("repeats", self.repeats),
            ("lattice", self.lattice),
            ("bland", self.bland),
            ("sharpness", self.sharpness),
            ("colour", self.colour),
            ("shade", self.shade),
            ("wrap", self.wrap),
            ("scale", self.scale),
        ];
        if let Some(s) = self.seams {
            all.extend([
                ("seam_colour", s.colour),
                ("seam_gradient", s.gradient),
                ("seam_energy", s.energy),
                ("seam_torn", s.torn),
                ("seam_density", s.density),
                ("used", s.used),
            ]);
        }
        all
    }
}
