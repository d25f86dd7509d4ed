//! Planes of random samples.

use selvedge_core::{Depth, Domain, Grid, Plane, Role, Samples, Seed};
use selvedge_io::{Fingerprint, Metadata, Provenance};

/// Random samples; floats finite, of any sign and size, zeros of both signs and subnormals among them.
pub(crate) fn plane(depth: Depth, colors: usize, alpha: bool, shape: [u32; 2]) -> Plane<2> {
    let domain = Domain::open(shape);
    let channels = colors + usize::from(alpha);
    let n = domain.len() * channels;
    let mut rng = Seed(1).derive(depth.name(), channels as u64).rng();
    let mut word = || rng.below(65_536) as u16;
    let samples = match depth {
        Depth::U8 => Samples::U8(Grid::from_vec(domain, channels, (0..n).map(|_| word() as u8).collect()).unwrap()),
        Depth::U16 => Samples::U16(Grid::from_vec(domain, channels, (0..n).map(|_| word()).collect()).unwrap()),
        Depth::F16 => {
            // All exponents but the one of infinities.
            let bits = (0..n).map(|_| word()).map(|b| if b & 0x7c00 == 0x7c00 { b & 0x83ff } else { b });
            Samples::F16(Grid::from_vec(domain, channels, bits.collect()).unwrap())
        }
        Depth::F32 => {
            let bits = (0..n).map(|_| u32::from(word()) << 16 | u32::from(word()));
            let finite = bits.map(f32::from_bits).map(|v| if v.is_finite() { v } else { -0.0 });
            Samples::F32(Grid::from_vec(domain, channels, finite.collect()).unwrap())
        }
    };
    Plane { alpha, ..Plane::new(Role::Color, samples) }
}

/// The samples' bits: floats that are equal may still differ in them.
pub(crate) fn bits(plane: &Plane<2>) -> Vec<u32> {
    match &plane.samples {
        Samples::U8(g) => g.samples().iter().map(|v| u32::from(*v)).collect(),
        Samples::U16(g) | Samples::F16(g) => g.samples().iter().map(|v| u32::from(*v)).collect(),
        Samples::F32(g) => g.samples().iter().map(|v| v.to_bits()).collect(),
    }
}

pub(crate) fn profile(space: &[u8; 4]) -> Vec<u8> {
    let mut profile = vec![7; 200];
    profile[16..20].copy_from_slice(space);
    profile
}

pub(crate) fn made() -> Metadata {
    let provenance = Provenance {
        version: "0.1.0".into(),
        seed: 7,
        inputs: vec![Fingerprint { name: "brick é.png".into(), blake3: "0123456789abcdef".into() }],
        command: "selvedge quilt 'brick é.png' --size 64".into(),
    };
    Metadata { provenance: Some(provenance), ..Metadata::default() }
}
