//! Linking candidates of neighbouring rays into chains: the rule of continuity (see the Python module `_chain`).

use super::rays::Rays;
use super::scan::Candidates;

pub const STEEPEST: f64 = 2.0;
pub const SLACK: f64 = 1.0;
const LOOSE: f64 = 0.8;
pub const LONGEST_GAP: i64 = 3;
pub const SHORTEST: usize = 10;
pub const SLIGHT: f64 = 0.15;
/// Number of the chain of a candidate that is in none.
pub const NONE: usize = usize::MAX;

/// Ray, and position along it.
type Place = (i64, f64);

/// See the Python class `Chain`.
pub struct Chain {
    pub head: Place,
    pub tail: Place,
    pub members: usize,
    pub torn: bool,
}

/// The chains, and which of them each candidate belongs to; those that are not `laser` light to none.
pub fn link(candidates: &Candidates, laser: &[bool], rays: &Rays, slack: f64) -> (Vec<Chain>, Vec<usize>) {
    let room = Room { slack, steepest: STEEPEST * rays.spacing };
    let mut linking = Linking { room, stride: rays.stride, chains: Vec::new(), active: Vec::new() };
    let mut number = vec![NONE; candidates.peaks.len()];
    let mut peaks: Vec<(usize, f64, f64)> = Vec::new();
    for ray in 0..candidates.rays() {
        let range = candidates.of(ray);
        if range.len() == 1 && laser[range.start] && linking.goes_on(ray as i64, candidates.peaks[range.start].position) {
            number[range.start] = linking.active[0];
            continue;
        }
        peaks.clear();
        peaks.extend(range.filter(|&index| laser[index]).map(|index| {
            let peak = &candidates.peaks[index];
            (index, peak.position, peak.height)
        }));
        if !peaks.is_empty() {
            linking.extend(ray as i64, &peaks, &mut number);
        }
    }
    let mut chains = linking.chains;
    if rays.closed {
        join_ends(&mut chains, &mut number, candidates.rays() as i64, room);
    }
    (chains, number)
}

/// How far a peak of a line of `width` may jump for its noise.
pub fn slack_of(width: f64) -> f64 {
    SLACK.max(LOOSE * width)
}

/// How far a line may move along its rays: for its noise, and per ray.
#[derive(Clone, Copy)]
struct Room {
    slack: f64,
    steepest: f64,
}

impl Room {
    fn over(self, steps: i64) -> f64 {
        self.slack + self.steepest * steps as f64
    }
}

struct Linking {
    room: Room,
    stride: usize,
    chains: Vec<Chain>,
    active: Vec<usize>,
}

impl Linking {
    /// The chains continued by the `peaks` of a ray: (candidate, position, height), highest first.
    fn extend(&mut self, ray: i64, peaks: &[(usize, f64, f64)], number: &mut [usize]) {
        let chains = &self.chains;
        self.active.retain(|&c| ray - chains[c].tail.0 <= LONGEST_GAP + 1);
        let torn = self.tear(ray, peaks);
        for &(index, place, _) in peaks {
            let c = self.nearest(ray, place).unwrap_or_else(|| {
                self.chains.push(Chain { head: (ray, place), tail: (ray, place), members: 0, torn });
                self.active.push(self.chains.len() - 1);
                self.chains.len() - 1
            });
            self.chains[c].tail = (ray, place);
            self.chains[c].members += 1;
            number[index] = c;
        }
    }

    /// The usual ray, in short: whether its only peak, at `place`, continues the only active chain; if so, it does.
    fn goes_on(&mut self, ray: i64, place: f64) -> bool {
        let [c] = self.active[..] else { return false };
        let steps = ray - self.chains[c].tail.0;
        let continues = steps <= LONGEST_GAP + 1 && self.continues(c, ray, place);
        if continues {
            self.chains[c].tail = (ray, place);
            self.chains[c].members += 1;
        }
        continues
    }

    fn continues(&self, c: usize, ray: i64, place: f64) -> bool {
        let tail = self.chains[c].tail;
        (place - tail.1).abs() <= self.room.over(ray - tail.0)
    }

    /// Ends the chains long enough for a line that meet on this ray, or part; whether there are any.
    fn tear(&mut self, ray: i64, peaks: &[(usize, f64, f64)]) -> bool {
        if self.active.len() + peaks.len() < 3 {
            return false;
        }
        let long: Vec<usize> = self.active.iter().copied().filter(|&c| self.chains[c].members * self.stride >= SHORTEST).collect();
        let torn = |&c: &usize| {
            let mut own = peaks.iter().filter(|peak| self.continues(c, ray, peak.1));
            let meets = |peak: &(usize, f64, f64)| long.iter().any(|&d| d != c && self.continues(d, ray, peak.1));
            let (highest, next) = (own.next(), own.next());
            let parts = highest.zip(next).is_some_and(|(highest, next)| next.2 >= SLIGHT * highest.2);
            parts || highest.is_some_and(meets) || next.is_some_and(meets) || own.any(meets)
        };
        let torn: Vec<usize> = long.iter().copied().filter(torn).collect();
        torn.iter().for_each(|&c| self.chains[c].torn = true);
        self.active.retain(|c| !torn.contains(c));
        !torn.is_empty()
    }

    /// The active chain whose tail a candidate continues best.
    fn nearest(&self, ray: i64, place: f64) -> Option<usize> {
        let mut best = (f64::INFINITY, None);
        for &c in &self.active {
            let tail = self.chains[c].tail;
            let jump = (place - tail.1).abs();
            if tail.0 < ray && jump <= self.room.over(ray - tail.0) && jump < best.0 {
                best = (jump, Some(c));
            }
        }
        best.1
    }
}

/// Chains that meet where a closed scan begins and ends made one, each ending one with the first that continues it.
fn join_ends(chains: &mut [Chain], number: &mut [usize], rays: i64, room: Room) {
    let (mut name, mut taken): (Vec<usize>, Vec<usize>) = ((0..chains.len()).collect(), Vec::new());
    let early: Vec<usize> = (0..chains.len()).filter(|&d| chains[d].head.0 <= LONGEST_GAP).collect();
    for c in 0..chains.len() {
        let ending = &chains[c];
        if ending.tail.0 + LONGEST_GAP + 1 < rays {
            continue;
        }
        let (head, tail, members) = (ending.head, ending.tail, ending.members);
        let continued = early.iter().copied().find(|&d| {
            let steps = chains[d].head.0 + rays - tail.0;
            let jump = (tail.1 - chains[d].head.1).abs();
            d != c && !taken.contains(&d) && steps <= LONGEST_GAP + 1 && jump <= room.over(steps)
        });
        if let Some(d) = continued {
            chains[d].head = (head.0 - rays, head.1);
            chains[d].members += members;
            chains[c].members = 0;
            name[c] = d;
            taken.push(d);
        }
    }
    if !taken.is_empty() {
        number.iter_mut().filter(|c| **c != NONE).for_each(|c| *c = name[*c]);
    }
}
