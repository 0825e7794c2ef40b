//! Where a line that is no Gaussian has its place: nearer to where it is brightest (see the Python module `_anchor`).

use super::noise::NORMAL;
use super::statistics::median;

const BLOCK: f64 = 12.0;
const SHORTEST_BLOCK: usize = 8;
const FEWEST_BLOCKS: usize = 8;
const CERTAIN: f64 = 4.0;
const HALF: f64 = 0.5;
const ASTRAY: f64 = 6.0;
/// Standard deviation of a median over that of a mean.
const OF_MEDIAN: f64 = 1.2533;

/// How far the first look lies beside the second on all of the line, and how many standard uncertainties it may on one ray.
pub struct Anchor {
    pub aside: f64,
    pub astray: f64,
}

/// From the places `first` and `second`, of standard uncertainty `u`, of the rays that are `calm`.
pub fn anchor(first: &[f64], (second, u): (&[f64], &[f64]), calm: &[bool], width: f64, spacing: f64) -> Anchor {
    let off: Vec<f64> = first.iter().zip(second).zip(calm).map(|((a, b), calm)| if *calm { a - b } else { f64::NAN }).collect();
    let block = ((BLOCK * width / spacing) as usize).max(SHORTEST_BLOCK);
    let mean = |some: &[f64]| {
        let known: Vec<f64> = some.iter().copied().filter(|off| !off.is_nan()).collect();
        (2 * known.len() >= block).then(|| known.iter().sum::<f64>() / known.len() as f64)
    };
    let blocks: Vec<f64> = off.chunks(block).filter_map(mean).collect();
    if blocks.len() < FEWEST_BLOCKS {
        return Anchor { aside: 0.0, astray: f64::INFINITY };
    }
    let middle = median(&mut blocks.clone());
    let about =
        |values: &[f64]| NORMAL * median(&mut values.iter().filter(|v| !v.is_nan()).map(|v| (v - middle).abs()).collect::<Vec<f64>>());
    let doubt = about(&blocks) * (CERTAIN * OF_MEDIAN / (blocks.len() as f64).sqrt()).max(1.0);
    let part = if middle == 0.0 { 0.0 } else { (1.0 - (doubt / middle).powi(2)).max(0.0) };
    let mut parts: Vec<f64> = off.iter().zip(u).map(|(off, u)| (off - middle).abs() / u).filter(|part| !part.is_nan()).collect();
    Anchor { aside: HALF * middle * part, astray: ASTRAY * NORMAL * median(&mut parts) }
}
