//! Weights of parts, shared among their channels, as small whole numbers.

use crate::Error;

/// Weights of all channels, of which each part (a plane, a guide) has together the weight that is given with it,
/// however many channels it has, and shares it in the proportion of its own.
///
/// # Errors
/// [`Error::GuideWeight`], [`Error::GuideProportion`].
pub(crate) fn of_parts(parts: &[(f64, &[u8])]) -> Result<Vec<u8>, Error> {
    Ok(whole(&shares(parts)?))
}

/// Each channel's share of its part's weight.
fn shares(parts: &[(f64, &[u8])]) -> Result<Vec<f64>, Error> {
    if let Some(&(weight, _)) = parts.iter().find(|(w, _)| !w.is_finite() || *w < 0.0) {
        return Err(Error::GuideWeight { weight });
    }
    let most = parts.iter().map(|(weight, _)| *weight).fold(0.0, f64::max);
    if most == 0.0 {
        return Err(Error::GuideWeight { weight: 0.0 });
    }
    let mut shares = Vec::new();
    for (weight, channels) in parts {
        let own: f64 = channels.iter().map(|&w| f64::from(w)).sum();
        // A part that counts nowhere has no proportion.
        let share = |&w: &u8| if w == 0 { 0.0 } else { weight / most * (f64::from(w) / own) };
        // Numbers have no room for it.
        if *weight != 0.0 && channels.iter().any(|w| *w != 0 && share(w) < f64::MIN_POSITIVE) {
            return Err(Error::GuideProportion { weight: *weight, most });
        }
        shares.extend(channels.iter().map(share));
    }
    Ok(shares)
}

/// The smallest whole numbers in the proportion of `shares`; the largest becomes 255 where that takes rounding. What
/// is not 0 stays at least 1.
fn whole(shares: &[f64]) -> Vec<u8> {
    let most = shares.iter().copied().fold(0.0, f64::max);
    if most == 0.0 {
        return vec![0; shares.len()];
    }
    let scaled = |top: u8| shares.iter().map(move |s| s / most * f64::from(top));
    let exact = |&top: &u8| scaled(top).all(|w| (w - w.round()).abs() < 1e-9);
    let top = (1..=255).find(exact).unwrap_or(255);
    scaled(top).map(|w| if w == 0.0 { 0 } else { w.round().max(1.0) as u8 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_without_any_weight_of_their_own_count_nowhere() {
        assert_eq!(of_parts(&[(1.0, &[0, 0]), (2.0, &[3])]).unwrap(), [0, 0, 1]);
        assert_eq!(of_parts(&[(1.0, &[0])]).unwrap(), [0]);
    }
}
