//! Linear colours, their mixtures, and the way to 8-bit sRGB.

/// Linear red, green, blue; 1 is white.
pub(crate) type Rgb = [f64; 3];

/// The linear colour of an sRGB hex number such as `0xb5533c`.
pub(crate) fn hex(rgb: u32) -> Rgb {
    [16, 8, 0].map(|shift| decode(f64::from((rgb >> shift) & 0xff) / 255.0))
}

/// The colour `t` of the way from `a` to `b`.
pub(crate) fn blend(a: Rgb, b: Rgb, t: f64) -> Rgb {
    [0, 1, 2].map(|c| crate::noise::lerp(a[c], b[c], t))
}

/// `color` times `k`.
pub(crate) fn scaled(color: Rgb, k: f64) -> Rgb {
    color.map(|v| v * k)
}

/// The colour at `t` in `0..=1` along the list, mixed between neighbours.
pub(crate) fn along(stops: &[Rgb], t: f64) -> Rgb {
    let at = t.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let i = (at as usize).min(stops.len().saturating_sub(2));
    blend(stops[i], stops[(i + 1).min(stops.len() - 1)], at - i as f64)
}

/// Linear light to an 8-bit sRGB sample; a soft shoulder keeps highlights from clipping.
pub(crate) fn encode(linear: f64) -> u8 {
    let v = linear.max(0.0);
    let v = if v > 0.7 { 0.7 + 0.3 * (1.0 - libm::exp(-(v - 0.7) / 0.3)) } else { v };
    let v = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
    (v * 255.0).round().clamp(0.0, 255.0) as u8
}

fn decode(v: f64) -> f64 {
    if v <= 0.040_45 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }
}
