//! KITTI's format: a PNG of 16 bits, across and down in 64ths around the middle, and whether the vector is known.

use std::path::Path;

use selvedge_core::{Flow, Grid, Samples};

use crate::error::Problem;
use crate::{Format, ReadOptions};

pub(super) fn decode(bytes: &[u8], name: &Path, options: &ReadOptions) -> Result<Flow, Problem> {
    let picture = crate::decode(bytes, name, options).map_err(|e| e.problem)?;
    let samples = match picture.plane.samples {
        Samples::U16(samples) if samples.channels() == 3 && picture.format == Format::Png => samples,
        other => {
            let found = format!("a PNG of {} channel(s), {}", other.channels(), other.depth().name());
            return Err(Problem::NotFlow { found });
        }
    };
    let mut by = Grid::try_filled(samples.domain(), 2, 0.0_f32)?;
    for (to, from) in [(0, 1), (1, 0)] {
        for (v, &stored) in by.plane_mut(to).iter_mut().zip(samples.plane(from)) {
            *v = (f32::from(stored) - 32_768.0) / 64.0;
        }
    }
    let known = samples.plane(2).iter().map(|&valid| valid != 0).collect();
    Ok(Flow { by, known: Some(Grid::from_vec(samples.domain(), 1, known)?) })
}
