//! Linking candidates of neighbouring rays into chains: the rule of continuity (see the Python module `_chain`).

use super::scan::Candidates;

pub const STEEPEST: f64 = 2.0;
pub const SLACK: f64 = 1.0;
const LONGEST_GAP: usize = 3;

struct Chain {
    head: (usize, f64),
    tail: (usize, f64),
    members: usize,
}

fn allowed(spacing: f64, steps: usize) -> f64 {
    SLACK + STEEPEST * spacing * steps as f64
}

/// Length in rays of the chain each candidate belongs to; 0 for those that are not `laser` light.
pub fn lengths(candidates: &Candidates, laser: &[bool], spacing: f64, closed: bool) -> Vec<usize> {
    let mut chains: Vec<Chain> = Vec::new();
    let mut member = vec![usize::MAX; candidates.peaks.len()];
    let mut active: Vec<usize> = Vec::new();
    for ray in 0..candidates.rays() {
        active.retain(|&c| ray - chains[c].tail.0 <= LONGEST_GAP + 1);
        for index in candidates.of(ray).filter(|&index| laser[index]) {
            let place = candidates.peaks[index].position;
            let c = nearest(place, ray, &active, &chains, spacing).unwrap_or_else(|| {
                chains.push(Chain { head: (ray, place), tail: (ray, place), members: 0 });
                active.push(chains.len() - 1);
                chains.len() - 1
            });
            chains[c].tail = (ray, place);
            chains[c].members += 1;
            member[index] = c;
        }
    }
    let root = if closed { join_ends(&chains, spacing, candidates.rays()) } else { (0..chains.len()).collect() };
    let mut length = vec![0; chains.len()];
    for (c, chain) in chains.iter().enumerate() {
        length[root[c]] += chain.members;
    }
    member.iter().map(|&c| root.get(c).map_or(0, |&r| length[r])).collect()
}

/// The active chain whose tail a candidate continues best.
fn nearest(place: f64, ray: usize, active: &[usize], chains: &[Chain], spacing: f64) -> Option<usize> {
    let mut best = (f64::INFINITY, None);
    for &c in active {
        let steps = ray - chains[c].tail.0;
        let jump = (place - chains[c].tail.1).abs();
        if steps > 0 && jump <= allowed(spacing, steps) && jump < best.0 {
            best = (jump, Some(c));
        }
    }
    best.1
}

/// Chain numbers after joining chains that meet where a closed scan begins and ends.
fn join_ends(chains: &[Chain], spacing: f64, rays: usize) -> Vec<usize> {
    let mut root: Vec<usize> = (0..chains.len()).collect();
    for (c, ending) in chains.iter().enumerate().filter(|(_, chain)| chain.tail.0 + LONGEST_GAP + 1 >= rays) {
        for (d, beginning) in chains.iter().enumerate() {
            let steps = beginning.head.0 + rays - ending.tail.0;
            let jump = (ending.tail.1 - beginning.head.1).abs();
            if steps <= LONGEST_GAP + 1 && jump <= allowed(spacing, steps) {
                let (old, new) = (root[c], root[d]);
                root.iter_mut().filter(|r| **r == old).for_each(|r| *r = new);
            }
        }
    }
    root
}
