//! The line that a picture shows as rays on the wall and as a ring, without what water mirrors: the twin of
//! `calibore.profiling.line_on_wall`.

use super::fold::{line_on_cone, Enlargements};
use super::line::{on_wall, status, Line, OnWall, Valid};
use crate::meeting::measure::{Choice, Pixels, Shared};
use crate::meeting::modes::Mode;
use crate::meeting::projecting::Projector;
use crate::meeting::rig::Make;
use crate::water::{wet_rays, Ring};

/// What was found in the picture, ray by ray; see `calibore.stripe.Stripe`.
#[derive(Clone, Copy)]
pub struct Stripe<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub direction: [&'a [f64]; 2],
    pub u_position: &'a [f64],
    pub status: &'a [u8],
    pub correlation: &'a [f64],
    pub centre: Option<[f64; 2]>,
}

/// A rig with one laser, and how it is used: `stated` uncertainty of a line position, if not the observed; where it is `valid`; for cones
/// what the wall's radius is roughly.
pub struct Rig<'a> {
    pub make: &'a Make,
    pub parameters: &'a [f64],
    pub modes: &'a [Mode],
    pub stated: Option<f64>,
    pub valid: Option<Valid>,
    pub cone: Option<(f64, Enlargements<'a>)>,
    pub positions: usize,
}

/// None where no ray meets the light; with the rays that show water, which are left out.
pub fn stripe_on_wall(stripe: &Stripe, rig: &Rig) -> Option<(OnWall, Vec<usize>)> {
    let found = placed(stripe, rig)?;
    let wet = wet(stripe, rig, &found);
    if wet.is_empty() {
        return Some((found, wet));
    }
    let without = |values: &[f64]| {
        let mut values = values.to_vec();
        wet.iter().for_each(|&i| values[i] = f64::NAN);
        values
    };
    let [u, v, u_position] = [stripe.u, stripe.v, stripe.u_position].map(without);
    let mut told = stripe.status.to_vec();
    wet.iter().for_each(|&i| told[i] = status::WATER);
    let dry = Stripe { u: &u, v: &v, u_position: &u_position, status: &told, ..*stripe };
    Some((placed(&dry, rig)?, wet))
}

fn placed(stripe: &Stripe, rig: &Rig) -> Option<OnWall> {
    let on_cone = rig.cone.map(|how| line_on_cone(stripe, rig, how));
    let (mut u, mut v, mut u_position, mut branch, mut enlargement) = (stripe.u, stripe.v, stripe.u_position, &[0.0][..], &[1.0][..]);
    let mut grazing: &[bool] = &[];
    if let Some(cone) = &on_cone {
        (u, v, u_position, branch, enlargement, grazing) =
            (&cone.u, &cone.v, &cone.u_position, &cone.branch, &cone.enlargement, &cone.grazing);
    }
    let choice = Choice::Numbered(Shared(branch));
    let pixels = Pixels { u, v, choice, noise: Shared(&[1.0]), direction: Some(stripe.direction) };
    let line = Line { u_position, status: stripe.status, enlargement, correlation: stripe.correlation, grazing };
    on_wall((rig.make, rig.parameters, rig.modes), &pixels, &line, (rig.stated, rig.valid.as_ref(), rig.positions))
}

fn wet(stripe: &Stripe, rig: &Rig, found: &OnWall) -> Vec<usize> {
    let Some(centre) = stripe.centre else { return vec![] };
    let [x, y, z, _, clock, _] = &found.rays;
    let seen: Vec<usize> = (0..x.len()).filter(|&i| stripe.status[i] <= status::SATURATED && x[i].is_finite()).collect();
    let ring = Ring { points: [x, y, z], clock, pixel: [stripe.u, stripe.v], found: &seen, centre };
    wet_rays(&ring, &Projector::of(rig.make, rig.parameters))
}
