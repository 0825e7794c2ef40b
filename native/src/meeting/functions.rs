//! Elementary functions lane by lane, to a few units in the last place: series of the Cephes library and of fdlibm.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, LN_2, PI, TAU};

use super::lanes::{each, Lanes, Mask, LANES};

const SINE: [f64; 6] = [
    1.589_623_015_765_465_7e-10,
    -2.505_074_776_285_780_7e-8,
    2.755_731_362_138_572e-6,
    -1.984_126_982_958_954e-4,
    8.333_333_333_322_118e-3,
    -1.666_666_666_666_663e-1,
];
const COSINE: [f64; 6] = [
    -1.135_853_652_138_768_2e-11,
    2.087_570_084_197_473e-9,
    -2.755_731_417_929_674e-7,
    2.480_158_728_885_170_5e-5,
    -1.388_888_888_887_305_6e-3,
    4.166_666_666_666_659e-2,
];
const ARC: [f64; 5] =
    [-8.750_608_600_031_904e-1, -1.615_753_718_733_365e1, -7.500_855_792_314_705e1, -1.228_866_684_490_136_2e2, -6.485_021_904_942_025e1];
const ARC_BELOW: [f64; 6] = [
    1.0,
    2.485_846_490_142_306_3e1,
    1.650_270_098_316_988_5e2,
    4.328_810_604_912_902_7e2,
    4.853_903_996_359_137e2,
    1.945_506_571_482_614e2,
];
const LOGARITHM: [f64; 7] = [
    1.479_819_860_511_658_6e-1,
    1.531_383_769_920_937_3e-1,
    1.818_357_216_161_805e-1,
    2.222_219_843_214_978_4e-1,
    2.857_142_874_366_239e-1,
    3.999_999_999_940_942e-1,
    6.666_666_666_666_735e-1,
];
/// pi/2 in two parts, the first with zeros at its end.
const QUARTER: f64 = 1.570_796_326_734_125_6;
const QUARTER_REST: f64 = 6.077_100_506_506_192e-11;
/// Added to a number it leaves the nearest whole number in the last bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;
const TANGENT_OF_22_5_DEG: f64 = 0.414_213_562_373_095_03;
const SIGNIFICAND: u64 = (1 << 52) - 1;
const BIASED_ONE: u64 = 1023;

#[inline(always)]
fn series<const N: usize>(x: Lanes, coefficients: [f64; N]) -> Lanes {
    let mut sum = Lanes::all(coefficients[0]);
    for &c in &coefficients[1..] {
        sum = sum.fused(x, Lanes::all(c));
    }
    sum
}

/// Sine and cosine of angles of a few turns at most.
#[inline(always)]
pub fn sin_cos(angle: Lanes) -> (Lanes, Lanes) {
    let shifted = angle.fused(Lanes::all(FRAC_2_PI), Lanes::all(WHOLE));
    let quarters = shifted - Lanes::all(WHOLE);
    let odd = each!(Mask, 0, |k| (shifted.0[k].to_bits() & 1).wrapping_neg());
    let x = quarters.fused(Lanes::all(-QUARTER_REST), quarters.fused(Lanes::all(-QUARTER), angle));
    let z = x * x;
    let sine = (x * z).fused(series(z, SINE), x);
    let cosine = (z * z).fused(series(z, COSINE), z.fused(Lanes::all(-0.5), Lanes::ONE));
    let (s, c) = (odd.choose(cosine, sine), odd.choose(sine, cosine));
    let sign_of_sine = |k: usize| (shifted.0[k].to_bits() & 2) << 62;
    let sign_of_cosine = |k: usize| (shifted.0[k].to_bits().wrapping_add(1) & 2) << 62;
    (
        each!(Lanes, 0.0, |k| f64::from_bits(s.0[k].to_bits() ^ sign_of_sine(k))),
        each!(Lanes, 0.0, |k| f64::from_bits(c.0[k].to_bits() ^ sign_of_cosine(k))),
    )
}

/// The angle of (x, y) from -y towards +x, in [0, 2 pi).
#[inline(always)]
pub fn clock(x: Lanes, y: Lanes) -> Lanes {
    let (wide, tall) = (x.abs(), y.abs());
    let flat = tall.less(wide);
    let (short, long) = (flat.choose(tall, wide), flat.choose(wide, tall));
    let steep = short.more(long * Lanes::all(TANGENT_OF_22_5_DEG));
    let below = steep.choose(short + long, long);
    let t = steep.choose(short - long, short) / below.more(Lanes::ZERO).choose(below, Lanes::ONE);
    let z = t * t;
    let arc = t + t * z * (series(z, ARC) / series(z, ARC_BELOW)) + steep.choose(Lanes::all(FRAC_PI_4), Lanes::ZERO);
    let from_vertical = flat.choose(Lanes::all(FRAC_PI_2) - arc, arc);
    let from_top = y.less(Lanes::ZERO).choose(from_vertical, Lanes::all(PI) - from_vertical);
    let turned = x.less(Lanes::ZERO).choose(Lanes::all(TAU) - from_top, from_top);
    let turned = turned.less(Lanes::all(TAU)).choose(turned, Lanes::ZERO);
    (x.is_nan() | y.is_nan()).choose(Lanes::NAN, turned)
}

/// Natural logarithm of normal numbers above 0.
#[inline(always)]
pub fn logarithm(x: Lanes) -> Lanes {
    let half_power = BIASED_ONE << 52;
    let power = each!(Lanes, 0.0, |k| f64::from_bits((x.0[k].to_bits() >> 52) | 0x4330_0000_0000_0000))
        - Lanes::all(4_503_599_627_370_496.0 + BIASED_ONE as f64);
    let m = each!(Lanes, 0.0, |k| f64::from_bits((x.0[k].to_bits() & SIGNIFICAND) | half_power));
    let high = m.more(Lanes::all(std::f64::consts::SQRT_2));
    let m = high.choose(m * Lanes::all(0.5), m);
    let power = high.choose(power + Lanes::ONE, power);
    let s = (m - Lanes::ONE) / (m + Lanes::ONE);
    let z = s * s;
    power.fused(Lanes::all(LN_2), s * z.fused(series(z, LOGARITHM), Lanes::all(2.0)))
}
