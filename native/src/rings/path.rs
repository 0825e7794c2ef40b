//! Which meeting of each ray with a cone is the wall: the twin of `calibore.rigs.follow_stripe`, of a closed stripe.

use crate::meeting::fold::Candidates;

const EXISTS: f64 = 1e6;
const NOWHERE: f64 = 2e6;
const PRIOR: f64 = 0.02;
const EDGE: f64 = 0.1;
const BOTH: [usize; 2] = [0, 1];

/// 0 for the near meeting of a ray, 1 for the far one.
pub fn follow(found: &Candidates, prior: f64) -> Vec<f64> {
    let n = found.radius[0].len();
    let ahead = |k: usize, i: usize| found.radius[k][i] > 0.0;
    let cost = |k: usize, i: usize| match (ahead(k, i), found.exists[k][i]) {
        (true, _) => (found.radius[k][i] / prior).ln().abs(),
        (false, true) => EXISTS,
        (false, false) => NOWHERE,
    };
    let mut branch: Vec<f64> = (0..n).map(|i| f64::from(u8::from(cost(1, i) < cost(0, i)))).collect();
    let mut usable: Vec<usize> = (0..n).filter(|&i| ahead(0, i) || ahead(1, i)).collect();
    let alone = |i: &usize| ahead(0, *i) != ahead(1, *i);
    if usable.iter().all(alone) {
        return branch;
    }
    let first = usable.iter().position(alone).unwrap_or(0);
    usable.rotate_left(first);
    let level = |i: &usize| BOTH.map(|k| if ahead(k, *i) { (found.radius[k][*i] / prior).ln() } else { f64::INFINITY });
    let levels: Vec<[f64; 2]> = usable.iter().map(level).collect();
    usable.iter().zip(least_cost_path(&levels)).for_each(|(&i, row)| branch[i] = row as f64);
    branch
}

/// The path of least cost (Viterbi) through `levels`, infinite where there is none.
fn least_cost_path(levels: &[[f64; 2]]) -> Vec<usize> {
    let pull = |here: [f64; 2]| here.map(|level| PRIOR * level.abs());
    let (mut cost, mut came_from) = (pull(levels[0]), vec![]);
    for pair in levels.windows(2) {
        let steps = pair[1].map(|place| cheapest(place, pair[0], cost));
        came_from.push(steps.map(|(_, row)| row));
        let own = pull(pair[1]);
        cost = BOTH.map(|k| steps[k].0 + own[k]);
    }
    let mut best = usize::from(cost[1] < cost[0]);
    let mut path = vec![best];
    for rows in came_from.iter().rev() {
        best = rows[best];
        path.push(best);
    }
    path.reverse();
    path
}

/// Cost and row of the best step to `place`.
fn cheapest(place: f64, before: [f64; 2], cost: [f64; 2]) -> (f64, usize) {
    if place == f64::INFINITY {
        return (f64::INFINITY, 0);
    }
    let step = |k: usize| if before[k] < f64::INFINITY { cost[k] + (place - before[k]).abs().min(EDGE) } else { f64::INFINITY };
    let [first, second] = BOTH.map(step);
    if second < first {
        (second, 1)
    } else {
        (first, 0)
    }
}
