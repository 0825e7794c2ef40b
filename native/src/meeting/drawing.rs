//! Monte Carlo for many pixels, on several threads.

use super::cone::Cone;
use super::dispatch::{threads, widest, Work};
use super::draws::{nominal, Pixel, Tally, BLOCK, SUMMARY};
use super::flat::Flat;
use super::lanes::LANES;
use super::mount::{Forward, Mount, SideFacing};
use super::random::Stream;
use super::rig::{Make, Rig};
use super::surface::{Kind, Surface};

/// Pixels that share the rigs in the cache, and numbers that they may keep.
const GROUP: usize = 16;
const KEPT: usize = 1 << 21;
/// Chunks of rigs that are worth a thread.
const TASK: usize = 512;

/// What every pixel is told. `rigs`: a row of parameters for each draw.
pub struct Plan<'a> {
    pub make: Make,
    pub parameters: &'a [f64],
    pub rigs: &'a [f64],
    pub seed: u64,
    /// None: no intervals.
    pub probability: Option<f64>,
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub branch: &'a [f64],
    pub noise: &'a [f64],
    pub direction: Option<[&'a [f64]; 2]>,
}

impl Plan<'_> {
    pub fn draws(&self) -> usize {
        self.rigs.len() / self.make.parameters()
    }

    fn pixel<S: Surface, M: Mount>(&self, rig: &Rig<S, M>, i: usize) -> Pixel {
        let one = |values: &[f64]| if let [one] = values { *one } else { values[i] };
        let pixel = Pixel {
            u: self.u[i],
            v: self.v[i],
            far: one(self.branch) > 0.0,
            noise: one(self.noise),
            direction: self.direction.map(|[u, v]| [u[i], v[i]]),
            near: [0.0; 2],
        };
        Pixel { near: nominal(&self.make, rig, &pixel), ..pixel }
    }
}

struct Making<'a, S, M> {
    make: &'a Make,
    rows: &'a [f64],
    rigs: &'a mut [Rig<S, M>],
}

impl<S: Surface, M: Mount> Work for Making<'_, S, M> {
    #[inline(always)]
    fn run(self) {
        for (rig, rows) in self.rigs.iter_mut().zip(self.rows.chunks(LANES * self.make.parameters())) {
            *rig = self.make.rig(rows);
        }
    }
}

struct Drawing<'a, S, M> {
    plan: &'a Plan<'a>,
    rigs: &'a [Rig<S, M>],
    same: &'a Rig<S, M>,
    from: usize,
    summaries: &'a mut [[f64; SUMMARY]],
    /// Where all radii and all axials of each pixel go, or nowhere.
    kept: &'a mut [f64],
}

impl<S: Surface, M: Mount> Work for Drawing<'_, S, M> {
    #[inline(always)]
    fn run(self) {
        let (plan, draws) = (self.plan, self.plan.draws());
        let group = (KEPT / draws.max(1)).clamp(1, GROUP);
        let room = if plan.probability.is_some() || !self.kept.is_empty() { self.rigs.len() * LANES } else { 0 };
        let mut values: Vec<[Vec<f64>; 2]> = (0..group).map(|_| [vec![0.0; room], vec![0.0; room]]).collect();
        let mut kept = self.kept.chunks_mut(draws.max(1));
        for (number, summaries) in self.summaries.chunks_mut(group).enumerate() {
            let from = self.from + number * group;
            let mut tallies: Vec<Tally> =
                (from..from + summaries.len()).map(|i| Tally::new(plan.pixel(self.same, i), Stream::new(plan.seed, i as u64))).collect();
            for (block, rigs) in self.rigs.chunks(BLOCK).enumerate() {
                for (tally, [radii, axials]) in tallies.iter_mut().zip(&mut values) {
                    let values = (room > 0).then_some([radii.as_mut_slice(), axials.as_mut_slice()]);
                    tally.add(&plan.make, rigs, block * BLOCK, values);
                }
            }
            for ((summary, tally), values) in summaries.iter_mut().zip(&tallies).zip(&mut values) {
                for (values, kept) in values.iter().zip(&mut kept) {
                    kept.copy_from_slice(&values[..draws]);
                }
                *summary = tally.summary(values, plan.probability);
            }
        }
    }
}

/// Fills a summary for each pixel, and `kept` with all its radii and then all its axials unless it is empty.
pub fn draw_all(plan: &Plan, summaries: &mut [[f64; SUMMARY]], kept: &mut [f64], wanted: usize) {
    match (plan.make.kind, plan.make.side_facing) {
        (Kind::Cone, false) => on_threads::<Cone, Forward>(plan, summaries, kept, wanted),
        (Kind::Cone, true) => on_threads::<Cone, SideFacing>(plan, summaries, kept, wanted),
        (_, false) => on_threads::<Flat, Forward>(plan, summaries, kept, wanted),
        (_, true) => on_threads::<Flat, SideFacing>(plan, summaries, kept, wanted),
    }
}

fn on_threads<S: Surface, M: Mount>(plan: &Plan, summaries: &mut [[f64; SUMMARY]], kept: &mut [f64], wanted: usize) {
    let same = plan.make.same::<S, M>(plan.parameters);
    let rigs = rigs_of(plan, same, wanted);
    let each = summaries.len().div_ceil(threads(wanted, summaries.len())).max(1);
    let mut kept = kept.chunks_mut((2 * plan.draws() * each).max(1));
    let (rigs, same) = (rigs.as_slice(), &same);
    std::thread::scope(|scope| {
        for (number, summaries) in summaries.chunks_mut(each).enumerate() {
            let kept = kept.next().unwrap_or_default();
            let work = Drawing { plan, rigs, same, from: number * each, summaries, kept };
            scope.spawn(move || widest(work));
        }
    });
}

fn rigs_of<S: Surface, M: Mount>(plan: &Plan, same: Rig<S, M>, wanted: usize) -> Vec<Rig<S, M>> {
    let chunks = plan.draws().div_ceil(LANES);
    let mut rigs = vec![same; chunks];
    let each = chunks.div_ceil(threads(wanted, chunks / TASK)).max(1);
    let rows = each * LANES * plan.make.parameters();
    std::thread::scope(|scope| {
        for (rigs, rows) in rigs.chunks_mut(each).zip(plan.rigs.chunks(rows)) {
            let work = Making { make: &plan.make, rows, rigs };
            scope.spawn(move || widest(work));
        }
    });
    rigs
}
