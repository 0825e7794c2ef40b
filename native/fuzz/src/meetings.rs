//! Rays that meet light: whatever the numbers, a point with a known status or NaN, the same on one thread and on two.

use std::time::Duration;

use _native::entries::meeting::{drawn, measured, parameters, Makes, Points, MODE_NUMBERS};

use crate::{guarded, Bytes};

const MOST: usize = 64 << 20;
const LONGEST: Duration = Duration::from_secs(10);
const STATUSES: u8 = 32;
const OK: u8 = 0;
const BEAM: u8 = 3;

fn make(bytes: &mut Bytes) -> Makes {
    (bytes.byte() % 5, bytes.flag(), bytes.byte() % 6, bytes.number(384.0), bytes.flag())
}

/// About 0.1 m, of which most parameters are some.
fn rig(bytes: &mut Bytes, count: usize) -> Vec<f64> {
    let usual = [0.1, 320.0, 1.0, 0.01, 500.0];
    (0..count).map(|i| bytes.number(if i + 6 >= count { usual[[1, 3, 3, 2, 4, 4][i + 6 - count]] } else { usual[0] })).collect()
}

struct Given {
    u: Vec<f64>,
    v: Vec<f64>,
    choice: Vec<f64>,
    noise: Vec<f64>,
    direction: Option<[Vec<f64>; 2]>,
}

impl Given {
    fn of(bytes: &mut Bytes, most: usize) -> Given {
        let count = bytes.between(0, most);
        let (u, v) = (bytes.numbers(count, 500.0), bytes.numbers(count, 400.0));
        let shared = |bytes: &mut Bytes, usual: f64| {
            let one = bytes.flag();
            bytes.numbers(if one { 1 } else { count }, usual)
        };
        let (choice, noise) = (shared(bytes, 0.15), shared(bytes, 0.3));
        let direction = bytes.flag().then(|| [bytes.numbers(count, 1.0), bytes.numbers(count, 1.0)]);
        Given { u, v, choice, noise, direction }
    }

    fn points(&self) -> Points<'_> {
        let direction = self.direction.as_ref().map(|[u, v]| [u.as_slice(), v.as_slice()]);
        Points { u: &self.u, v: &self.v, choice: &self.choice, noise: &self.noise, direction }
    }
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan()))
}

pub fn measures(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let make = make(&mut bytes);
    let Some(count) = parameters(make) else { return };
    let rig = rig(&mut bytes, count);
    let modes = bytes.between(0, 6);
    let modes = bytes.numbers(modes * MODE_NUMBERS, 1e-3);
    let (numbered, given) = (bytes.flag(), Given::of(&mut bytes, 40));
    let results = [1, 2].map(|threads| guarded(MOST, LONGEST, || measured(make, &rig, &modes, given.points(), numbered, threads)));
    let [(columns, status), (others, same_status)] = results;
    assert!(same(&columns, &others) && status == same_status, "threads change the result");
    for (at, status) in status.iter().enumerate() {
        assert!(*status < STATUSES);
        let radius = columns[at];
        assert!(*status != OK || !radius.is_nan() || !possible(make, &rig), "point {at} is good and has no radius");
    }
}

/// Python lets no rig through whose numbers overflow where they are multiplied, and no beam through the pupil.
fn possible(make: Makes, rig: &[f64]) -> bool {
    rig.iter().all(|number| number.abs() <= 1e6) && (make.0 != BEAM || from_pupil(rig) >= 1e-6)
}

/// How near the beam, from the point of the first three numbers, passes the origin.
fn from_pupil(beam: &[f64]) -> f64 {
    let ((sine, cosine), (across, ahead)) = (beam[4].sin_cos(), beam[3].sin_cos());
    let light = [across * sine, -across * cosine, ahead];
    let start: f64 = (0..3).map(|axis| beam[axis] * light[axis]).sum();
    (0..3).map(|axis| (beam[axis] - start * light[axis]).powi(2)).sum::<f64>().sqrt()
}

pub fn draws(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let make = make(&mut bytes);
    let Some(count) = parameters(make) else { return };
    let given_rig = rig(&mut bytes, count);
    let many = bytes.between(0, 40);
    let hostile = bytes.flag();
    let rigs: Vec<f64> = match hostile {
        true => (0..many).flat_map(|_| rig(&mut bytes, count)).collect(),
        false => (0..many).flat_map(|k| given_rig.iter().map(move |value| value * (1.0 + 1e-3 * k as f64))).collect(),
    };
    let probability = bytes.flag().then(|| bytes.number(0.95));
    let (seed, given) = (u64::from(bytes.byte()), Given::of(&mut bytes, 20));
    let all = [1, 2].map(|threads| guarded(MOST, LONGEST, || drawn(make, &given_rig, &rigs, given.points(), (seed, probability), threads)));
    assert!(same(&all[0], &all[1]), "threads change the result");
}
