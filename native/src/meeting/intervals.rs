//! Coverage intervals of draws: the twin of `calibore.uncertainty._intervals`, which sorts no more than the tails.

/// Low and high end of the symmetric interval, median, low and high end of the shortest interval; NaN where draws are too few.
pub fn intervals(values: &mut [f64], probability: f64) -> [f64; 5] {
    let count = values.len();
    if count == 0 {
        return [f64::NAN; 5];
    }
    let inside = (probability * count as f64).round_ties_even() as usize;
    let tail = count - inside.min(count);
    order(values, tail);
    let (low, high) = ((1.0 - probability) / 2.0, (1.0 + probability) / 2.0);
    let symmetric = [quantile(values, low), quantile(values, high)];
    let shortest = shortest(values, inside, tail);
    [symmetric[0], symmetric[1], quantile(values, 0.5), shortest[0], shortest[1]]
}

/// Puts the `tail` least, the `tail` greatest and the middle ones of `values` where sorting would put them.
fn order(values: &mut [f64], tail: usize) {
    let count = values.len();
    if tail == 0 || 2 * tail + 4 >= count {
        values.sort_unstable_by(f64::total_cmp);
        return;
    }
    values.select_nth_unstable_by(tail, f64::total_cmp);
    values[..tail].sort_unstable_by(f64::total_cmp);
    values[tail..].select_nth_unstable_by(count - 2 * tail, f64::total_cmp);
    values[count - tail..].sort_unstable_by(f64::total_cmp);
    let middle = (count - 1) / 2;
    let (_, _, above) = values[tail..count - tail].select_nth_unstable_by(middle - tail, f64::total_cmp);
    above.select_nth_unstable_by(0, f64::total_cmp);
}

/// By Hazen's rule, of values in order there.
fn quantile(values: &[f64], probability: f64) -> f64 {
    let last = (values.len() - 1) as f64;
    let place = (probability * values.len() as f64 - 0.5).clamp(0.0, last);
    let below = place.floor();
    let (a, b) = (values[below as usize], values[(below + 1.0).min(last) as usize]);
    a + (b - a) * (place - below)
}

fn shortest(values: &[f64], inside: usize, tail: usize) -> [f64; 2] {
    let mut best = [f64::NAN; 2];
    if inside == 0 {
        return best;
    }
    for start in 0..tail {
        let (low, high) = (values[start], values[start + inside]);
        if start == 0 || high - low < best[1] - best[0] {
            best = [low, high];
        }
    }
    best
}
