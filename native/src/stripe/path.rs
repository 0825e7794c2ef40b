//! The path of the wall round the ring: the sequence of whole chains that explains most of the light (see the Python module `_path`).

use super::chain::{Chain, LONGEST_GAP, STEEPEST};
use super::rays::Rays;

const JUMP: f64 = 8.0;
const GAP_JUMP: f64 = 2.0;
const LONGEST_COUNTED: f64 = 24.0;
const WANDER: f64 = 0.25;
const EDGE: f64 = 6.0;
/// Those with most light take part.
pub const MOST_CHAINS: usize = 32;

/// See the Python class `Path`.
pub struct Path {
    pub members: Vec<usize>,
    pub gain: Vec<f64>,
}

/// The wall among the `chains`, each of which holds `light`.
pub fn best_path(chains: &[&Chain], light: &[f64], rays: &Rays, slack: f64) -> Path {
    let count = chains.len();
    if count == 1 {
        return Path { members: vec![0], gain: vec![light[0]] };
    }
    let (mut light, mut head): (Vec<f64>, Vec<i64>) = (light.to_vec(), chains.iter().map(|chain| chain.head.0).collect());
    let turn = rays.rays.len() as i64;
    let firsts = if rays.closed { 0..count } else { count..count + 1 };
    if !rays.closed {
        // a chain of no light before all others stands for the ends of the line
        light.push(0.0);
        head.push(-1);
    }
    let cost = Costs::between(chains, light.len(), (rays, slack));
    let (mut best, mut members, mut without) = (0.0, Vec::new(), vec![0.0f64; light.len()]);
    let mut order: Vec<usize> = Vec::with_capacity(light.len());
    for first in firsts {
        let turned = |c: usize| if rays.closed { (head[c] - head[first]).rem_euclid(turn) } else { head[c] };
        order.clear();
        order.extend(0..light.len());
        order.sort_by_key(|&c| (c != first, turned(c), c));
        let round = Round::of(&order, &light, &cost);
        if round.light > best {
            (best, members) = (round.light, round.members.iter().map(|&i| order[i]).collect());
        }
        for (&c, &others) in order.iter().zip(&round.others) {
            without[c] = without[c].max(others);
        }
    }
    members.retain(|&c| c < count);
    Path { members, gain: without[..count].iter().map(|others| best - others).collect() }
}

/// Rays from the end of `a` to the beginning of `b`, the next time that it comes; less than 1 where both are seen.
pub fn steps_between(a: &Chain, b: &Chain, rays: &Rays) -> i64 {
    let turn = rays.rays.len() as i64;
    let mut ahead = b.head.0 - a.head.0;
    if rays.closed {
        ahead = ahead.rem_euclid(turn);
        if ahead == 0 && std::ptr::eq(a, b) {
            ahead = turn;
        }
    }
    ahead - (a.tail.0 - a.head.0)
}

/// What it costs that one chain follows another, row by row; infinite where it cannot.
struct Costs {
    cost: Vec<f64>,
    count: usize,
}

impl Costs {
    fn between(chains: &[&Chain], count: usize, (rays, slack): (&Rays, f64)) -> Costs {
        let mut cost = vec![0.0; count * count];
        for (i, a) in chains.iter().enumerate() {
            for (j, b) in chains.iter().enumerate() {
                cost[i * count + j] = cost_of(a, b, rays, slack);
            }
        }
        Costs { cost, count }
    }

    fn from(&self, a: usize, b: usize) -> f64 {
        self.cost[a * self.count + b]
    }
}

fn cost_of(a: &Chain, b: &Chain, rays: &Rays, slack: f64) -> f64 {
    let steps = steps_between(a, b, rays);
    if steps + b.tail.0 - b.head.0 <= 0 || (!rays.closed && b.head.0 <= a.head.0) {
        return f64::INFINITY;
    }
    if steps < 1 {
        let shared = (1 - steps) as f64 * rays.stride as f64;
        return JUMP + shared + (shared - EDGE).max(0.0);
    }
    let near = steps.min(LONGEST_GAP + 1);
    if (b.head.1 - a.tail.1).abs() <= slack + rays.spacing * (STEEPEST * near as f64 + WANDER * (steps - near) as f64) {
        return 0.0;
    }
    JUMP + GAP_JUMP * ((steps - 1) as f64 * rays.stride as f64).min(LONGEST_COUNTED)
}

/// The best path from the first chain in an order through those after it back to it, and the light of the best one that leaves out each;
/// chains by their places in the order.
struct Round {
    light: f64,
    members: Vec<usize>,
    others: Vec<f64>,
}

impl Round {
    fn of(order: &[usize], light: &[f64], cost: &Costs) -> Round {
        let count = order.len();
        let between = |i: usize, j: usize| cost.from(order[i], order[j]);
        let own = |i: usize| light[order[i]];
        let (mut forth, mut back, mut before) = (vec![own(0); count], vec![0.0; count], vec![0; count]);
        for j in 1..count {
            let mut reached = f64::NEG_INFINITY;
            for i in 0..j {
                if forth[i] - between(i, j) > reached {
                    (reached, before[j]) = (forth[i] - between(i, j), i);
                }
            }
            forth[j] = own(j) + reached;
        }
        for i in (0..count).rev() {
            back[i] = (i + 1..count).fold(-between(i, 0), |most, j| most.max(own(j) - between(i, j) + back[j]));
        }
        let ends: Vec<f64> = (0..count).map(|i| forth[i] - between(i, 0)).collect();
        let mut others = vec![f64::NEG_INFINITY; count];
        for i in 0..count {
            for j in i + 2..=count {
                let leap = if j == count { ends[i] } else { forth[i] - between(i, j) + own(j) + back[j] };
                others[i + 1..j].iter_mut().for_each(|most| *most = most.max(leap));
            }
        }
        let mut at = (1..count).fold(0, |best, i| if ends[i] > ends[best] { i } else { best });
        let (light, mut members) = (ends[at], Vec::new());
        while at > 0 {
            members.push(at);
            at = before[at];
        }
        members.push(0);
        members.reverse();
        Round { light, members, others }
    }
}
