//! Eight numbers computed together, one in each lane: what the compiler turns into vector instructions of any width. Products and sums
//! are fused where it says so, and on every machine, so that all compute the same bytes.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

pub const LANES: usize = 8;

#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

/// One answer for each lane: all bits, or none.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Mask(pub [u64; LANES]);

pub type Vector = [Lanes; 3];

macro_rules! each {
    ($kind:ident, $zero:expr, |$k:ident| $value:expr) => {{
        let mut lanes = [$zero; LANES];
        for $k in 0..LANES {
            lanes[$k] = $value;
        }
        $kind(lanes)
    }};
}
pub(super) use each;

#[inline(always)]
fn bits(answer: bool) -> u64 {
    (answer as u64).wrapping_neg()
}

impl Lanes {
    pub const ZERO: Lanes = Lanes::all(0.0);
    pub const ONE: Lanes = Lanes::all(1.0);
    pub const NAN: Lanes = Lanes::all(f64::NAN);

    #[inline(always)]
    pub const fn all(value: f64) -> Self {
        Lanes([value; LANES])
    }

    /// The first numbers of `values`; NaN in lanes beyond their end.
    #[inline(always)]
    pub fn load(values: &[f64]) -> Self {
        match values.first_chunk() {
            Some(full) => Lanes(*full),
            None => each!(Lanes, 0.0, |k| values.get(k).copied().unwrap_or(f64::NAN)),
        }
    }

    /// As many numbers as `values` has room for.
    #[inline(always)]
    pub fn store(self, values: &mut [f64]) {
        match values.first_chunk_mut() {
            Some(full) => *full = self.0,
            None => values.iter_mut().zip(self.0).for_each(|(to, from)| *to = from),
        }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        each!(Lanes, 0.0, |k| self.0[k].sqrt())
    }

    /// `self` x `by` + `plus`, rounded once.
    #[inline(always)]
    pub fn fused(self, by: Lanes, plus: Lanes) -> Self {
        each!(Lanes, 0.0, |k| self.0[k].mul_add(by.0[k], plus.0[k]))
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        each!(Lanes, 0.0, |k| self.0[k].abs())
    }

    #[inline(always)]
    pub fn squared(self) -> Self {
        self * self
    }

    #[inline(always)]
    pub fn less(self, other: Lanes) -> Mask {
        each!(Mask, 0, |k| bits(self.0[k] < other.0[k]))
    }

    #[inline(always)]
    pub fn more(self, other: Lanes) -> Mask {
        each!(Mask, 0, |k| bits(self.0[k] > other.0[k]))
    }

    #[inline(always)]
    pub fn at_least(self, other: Lanes) -> Mask {
        each!(Mask, 0, |k| bits(self.0[k] >= other.0[k]))
    }

    #[inline(always)]
    pub fn at_most(self, other: Lanes) -> Mask {
        each!(Mask, 0, |k| bits(self.0[k] <= other.0[k]))
    }

    #[inline(always)]
    pub fn is_nan(self) -> Mask {
        each!(Mask, 0, |k| bits(self.0[k].is_nan()))
    }

    /// As a product: a test of the bits would go lane by lane.
    #[inline(always)]
    pub fn is_finite(self) -> Mask {
        (self * Lanes::ZERO).at_least(Lanes::ZERO)
    }

    /// NaN stays where `self` is NaN.
    #[inline(always)]
    pub fn least(self, other: Lanes) -> Self {
        other.less(self).choose(other, self)
    }

    /// Whole numbers from 0 to 255, which stand in the last bits after the addition.
    #[inline(always)]
    pub fn to_bytes(self) -> [u8; LANES] {
        let shifted = self + Lanes::all(4_503_599_627_370_496.0);
        let mut bytes = [0; LANES];
        for (byte, value) in bytes.iter_mut().zip(shifted.0) {
            *byte = value.to_bits() as u8;
        }
        bytes
    }

    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.0.iter().sum()
    }
}

impl Mask {
    #[inline(always)]
    pub fn choose(self, yes: Lanes, no: Lanes) -> Lanes {
        each!(Lanes, 0.0, |k| f64::from_bits((self.0[k] & yes.0[k].to_bits()) | (!self.0[k] & no.0[k].to_bits())))
    }

    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.iter().fold(0, |any, yes| any | yes) != 0
    }
}

macro_rules! lane_by_lane {
    ($on:ident, $zero:expr; $($operation:ident $name:ident $sign:tt),*) => {$(
        impl $operation for $on {
            type Output = $on;
            #[inline(always)]
            fn $name(self, other: $on) -> $on {
                each!($on, $zero, |k| self.0[k] $sign other.0[k])
            }
        }
    )*};
}

lane_by_lane!(Lanes, 0.0; Add add +, Sub sub -, Mul mul *, Div div /);
lane_by_lane!(Mask, 0; BitAnd bitand &, BitOr bitor |);

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        each!(Lanes, 0.0, |k| -self.0[k])
    }
}

impl Not for Mask {
    type Output = Mask;
    #[inline(always)]
    fn not(self) -> Mask {
        each!(Mask, 0, |k| !self.0[k])
    }
}

#[inline(always)]
pub fn dot(a: Vector, b: Vector) -> Lanes {
    a[2].fused(b[2], a[1].fused(b[1], a[0] * b[0]))
}

#[inline(always)]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1].fused(b[2], -(a[2] * b[1])), a[2].fused(b[0], -(a[0] * b[2])), a[0].fused(b[1], -(a[1] * b[0]))]
}

#[inline(always)]
pub fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `start` + `length` x `direction`.
#[inline(always)]
pub fn along(start: Vector, length: Lanes, direction: Vector) -> Vector {
    [length.fused(direction[0], start[0]), length.fused(direction[1], start[1]), length.fused(direction[2], start[2])]
}

/// The same numbers in all lanes.
#[inline(always)]
pub fn vector(numbers: [f64; 3]) -> Vector {
    [Lanes::all(numbers[0]), Lanes::all(numbers[1]), Lanes::all(numbers[2])]
}
