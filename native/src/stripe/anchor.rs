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

/// From the places `first` and `second`, of standard uncertainty `u`, of the rays that are `calm`; where the top is `hidden` (nowhere where that
/// is empty), no look has seen it.
pub fn anchor(first: &[f64], (second, u): (&[f64], &[f64]), calm: &[bool], hidden: &[bool], (width, spacing): (f64, f64)) -> Anchor {
    let mut off: Vec<f64> = first.iter().zip(second).zip(calm).map(|((a, b), calm)| if *calm { a - b } else { f64::NAN }).collect();
    let about = |values: &[f64], middle: f64| {
        NORMAL * median(&mut values.iter().filter(|v| !v.is_nan()).map(|v| (v - middle).abs()).collect::<Vec<f64>>())
    };
    let beside = |values: &[f64], middle: f64| {
        let mut parts: Vec<f64> = values.iter().zip(u).map(|(off, u)| (off - middle).abs() / u).filter(|part| !part.is_nan()).collect();
        ASTRAY * NORMAL * median(&mut parts)
    };
    let all = hidden.contains(&true).then(|| off.clone());
    off.iter_mut().zip(hidden).filter(|(_, hidden)| **hidden).for_each(|(off, _)| *off = f64::NAN);
    let block = ((BLOCK * width / spacing) as usize).max(SHORTEST_BLOCK);
    let mean = |some: &[f64]| {
        let known: Vec<f64> = some.iter().copied().filter(|off| !off.is_nan()).collect();
        (2 * known.len() >= block).then(|| known.iter().sum::<f64>() / known.len() as f64)
    };
    let blocks: Vec<f64> = off.chunks(block).filter_map(mean).collect();
    if blocks.len() < FEWEST_BLOCKS {
        let mut known: Vec<f64> = all.iter().flatten().copied().filter(|off| !off.is_nan()).collect();
        let astray = if known.is_empty() { f64::INFINITY } else { beside(all.as_ref().unwrap_or(&off), median(&mut known)) };
        return Anchor { aside: 0.0, astray };
    }
    let middle = median(&mut blocks.clone());
    let doubt = about(&blocks, middle) * (CERTAIN * OF_MEDIAN / (blocks.len() as f64).sqrt()).max(1.0);
    let part = if middle == 0.0 { 0.0 } else { (1.0 - (doubt / middle).powi(2)).max(0.0) };
    Anchor { aside: HALF * middle * part, astray: beside(all.as_ref().unwrap_or(&off), middle) }
}
