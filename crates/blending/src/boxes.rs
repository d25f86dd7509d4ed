//! A map is rendered box by box: only positions that have a seam in reach are computed, all others are copied.

use selvedge_core::{Averaging, Bytes, Domain, Error, Patch, Payload, Plane, SampleId, Window, par};

use crate::map_view::MapView;
use crate::near::near_seams;
use crate::region::{Shown, rows, shown};

/// Samples of a box, about: 128 a side in pictures, 25 in clips. A box is computed with what is around it, so that
/// small ones repeat much (with 64 a side five bands cost 1.8 times as much); large ones leave threads without work.
const BOX: u32 = 1 << 14;

/// Boxes whose values are held until they are written: enough for the threads of most machines.
const TOGETHER: usize = 16;

/// Part of an output, what is around it, and the positions in it that are to be blended.
pub(crate) struct Part<'a, const D: usize> {
    pub(crate) laid: &'a MapView<'a, D>,
    payload: &'a Payload<'a, D>,
    averaging: &'a Averaging,
    /// The box around all that is wanted.
    pub(crate) wanted: Window<D>,
    /// The same with everything that it depends on.
    pub(crate) window: Window<D>,
    /// What shows in the window.
    pub(crate) ids: Vec<SampleId>,
    /// Places in the output's buffer of `wanted`, row-major, where they are to be blended.
    places: Vec<Option<u32>>,
}

/// Blended samples as numbers.
#[derive(Default)]
struct Mixed {
    places: Vec<u32>,
    /// All channels of a place side by side.
    values: Vec<f64>,
}

impl<const D: usize> Part<'_, D> {
    /// The patches that show in the window, in order.
    pub(crate) fn shown(&self) -> Vec<Shown<D>> {
        shown(self.laid.map, &self.window)
    }

    /// The samples that a patch has over a region of the window, and where they show: 1 there, else 0.
    pub(crate) fn of_patch(&self, patch: &Patch<D>, region: &Window<D>, own: &mut Vec<SampleId>, mask: &mut Vec<f64>) {
        self.laid.samples_of(patch, region, own);
        mask.clear();
        let width = region.shape[D - 1] as usize;
        for (row, own) in rows(&self.window, region).zip(own.chunks_exact(width)) {
            let pairs = own.iter().zip(&self.ids[row]);
            mask.extend(pairs.map(|(own, shown)| f64::from(u8::from(own.is_assigned() && own == shown))));
        }
    }

    /// Samples as numbers that may be averaged, a list a channel.
    pub(crate) fn numbers(&self, ids: &[SampleId], channels: &mut [Vec<f64>]) {
        for (c, channel) in channels.iter_mut().enumerate() {
            channel.resize(ids.len(), 0.0);
            self.payload.numbers(c, ids, channel);
        }
        self.averaging.weigh(channels);
    }

    /// Channels of the planes.
    pub(crate) fn channels(&self) -> usize {
        self.payload.planes()[0].samples.channels()
    }

    /// What is wanted of values over `wanted`, a list a channel, where `is_blended` says so of its places.
    fn mixed(&self, channels: &[Vec<f64>], is_blended: impl Fn(usize) -> bool) -> Mixed {
        let mut mixed = Mixed::default();
        let wanted = self.places.iter().enumerate().filter_map(|(i, place)| Some((i, (*place)?)));
        for (i, place) in wanted.filter(|&(i, _)| is_blended(i)) {
            mixed.places.push(place);
            mixed.values.extend(channels.iter().map(|c| c[i]));
        }
        mixed
    }
}

/// Numbers over [`Part::wanted`], a list a channel, and which of them are averages; all, where that is empty.
pub(crate) struct Blend {
    pub(crate) channels: Vec<Vec<f64>>,
    pub(crate) is_blended: Vec<bool>,
}

