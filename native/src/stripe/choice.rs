//! Which candidate on each ray is the line: the rule of the Python module `_choice`.

use super::chain::{link, slack_of, Chain, LONGEST_GAP, NONE, SHORTEST, SLIGHT};
use super::light::laser_light;
use super::path::{best_path, steps_between, MOST_CHAINS};
use super::rays::Rays;
use super::sampling::{Grey, Plane};
use super::scan::Candidates;
use super::statistics::median;

pub const OK: u8 = 0;
pub const RESOLVED: u8 = 1;
pub const SATURATED: u8 = 2;
pub const NO_PEAK: u8 = 3;
pub const MULTIPLE: u8 = 4;
pub const OFF_RING: u8 = 5;
pub const NOT_LASER: u8 = 6;

const UNSURE: f64 = 0.2;
/// Confidence of a chain that is not on the path.
const BESIDE: f64 = -1.0;

/// The chosen candidate of a ray, status and confidence; the first and last have no meaning where the status has no value.
#[derive(Clone, Copy)]
pub struct Choice {
    pub pick: usize,
    pub status: u8,
    pub confidence: f64,
}

/// What was chosen on each ray.
pub fn line_among<T: Grey>(plane: &Plane<T>, rays: &Rays, candidates: &Candidates, width: f64) -> Vec<Choice> {
    let laser = laser_light(plane, rays, candidates, width);
    let slack = slack_of(width);
    let (chains, number) = link(candidates, &laser, rays, slack);
    let may = |&c: &usize| is_long(&chains[c], rays.stride) || (chains[c].torn && chains[c].members > 0);
    let may: Vec<usize> = (0..chains.len()).filter(may).collect();
    let light = if may.len() > 1 { light_of(candidates, &number, chains.len(), rays.stride) } else { vec![1.0; chains.len()] };
    let confidence = confidences(&chains, &light, &most(may, &light), (rays, slack));
    let seen = Seen { candidates, number, confidence, long: chains.iter().map(|chain| is_long(chain, rays.stride)).collect() };
    (0..candidates.rays()).map(|ray| seen.on(ray)).collect()
}

fn is_long(chain: &Chain, stride: usize) -> bool {
    chain.members * stride >= SHORTEST
}

/// Light of the chains, in rays of clear line.
fn light_of(candidates: &Candidates, number: &[usize], chains: usize, stride: usize) -> Vec<f64> {
    let own = |ray: usize| candidates.of(ray).find(|&index| number[index] != NONE);
    let mut highest: Vec<f64> = (0..candidates.rays()).filter_map(|ray| own(ray).map(|index| candidates.peaks[index].height)).collect();
    let mut light = vec![0.0; chains];
    if highest.is_empty() {
        return light;
    }
    let usual = median(&mut highest);
    for (peak, &c) in candidates.peaks.iter().zip(number).filter(|(_, c)| **c != NONE) {
        light[c] += (peak.height / usual).min(1.0).sqrt();
    }
    light.iter_mut().for_each(|light| *light *= stride as f64);
    light
}

/// Those with most light of the chains that may be wall, in their order.
fn most(mut may: Vec<usize>, light: &[f64]) -> Vec<usize> {
    if may.len() > MOST_CHAINS {
        may.sort_by(|&a, &b| light[b].total_cmp(&light[a]));
        may.truncate(MOST_CHAINS);
        may.sort_unstable();
    }
    may
}

/// Confidence of every chain, below 0 of those beside the path.
fn confidences(chains: &[Chain], light: &[f64], kept: &[usize], (rays, slack): (&Rays, f64)) -> Vec<f64> {
    let mut confidence = vec![BESIDE; chains.len()];
    if kept.is_empty() {
        return confidence;
    }
    let (some, own): (Vec<&Chain>, Vec<f64>) = kept.iter().map(|&c| (&chains[c], light[c])).unzip();
    let path = best_path(&some, &own, rays, slack);
    for c in connected(&path.members, &some, rays) {
        let length = (some[c].members * rays.stride) as f64;
        confidence[kept[c]] = (path.gain[c] / own[c]).clamp(0.0, 1.0) * (length / (length + SHORTEST as f64));
    }
    confidence
}

/// Those `members` of a path which, with those that they are connected to, are long enough for a line.
fn connected(members: &[usize], chains: &[&Chain], rays: &Rays) -> Vec<usize> {
    let near = |a: usize, b: usize| steps_between(chains[a], chains[b], rays) <= LONGEST_GAP + 1;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (i, &c) in members.iter().enumerate() {
        match groups.last_mut() {
            Some(group) if near(members[i - 1], c) => group.push(c),
            _ => groups.push(vec![c]),
        }
    }
    if groups.len() > 1 && rays.closed && near(members[members.len() - 1], members[0]) {
        let last = groups.pop().unwrap_or_default();
        groups[0].extend(last);
    }
    let length = |group: &Vec<usize>| group.iter().map(|&c| chains[c].members).sum::<usize>() * rays.stride;
    groups.into_iter().filter(|group| length(group) >= SHORTEST).flatten().collect()
}

/// The candidates, the chain of each, and of the chains the confidence and whether they are long.
struct Seen<'a> {
    candidates: &'a Candidates,
    number: Vec<usize>,
    confidence: Vec<f64>,
    long: Vec<bool>,
}

impl Seen<'_> {
    fn on(&self, ray: usize) -> Choice {
        let range = self.candidates.of(ray);
        let nothing = |status| Choice { pick: range.start, status, confidence: 0.0 };
        if range.is_empty() {
            return nothing(NO_PEAK);
        }
        if range.len() == 1 && self.number[range.start] != NONE {
            let confidence = self.confidence[self.number[range.start]];
            return if confidence < UNSURE {
                Choice { pick: range.start, status: OFF_RING, confidence: confidence.max(0.0) }
            } else {
                Choice { pick: range.start, status: OK, confidence }
            };
        }
        let own = |index: &usize| self.number[*index] != NONE;
        let Some(highest) = range.clone().find(own) else { return nothing(NOT_LASER) };
        let slight = SLIGHT * self.candidates.peaks[highest].height;
        let Some(pick) = range.clone().filter(own).find(|&index| self.confidence[self.number[index]] >= 0.0) else {
            return nothing(OFF_RING);
        };
        let confidence = self.confidence[self.number[pick]];
        let counts = |index: usize| self.long[self.number[index]] || self.candidates.peaks[index].height >= slight;
        let rival = range.filter(own).any(|index| index != pick && counts(index));
        let status = match (confidence < UNSURE, rival) {
            (true, true) => MULTIPLE,
            (true, false) => OFF_RING,
            (false, true) => RESOLVED,
            (false, false) => OK,
        };
        Choice { pick, status, confidence }
    }
}
