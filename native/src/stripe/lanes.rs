//! Eight peaks computed together, one in each lane: what the compiler turns into vector instructions of any machine.

use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

pub const LANES: usize = 8;

#[derive(Clone, Copy)]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    pub const ZERO: Lanes = Lanes([0.0; LANES]);

    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Lanes([value; LANES])
    }

    /// Itself where `tested` is less than `limit`, zero elsewhere and where `tested` is NaN.
    #[inline(always)]
    pub fn where_less(self, tested: Lanes, limit: Lanes) -> Self {
        Lanes(from_fn(|k| if tested.0[k] < limit.0[k] { self.0[k] } else { 0.0 }))
    }

    /// `yes` where it is at least `limit`, `no` elsewhere and where it is NaN.
    #[inline(always)]
    pub fn at_least(self, limit: Lanes, yes: Lanes, no: Lanes) -> Self {
        Lanes(from_fn(|k| if self.0[k] >= limit.0[k] { yes.0[k] } else { no.0[k] }))
    }

    /// The smaller one, `self` where `other` is NaN.
    #[inline(always)]
    pub fn least(self, other: Lanes) -> Self {
        Lanes(from_fn(|k| if other.0[k] < self.0[k] { other.0[k] } else { self.0[k] }))
    }

    /// Exponential of numbers between -2 and 2, to 1e-12: the fourth power of a short series.
    #[inline(always)]
    pub fn exponential(self) -> Self {
        const TERMS: u32 = 10;
        let quarter = self * Lanes::all(0.25);
        let mut sum = Lanes::all(1.0);
        for term in (1..=TERMS).rev() {
            sum = Lanes::all(1.0) + quarter * sum * Lanes::all(1.0 / f64::from(term));
        }
        sum *= sum;
        sum * sum
    }
}

macro_rules! lane_by_lane {
    ($($kind:ident $name:ident $sign:tt),*) => {$(
        impl $kind for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $name(self, other: Lanes) -> Lanes {
                Lanes(from_fn(|k| self.0[k] $sign other.0[k]))
            }
        }
    )*};
}

lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Lanes) {
        *self = *self + other;
    }
}

impl MulAssign for Lanes {
    #[inline(always)]
    fn mul_assign(&mut self, other: Lanes) {
        *self = *self * other;
    }
}
