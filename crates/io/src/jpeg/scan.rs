//! Scans: the coefficients of some components, all at once or bit by bit [B.2.3, F.2, G.2].

use super::components::Component;
use super::damaged;
use super::entropy::{Bits, Huffman};
use super::frame::{Frame, Tables, ZIGZAG};
use crate::error::Problem;

/// One component in a scan.
struct Part<'t> {
    /// Its place in the frame.
    place: usize,
    dc: Option<&'t Huffman>,
    ac: Option<&'t Huffman>,
    /// The last DC coefficient.
    predicted: i32,
}

/// Which bits of which coefficients a scan holds.
#[derive(Clone, Copy)]
struct Band {
    first: usize,
    last: usize,
    /// Whether bits were sent before, and how many are still to come.
    again: bool,
    low: u32,
}

/// Reads the scan whose header is `segment` and whose data begin at `at`; where it ends.
pub(super) fn read(
    frame: &mut Frame,
    tables: &Tables,
    segment: &[u8],
    bytes: &[u8],
    at: usize,
) -> Result<usize, Problem> {
    let (mut parts, band) = header(frame, tables, segment)?;
    let mut bits = Bits::new(bytes, at);
    // Units without coefficients that are still to come [G.1.2.2].
    let mut empty = 0;
    let only = if let [part] = &parts[..] { Some(part.place) } else { None };
    // A scan of one component has its own blocks alone, one of several whole units of all [A.2].
    let [down, across] = match only {
        Some(place) => frame.components[place].blocks,
        None => [0, 1].map(|axis| [frame.height, frame.width][axis].div_ceil(8 * frame.most[axis])),
    };
    let (mut units, mut restarts) = (0, 0);
    for (y, x) in (0..down).flat_map(|y| (0..across).map(move |x| (y, x))) {
        if tables.restart_interval != 0 && units == tables.restart_interval {
            bits.restart(restarts)?;
            (units, empty, restarts) = (0, 0, restarts.wrapping_add(1));
            parts.iter_mut().for_each(|part| part.predicted = 0);
        }
        units += 1;
        for part in &mut parts {
            let component = &mut frame.components[part.place];
            let [tall, wide] = if only.is_some() { [1; 2] } else { component.factors };
            for (dy, dx) in (0..tall).flat_map(|dy| (0..wide).map(move |dx| (dy, dx))) {
                let at = [y * tall + dy, x * wide + dx];
                if frame.progressive {
                    progress(component.block_mut(at)?, part, band, &mut empty, &mut bits)?;
                } else {
                    let mut block = [0; 64];
                    sequential(&mut block, part, &mut bits)?;
                    component.put(at, &block)?;
                }
            }
        }
    }
    for part in parts {
        let missing = &mut frame.components[part.place].missing;
        missing[band.first..=band.last].fill(band.low as u8);
    }
    Ok(bits.at())
}

fn header<'t>(frame: &mut Frame, tables: &'t Tables, segment: &[u8]) -> Result<(Vec<Part<'t>>, Band), Problem> {
    let wrong = || damaged("a scan header");
    let (&count, rest) = segment.split_first().ok_or_else(wrong)?;
    let (listed, rest) = rest.split_at_checked(2 * usize::from(count)).ok_or_else(wrong)?;
    let [first, last, bits, ..] = *rest else { return Err(wrong()) };
    let band = if frame.progressive {
        Band { first: first.into(), last: last.into(), again: bits >> 4 != 0, low: u32::from(bits & 15) }
    } else {
        Band { first: 0, last: 63, again: false, low: 0 }
    };
    let apart = !frame.progressive || if band.first == 0 { band.last == 0 } else { count == 1 };
    if count == 0 || !apart || band.last < band.first || 63 < band.last || 13 < band.low {
        return Err(wrong());
    }
    let mut parts: Vec<Part<'t>> = Vec::new();
    for [id, places] in listed.as_chunks::<2>().0 {
        let place = frame.components.iter().position(|c| c.id == *id).ok_or_else(wrong)?;
        let table = |class: usize, place: u8| tables.huffman[class].get(usize::from(place)).and_then(Option::as_ref);
        let (dc, ac) = (table(0, places >> 4), table(1, places & 15));
        let needs = [band.first == 0 && !band.again, 0 < band.last];
        if needs[0] && dc.is_none() || needs[1] && ac.is_none() || parts.iter().any(|p| p.place == place) {
            return Err(damaged("a scan without its tables"));
        }
        ready(&mut frame.components[place], tables, band, frame.progressive)?;
        parts.push(Part { place, dc, ac, predicted: 0 });
    }
    Ok((parts, band))
}

/// A component keeps the quantization table that is there when its first scan begins; progress has to be in order.
fn ready(component: &mut Component, tables: &Tables, band: Band, progressive: bool) -> Result<(), Problem> {
    if component.quantization.is_none() {
        let table = tables.quantization[usize::from(component.table)];
        component.quantization = Some(table.ok_or_else(|| damaged("a quantization table is missing"))?);
    }
    let before = &component.missing[band.first..=band.last];
    let in_order = if band.again { before.iter().all(|m| u32::from(*m) == band.low + 1) } else { true };
    if progressive && (!in_order || (0 < band.first && component.missing[0] == u8::MAX)) {
        return Err(damaged("scans out of order"));
    }
    Ok(())
}

