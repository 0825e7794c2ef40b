//! Monte Carlo for many pixels, on several threads.

use super::cone::Cone;
use super::dispatch::{threads, widest, Work};
use super::draws::{nominal, Pixel, Rigs, Tally, BLOCK, SUMMARY};
use super::flat::Flat;
use super::lanes::LANES;
use super::random::Stream;
use super::rig::{Kind, Make, Numbers};
use super::surface::Surface;

/// Pixels that share the rigs in the cache, and numbers that they may keep.
const GROUP: usize = 16;
const KEPT: usize = 1 << 21;

/// What every pixel is told.
pub struct Plan<'a> {
    pub make: Make,
    pub numbers: Numbers,
    pub rigs: Rigs,
    pub draws: usize,
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
    fn pixel<S: Surface>(&self, i: usize) -> Pixel {
        let one = |values: &[f64]| if let [one] = values { *one } else { values[i] };
        let pixel = Pixel {
            u: self.u[i],
            v: self.v[i],
            far: one(self.branch) > 0.0,
            noise: one(self.noise),
            direction: self.direction.map(|[u, v]| [u[i], v[i]]),
            near: [0.0; 2],
        };
        Pixel { near: nominal::<S>(&self.make, &self.numbers, &pixel), ..pixel }
    }
}

struct Drawing<'a, S> {
    plan: &'a Plan<'a>,
    from: usize,
    summaries: &'a mut [[f64; SUMMARY]],
    /// Where all radii and all axials of each pixel go, or nowhere.
    draws: &'a mut [f64],
    surface: std::marker::PhantomData<S>,
}

impl<S: Surface> Work for Drawing<'_, S> {
    #[inline(always)]
    fn run(self) {
        let plan = self.plan;
        let chunks = plan.rigs.surface.len();
        let group = (KEPT / (chunks * LANES).max(1)).clamp(1, GROUP);
        let room = if plan.probability.is_some() || !self.draws.is_empty() { chunks * LANES } else { 0 };
        for (number, summaries) in self.summaries.chunks_mut(group).enumerate() {
            let from = self.from + number * group;
            let mut kept: Vec<[Vec<f64>; 2]> = summaries.iter().map(|_| [vec![0.0; room], vec![0.0; room]]).collect();
            let mut tallies: Vec<Tally> =
                (from..from + summaries.len()).map(|i| Tally::new(plan.pixel::<S>(i), Stream::new(plan.seed, i as u64))).collect();
            for block in (0..chunks).step_by(BLOCK) {
                for (tally, [radii, axials]) in tallies.iter_mut().zip(&mut kept) {
                    let kept = (room > 0).then_some([radii.as_mut_slice(), axials.as_mut_slice()]);
                    tally.add::<S>(&plan.make, &plan.rigs, block, (block + BLOCK).min(chunks), kept);
                }
            }
            for (kept, draws) in kept.iter().zip(self.draws.chunks_mut((2 * plan.draws).max(1)).skip(number * group)) {
                for (values, draws) in kept.iter().zip(draws.chunks_mut(plan.draws.max(1))) {
                    draws.copy_from_slice(&values[..plan.draws]);
                }
            }
            for ((summary, tally), [radii, axials]) in summaries.iter_mut().zip(&tallies).zip(&mut kept) {
                *summary = match plan.probability {
                    Some(probability) => tally.summary(Some([radii, axials]), probability),
                    None => tally.summary(None, 0.0),
                };
            }
        }
    }
}

/// Fills a summary for each pixel, and `draws` with all its radii and then all its axials unless it is empty.
pub fn draw_all(plan: &Plan, summaries: &mut [[f64; SUMMARY]], draws: &mut [f64], wanted: usize) {
    match plan.make.kind {
        Kind::Cone => on_threads::<Cone>(plan, summaries, draws, wanted),
        Kind::Plane | Kind::Sheet | Kind::Beam => on_threads::<Flat>(plan, summaries, draws, wanted),
    }
}

fn on_threads<S: Surface>(plan: &Plan, summaries: &mut [[f64; SUMMARY]], draws: &mut [f64], wanted: usize) {
    let count = threads(wanted, summaries.len());
    let each = summaries.len().div_ceil(count).max(1);
    let mut draws = draws.chunks_mut((2 * plan.draws * each).max(1));
    std::thread::scope(|scope| {
        for (number, summaries) in summaries.chunks_mut(each).enumerate() {
            let draws = draws.next().unwrap_or_default();
            let work = Drawing { plan, from: number * each, summaries, draws, surface: std::marker::PhantomData::<S> };
            scope.spawn(move || widest(work));
        }
    });
}
