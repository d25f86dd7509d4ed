//! The simplest method on this crate: patches drawn at random, taken where an expansion move makes everything cheaper.
//!
//! `cargo run --release -p selvedge-expansion --example random_labels [STEPS]`. Schödl's extension of graphcut textures
//! by an assignment cost, as the CMS paper compares itself with it: labels are drawn, never searched for, so that it
//! takes many of them to follow a guide. All that a method needs is here: seed, limits of time by the observer, events,
//! and a result that is whole whenever it stops.

use selvedge_core::{
    Domain, Event, Exemplars, Grid, Guide, Patch, Plane, Render, Role, Run, SampleId, Samples, SeamCosts, SeamMeasure,
    SourceMap, Window, Woven,
};
use selvedge_expansion::{Error, Frame, Holes, Prices, Scratch, expand};

/// Seams, and how far each sample's guide is from the target's: `weight` for one squared 8-bit step.
struct Guided<'a, const D: usize> {
    seams: SeamCosts<D>,
    exemplars: &'a Exemplars<D>,
    guide: Option<(&'a Guide<D>, i32)>,
}

impl<const D: usize> Prices<D> for Guided<'_, D> {
    fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
        self.seams.pair(axis, here, there)
    }

    fn unary(&self, place: usize, sample: SampleId) -> i32 {
        let Some((guide, weight)) = self.guide else { return 0 };
        let Some(source) = self.exemplars.table().source(sample) else { return 0 };
        let index = (sample.get() - self.exemplars.table().first(source)) as usize;
        let squared = |(c, w): (usize, &u8)| {
            let difference =
                guide.exemplars().sources()[source].features.plane(c)[index].abs_diff(guide.target().plane(c)[place]);
            i32::from(*w) * i32::from(difference).pow(2)
        };
        let error: i32 = guide.weights().iter().enumerate().map(squared).sum();
        error.saturating_mul(weight).min(1 << 28)
    }
}

/// Draws `steps` patches after everything is covered. The counts are those of patches that were taken.
pub(crate) fn random_labels<const D: usize>(
    exemplars: &Exemplars<D>,
    guide: Option<(&Guide<D>, i32)>,
    output: Domain<D>,
    steps: u64,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, u64>, Error> {
    let valid = exemplars.validity();
    let prices = Guided { seams: SeamCosts::new(exemplars, SeamMeasure::Difference)?, exemplars, guide };
    let mut map = SourceMap::unassigned(exemplars, output)?;
    let (mut scratch, mut holes, mut taken, mut step, mut draw) = (Scratch::default(), map.holes(), 0, 0, 0);
    while step < steps || 0 < holes {
        let mut rng = run.seed.derive("random-labels/patch", draw).rng();
        (draw, step) = (draw + 1, step + u64::from(holes == 0));
        let hole = map.ids.plane(0).iter().position(|id| !id.is_assigned());
        let at = output.position(hole.unwrap_or_else(|| rng.below(output.len() as u32) as usize));
        let id = SampleId::new(rng.below(exemplars.table().len()));
        let Some((source, from)) = exemplars.locate(id) else { continue };
        if valid[source].is_some_and(|v| !v.get(0, from)) {
            continue;
        }
        let patch = Patch { source, offset: std::array::from_fn(|a| at[a] as i32 - from[a] as i32) };
        let mut window = patch.footprint(exemplars, &Window::all(output));
        (0..D).for_each(|a| {
            window.shape[a] = window.shape[a].min(if output.periodic[a] { output.shape[a] } else { u32::MAX })
        });
        let frame = Frame::of_patch(exemplars, &map, &patch, &window.inside(output))?;
        let choices = frame.choices(Holes::Fill, |_| None)?;
        let proposal = match expand(&frame, &choices, &prices, &mut scratch, &|| run.observer.cancelled()) {
            Ok(proposal) => proposal,
            Err(error) if error.is_cancelled() => return Ok(Woven { result: map, stats: taken, complete: false }),
            Err(error) => return Err(error),
        };
        if 0 < proposal.filled || 0 < proposal.gain {
            proposal.lay(&frame, &mut map);
            (holes, taken) = (holes - proposal.filled, taken + 1);
        }
        run.observer.event(&Event { so_far: Some(&map), ..Event::step("labels", step, steps) });
    }
    Ok(Woven { result: map, stats: taken, complete: true })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let steps = std::env::args().nth(1).map_or(Ok(600), |n| n.parse())?;
    // Hatching that becomes denser to the right; the guide is how dense it is.
    let domain = Domain::open([24, 64]);
    let of = |f: &dyn Fn([u32; 2]) -> u8| Grid::from_vec(domain, 1, domain.positions().map(f).collect());
    let picture = of(&|[y, x]| if (x + 2 * y) % 8 < x / 8 { b'#' } else { b'.' })?;
    let density = of(&|[_, x]| (x / 8 * 32) as u8)?;
    let plane = Plane::new(Role::Scalar, Samples::U8(picture));
    let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
    // The output is dense in a disc.
    let output = Domain::open([24, 72]);
    let disc = |[y, x]: [u32; 2]| if (y as i32 - 12).pow(2) * 4 + (x as i32 - 36).pow(2) < 400 { 200 } else { 32 };
    let target = Grid::from_vec(output, 1, output.positions().map(disc).collect())?;
    let guide = Guide::new(&exemplars, &[density], target)?;

    let woven = random_labels(&exemplars, Some((&guide, 1)), output, steps, &Run::seeded(0))?;
    let Samples::U8(out) = woven.result.render(&[&plane])?.samples else { unreachable!() };
    out.plane(0).chunks(72).for_each(|row| println!("{}", String::from_utf8_lossy(row)));
    println!("{} patches were taken of {steps}", woven.stats);
    Ok(())
}