/// All coefficients of a block [F.2.2].
fn sequential(block: &mut [i16; 64], part: &mut Part<'_>, bits: &mut Bits<'_>) -> Result<(), Problem> {
    let (Some(dc), Some(ac)) = (part.dc, part.ac) else { return Err(damaged("a scan without its tables")) };
    block[0] = difference(part, dc, bits)? as i16;
    let mut k = 1;
    while k < 64 {
        let symbol = bits.symbol(ac)?;
        let (run, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
        if size == 0 {
            if run != 15 {
                break;
            }
            k += 16;
            continue;
        }
        k += run;
        let at = ZIGZAG.get(k).ok_or_else(|| damaged("a block of too many coefficients"))?;
        block[usize::from(*at)] = bits.signed(size)? as i16;
        k += 1;
    }
    Ok(())
}

/// The next DC coefficient.
fn difference(part: &mut Part<'_>, dc: &Huffman, bits: &mut Bits<'_>) -> Result<i32, Problem> {
    let size = bits.symbol(dc)?;
    if 15 < size {
        return Err(damaged("a coefficient of too many bits"));
    }
    part.predicted = part.predicted.wrapping_add(bits.signed(size.into())?);
    Ok(part.predicted)
}

/// Some bits of a block's coefficients [G.2].
fn progress(
    block: &mut [i16; 64],
    part: &mut Part<'_>,
    band: Band,
    empty: &mut u32,
    bits: &mut Bits<'_>,
) -> Result<(), Problem> {
    match (band.first, band.again, part.dc, part.ac) {
        (0, false, Some(dc), _) => block[0] = (difference(part, dc, bits)? << band.low) as i16,
        (0, true, ..) => block[0] |= (bits.bits(1)? << band.low) as i16,
        (_, false, _, Some(ac)) => first_bits(block, ac, band, empty, bits)?,
        (_, true, _, Some(ac)) => next_bits(block, ac, band, empty, bits)?,
        _ => return Err(damaged("a scan without its tables")),
    }
    Ok(())
}

fn first_bits(
    block: &mut [i16; 64],
    ac: &Huffman,
    band: Band,
    empty: &mut u32,
    bits: &mut Bits<'_>,
) -> Result<(), Problem> {
    if 0 < *empty {
        *empty -= 1;
        return Ok(());
    }
    let mut k = band.first;
    while k <= band.last {
        let symbol = bits.symbol(ac)?;
        let (run, size) = (u32::from(symbol >> 4), u32::from(symbol & 15));
        if size == 0 && run < 15 {
            *empty = (1 << run) - 1 + bits.bits(run)? as u32;
            break;
        }
        k += run as usize;
        if size != 0 {
            let at = ZIGZAG.get(k).ok_or_else(|| damaged("a block of too many coefficients"))?;
            block[usize::from(*at)] = (bits.signed(size)? << band.low) as i16;
        }
        k += 1;
    }
    Ok(())
}

/// One more bit of every coefficient that is not 0, and those that become so [G.1.2.3].
fn next_bits(
    block: &mut [i16; 64],
    ac: &Huffman,
    band: Band,
    empty: &mut u32,
    bits: &mut Bits<'_>,
) -> Result<(), Problem> {
    let mut k = band.first;
    if *empty == 0 {
        while k <= band.last {
            let symbol = bits.symbol(ac)?;
            let (run, size) = (usize::from(symbol >> 4), symbol & 15);
            let value = match size {
                0 if run < 15 => {
                    *empty = (1 << run) + bits.bits(run as u32)? as u32;
                    break;
                }
                0 => 0,
                1 => {
                    if bits.bits(1)? == 1 {
                        1 << band.low
                    } else {
                        -1 << band.low
                    }
                }
                _ => return Err(damaged("a coefficient of too many bits")),
            };
            k = refine(block, k, band, Some(run), bits)?;
            if value != 0 {
                let at = ZIGZAG.get(k).filter(|_| k <= band.last);
                block[usize::from(*at.ok_or_else(|| damaged("a block of too many coefficients"))?)] = value;
            }
            k += 1;
        }
    }
    if 0 < *empty {
        refine(block, k, band, None, bits)?;
        *empty -= 1;
    }
    Ok(())
}

/// Refines coefficients from the `k`th on, up to the one after `zeros` that are 0; where it came to.
fn refine(
    block: &mut [i16; 64],
    mut k: usize,
    band: Band,
    mut zeros: Option<usize>,
    bits: &mut Bits<'_>,
) -> Result<usize, Problem> {
    while k <= band.last {
        let value = &mut block[usize::from(ZIGZAG[k])];
        if *value == 0 {
            match &mut zeros {
                Some(0) => break,
                Some(left) => *left -= 1,
                None => {}
            }
        } else if bits.bits(1)? == 1 {
            *value = value.wrapping_add(value.signum() << band.low);
        }
        k += 1;
    }
    Ok(k)
}