/// Renders a map, and what `blend` makes of the positions that have a seam within `reach` along every axis.
pub(crate) fn render<const D: usize>(
    laid: &MapView<'_, D>,
    planes: &[&Plane<D>],
    reach: u32,
    blend: impl Fn(&Part<'_, D>) -> Blend + Sync,
) -> Result<Plane<D>, Error> {
    let payload = Payload::new(&laid.map.table, planes)?;
    let mut plane = payload.gather(&laid.map.ids)?;
    let mut near = near_seams(laid.map, reach)?;
    if let Some(kept) = laid.kept {
        near.iter_mut().zip(kept.plane(0)).for_each(|(near, kept)| *near &= !kept);
    }
    let averaging = Averaging::of(planes);
    let boxes = boxes(laid.map.domain());
    for boxes in boxes.chunks(TOGETHER) {
        let mixed = par::map_indexed(boxes.len(), |i| {
            let part = part((laid, &payload, &averaging), &boxes[i], &near, reach)?;
            let Blend { channels, is_blended } = blend(&part);
            Some(part.mixed(&channels, |i| is_blended.is_empty() || is_blended[i]))
        });
        for Mixed { places, mut values } in mixed.into_iter().flatten() {
            for (&place, values) in places.iter().zip(values.chunks_mut(plane.samples.channels())) {
                averaging.set(&mut plane.samples, place as usize, values);
            }
        }
    }
    Ok(plane)
}

/// An upper bound of what [`render`] takes besides the planes and the output: marks of what is near seams, values of
/// boxes until they are written, and by thread what shows around a box and `working` bytes a sample of that.
pub(crate) fn bytes<const D: usize>(output: Domain<D>, channels: usize, reach: u32, working: u64) -> Bytes {
    let side = u64::from(side::<D>());
    let len = |sides: [u64; D]| sides.into_iter().fold(1, u64::saturating_mul);
    let all = len(output.shape.map(u64::from));
    let held = Bytes(len([side; D]).saturating_mul(TOGETHER as u64).min(all)) * (8 * channels as u64 + 4);
    let around = |a: usize| {
        // Around a periodic axis the same positions may come again.
        let around = side.min(output.shape[a].into()) + 2 * u64::from(reach);
        if output.periodic[a] { around } else { around.min(output.shape[a].into()) }
    };
    let one = Bytes::of_box::<D>(std::array::from_fn(around), working + 8);
    let boxes = all.div_ceil(len([side; D])).min(TOGETHER as u64).min(par::threads() as u64);
    Bytes(all) * 2 + held + one * boxes.max(1)
}

/// The side of a box of about [`BOX`] samples.
fn side<const D: usize>() -> u32 {
    (1..).take_while(|&n| u32::checked_pow(n, D as u32).is_some_and(|len| len <= BOX)).last().unwrap_or(1)
}

fn boxes<const D: usize>(output: Domain<D>) -> Vec<Window<D>> {
    let side = side::<D>();
    let boxes = Domain::open(output.shape.map(|n| n.div_ceil(side)));
    let window = |b: [u32; D]| Window {
        start: b.map(|v| (v * side) as i32),
        shape: std::array::from_fn(|a| side.min(output.shape[a] - b[a] * side)),
    };
    boxes.positions().map(window).collect()
}

/// What is to be blended in a box; `None` for nothing.
fn part<'a, const D: usize>(
    (laid, payload, averaging): (&'a MapView<'a, D>, &'a Payload<'a, D>, &'a Averaging),
    whole: &Window<D>,
    near: &[bool],
    reach: u32,
) -> Option<Part<'a, D>> {
    let output = laid.map.domain();
    let wanted = around_marks(whole, output, near)?;
    let places = wanted.places(output).map(|place| place.filter(|&p| near[p]).map(|p| p as u32)).collect();
    let window = laid.around(&wanted, reach);
    let ids = window.places(output).flatten().map(|place| laid.map.ids.plane(0)[place]).collect();
    Some(Part { laid, payload, averaging, wanted, window, ids, places })
}

/// The box around the marks in a window.
fn around_marks<const D: usize>(window: &Window<D>, output: Domain<D>, marks: &[bool]) -> Option<Window<D>> {
    let local = Domain::open(window.shape);
    let marked = window.places(output).enumerate().filter(|&(_, place)| place.is_some_and(|p| marks[p]));
    let ends = marked.map(|(i, _)| local.position(i)).fold(None, |ends: Option<[[u32; D]; 2]>, at| {
        let [low, high] = ends.unwrap_or([at; 2]);
        Some([std::array::from_fn(|a| low[a].min(at[a])), std::array::from_fn(|a| high[a].max(at[a]))])
    });
    let [low, high] = ends?;
    let start = std::array::from_fn(|a| window.start[a] + low[a] as i32);
    Some(Window { start, shape: std::array::from_fn(|a| high[a] - low[a] + 1) })
}
