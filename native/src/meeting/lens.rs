//! From an image radius to the zenith of the ray: the twin of `calibore.optics._lens` and `_laws`.

use super::functions::sin_cos;
use super::lanes::{Lanes, Mask};

#[derive(Clone, Copy, PartialEq)]
pub enum Law {
    Perspective,
    Stereographic,
    Equidistant,
    Sine,
    EquisolidAngle,
}

impl Law {
    pub fn numbered(number: u8) -> Option<Self> {
        [Law::Perspective, Law::Stereographic, Law::Equidistant, Law::Sine, Law::EquisolidAngle].get(usize::from(number)).copied()
    }

    /// The ratio image radius / k at which the law ends.
    pub fn end(self) -> f64 {
        match self {
            Law::Perspective | Law::Stereographic => f64::INFINITY,
            Law::Equidistant => std::f64::consts::PI,
            Law::Sine | Law::EquisolidAngle => 1.0,
        }
    }

    /// Sine and cosine of the zenith, and the slope d ratio / d zenith.
    #[inline(always)]
    fn zenith(self, q: Lanes) -> (Lanes, Lanes, Lanes) {
        let (one, two, half) = (Lanes::ONE, Lanes::all(2.0), Lanes::all(0.5));
        let square = q * q;
        match self {
            Law::Perspective => {
                let cosine = one / (one + square).sqrt();
                (q * cosine, cosine, one + square)
            }
            Law::Stereographic => {
                let inverse = one / (one + square);
                (two * q * inverse, (one - square) * inverse, half * (one + square))
            }
            Law::Equidistant => {
                let (sine, cosine) = sin_cos(q);
                (sine, cosine, one)
            }
            Law::Sine => {
                let cosine = ((one - q) * (one + q)).sqrt();
                (q, cosine, cosine)
            }
            Law::EquisolidAngle => {
                let root = ((one - q) * (one + q)).sqrt();
                (two * q * root, one - two * square, half * root)
            }
        }
    }
}

/// 1 / k and the residual r (1 + c1 q^2 + c2 q^4), q in half image heights, which holds up to `limit`.
#[derive(Clone, Copy)]
pub struct Lens {
    pub per_k: Lanes,
    pub c1: Lanes,
    pub c2: Lanes,
    pub limit: Lanes,
}

/// What does not move: the law, the scale of the residual, and whether there is one.
#[derive(Clone, Copy)]
pub struct Optics {
    pub law: Law,
    pub half_height: f64,
    pub residual: bool,
}

pub struct Zenith {
    pub sine: Lanes,
    pub cosine: Lanes,
    /// Derivatives of the zenith by the image radius, k, c1 and c2.
    pub by_radius: Lanes,
    pub by_lens: [Lanes; 3],
    pub seen: Mask,
}

impl Lens {
    #[inline(always)]
    pub fn of(optics: &Optics, k: Lanes, c1: Lanes, c2: Lanes) -> Self {
        let limit = if optics.residual { limit_of_residual(c1, c2) } else { Lanes::ZERO };
        Lens { per_k: Lanes::ONE / k, c1, c2, limit }
    }

    #[inline(always)]
    pub fn zenith(&self, optics: &Optics, radius: Lanes) -> Zenith {
        let law_radius = if optics.residual { self.without_residual(optics.half_height, radius) } else { radius };
        let ratio = law_radius * self.per_k;
        let seen = ratio.less(Lanes::all(optics.law.end()));
        let ratio = seen.choose(ratio, Lanes::NAN);
        let (sine, cosine, slope) = optics.law.zenith(ratio);
        let by_law_radius = self.per_k / slope;
        let q = law_radius * Lanes::all(1.0 / optics.half_height);
        let square = q * q;
        let by_radius = if optics.residual { by_law_radius / self.slope(square) } else { by_law_radius };
        let by_c1 = -(law_radius * square * by_radius);
        Zenith { sine, cosine, by_radius, by_lens: [-(ratio * by_law_radius), by_c1, by_c1 * square], seen }
    }

    #[inline(always)]
    fn value(&self, x: Lanes) -> Lanes {
        let square = x * x;
        x * (Lanes::ONE + (self.c1 + self.c2 * square) * square)
    }

    #[inline(always)]
    fn slope(&self, square: Lanes) -> Lanes {
        Lanes::ONE + (Lanes::all(3.0) * self.c1 + Lanes::all(5.0) * self.c2 * square) * square
    }

    /// Newton from the radius itself; where an inflection throws it off, halving and Newton again. NaN beyond `limit`.
    #[inline(always)]
    fn without_residual(&self, half_height: f64, radius: Lanes) -> Lanes {
        let y = radius * Lanes::all(1.0 / half_height);
        let y = y.at_most(self.value(self.limit)).choose(y, Lanes::NAN);
        let (x, step) = self.newton(y.least(self.limit), y);
        let settled = step.abs().at_most(Lanes::all(SETTLED));
        let inside = x.at_least(Lanes::all(-SETTLED)) & x.at_most(self.limit + Lanes::all(SETTLED));
        let lost = !((settled & inside) | y.is_nan());
        let x = if lost.any() { lost.choose(self.newton(self.halved(y), y).0, x) } else { x };
        x * Lanes::all(half_height)
    }

    #[inline(always)]
    fn newton(&self, start: Lanes, y: Lanes) -> (Lanes, Lanes) {
        let (mut x, mut step) = (start, Lanes::ZERO);
        for _ in 0..STEPS {
            step = (self.value(x) - y) / self.slope(x * x);
            x = x - step;
            if !step.abs().more(Lanes::all(CONVERGED)).any() {
                break;
            }
        }
        (x, step)
    }

    #[cold]
    fn halved(&self, y: Lanes) -> Lanes {
        let (mut low, mut high) = (Lanes::ZERO, self.limit);
        for _ in 0..HALVINGS {
            let middle = (low + high) * Lanes::all(0.5);
            let below = self.value(middle).less(y);
            (low, high) = (below.choose(middle, low), below.choose(high, middle));
        }
        (low + high) * Lanes::all(0.5)
    }
}

const SETTLED: f64 = 1e-9;
const CONVERGED: f64 = 1e-14;
const STEPS: usize = 12;
const HALVINGS: usize = 60;
const FARTHEST: f64 = 100.0;
const LEAST_SLOPE: f64 = 0.05;
const NEGLIGIBLE: f64 = 1e-12;

/// The largest q up to which the slope of the residual stays above `LEAST_SLOPE`; see `OddPolynomial.limit`.
#[inline(always)]
fn limit_of_residual(c1: Lanes, c2: Lanes) -> Lanes {
    let kept = |slope: Lanes, scale: f64| (slope.abs() * Lanes::all(scale)).at_least(Lanes::all(NEGLIGIBLE)).choose(slope, Lanes::ZERO);
    let linear = kept(Lanes::all(3.0) * c1, FARTHEST.powi(2));
    let square = kept(Lanes::all(5.0) * c2, FARTHEST.powi(4));
    let constant = Lanes::all(1.0 - LEAST_SLOPE);
    // of q^2; the product of both roots is constant / square, so that neither loses digits
    let root = (linear * linear - Lanes::all(4.0) * square * constant).sqrt();
    let twice = linear.less(Lanes::ZERO).choose(root - linear, -(linear + root));
    let (first, second) = (Lanes::all(2.0) * constant / twice, twice / (Lanes::all(2.0) * square));
    let farthest = Lanes::all(FARTHEST * FARTHEST);
    let turning = |root: Lanes| (root.more(Lanes::ZERO) & root.less(farthest)).choose(root, farthest);
    turning(first).least(turning(second)).sqrt()
}
