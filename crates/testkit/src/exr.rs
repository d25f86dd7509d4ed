//! The plainest OpenEXR file: one part, scan lines, no compression. Written by hand, so that it depends on nobody's
//! encoder and tests of other writers and readers have something to hold against.

use selvedge_core::{Plane, Samples};

/// Bytes 0 to 7: the magic number, version 2, no flags.
const START: [u8; 8] = [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
/// Pixel types of the format.
const HALF: u32 = 1;
const FLOAT: u32 = 2;

/// A plane of half or float samples as an EXR file: channel `Y`, or `R`, `G`, `B` and perhaps `A`.
///
/// # Panics
/// If the samples are integers, or there are 2 or more than 4 channels.
pub fn to_exr(plane: &Plane<2>) -> Vec<u8> {
    let [height, width] = plane.domain().shape;
    let channels = channel_order(plane.samples.channels());
    let kind = match &plane.samples {
        Samples::F16(_) => HALF,
        Samples::F32(_) => FLOAT,
        other => panic!("an EXR has no samples of {}", other.depth().name()),
    };
    let mut file = START.to_vec();
    attribute(&mut file, "channels", "chlist", &channel_list(channels, kind));
    attribute(&mut file, "compression", "compression", &[0]);
    let window: Vec<u8> = [0, 0, width - 1, height - 1].into_iter().flat_map(u32::to_le_bytes).collect();
    attribute(&mut file, "dataWindow", "box2i", &window);
    attribute(&mut file, "displayWindow", "box2i", &window);
    attribute(&mut file, "lineOrder", "lineOrder", &[0]);
    attribute(&mut file, "pixelAspectRatio", "float", &1_f32.to_le_bytes());
    attribute(&mut file, "screenWindowCenter", "v2f", &[0; 8]);
    attribute(&mut file, "screenWindowWidth", "float", &1_f32.to_le_bytes());
    file.push(0);

    let rows: Vec<Vec<u8>> = (0..height).map(|y| row(plane, channels, y)).collect();
    let mut offset = file.len() as u64 + 8 * u64::from(height);
    for row in &rows {
        file.extend(offset.to_le_bytes());
        offset += 8 + row.len() as u64;
    }
    for (y, row) in (0_u32..).zip(rows) {
        file.extend(y.to_le_bytes());
        file.extend((row.len() as u32).to_le_bytes());
        file.extend(row);
    }
    file
}

/// Names and places of the channels in the order of the file, which is the alphabet's.
fn channel_order(channels: usize) -> &'static [(&'static str, usize)] {
    match channels {
        1 => &[("Y", 0)],
        3 => &[("B", 2), ("G", 1), ("R", 0)],
        4 => &[("A", 3), ("B", 2), ("G", 1), ("R", 0)],
        n => panic!("1, 3 or 4 channels wanted, {n} found"),
    }
}

fn attribute(file: &mut Vec<u8>, name: &str, kind: &str, value: &[u8]) {
    for text in [name, kind] {
        file.extend(text.as_bytes());
        file.push(0);
    }
    file.extend((value.len() as u32).to_le_bytes());
    file.extend(value);
}

fn channel_list(channels: &[(&str, usize)], kind: u32) -> Vec<u8> {
    let mut list = Vec::new();
    for (name, _) in channels {
        list.extend(name.as_bytes());
        list.push(0);
        // Type; four bytes of flags; one sample for each pixel along both axes.
        list.extend([kind, 0, 1, 1].into_iter().flat_map(u32::to_le_bytes));
    }
    list.push(0);
    list
}

fn row(plane: &Plane<2>, channels: &[(&str, usize)], y: u32) -> Vec<u8> {
    let width = plane.domain().shape[1] as usize;
    let span = y as usize * width..(y as usize + 1) * width;
    let mut bytes = Vec::new();
    for &(_, c) in channels {
        match &plane.samples {
            Samples::F16(g) => bytes.extend(g.plane(c)[span.clone()].iter().flat_map(|v| v.to_le_bytes())),
            Samples::F32(g) => bytes.extend(g.plane(c)[span.clone()].iter().flat_map(|v| v.to_le_bytes())),
            _ => unreachable!("checked by to_exr"),
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Role};

    #[test]
    fn rows_stand_where_the_table_says() {
        let grid =
            Grid::from_vec(Domain::open([2, 1]), 3, vec![1.0_f32, 2.0, 3.0, 4.0, -5.0, 6.0]).expect("six samples");
        let file = to_exr(&Plane::new(Role::Color, Samples::F32(grid)));
        let table = file.len() - 2 * (8 + 12) - 2 * 8;
        let place = u64::from_le_bytes(file[table + 8..table + 16].try_into().expect("8 bytes")) as usize;
        assert_eq!(file[place..place + 4], 1_u32.to_le_bytes(), "the second row's number");
        let blue_green_red: Vec<u8> = [6.0_f32, 4.0, 2.0].into_iter().flat_map(f32::to_le_bytes).collect();
        assert_eq!(file[place + 8..], blue_green_red);
    }
}
