//! Normal numbers, eight at once: xoshiro256++ in every lane and the Box-Muller transform. Streams are told by numbers, so that it does
//! not matter which thread draws.

use super::functions::{logarithm, sin_cos};
use super::lanes::{each, Lanes, LANES};

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
const EXPONENT_OF_ONE: u64 = 0x3FF0_0000_0000_0000;

#[derive(Clone, Copy)]
#[repr(align(64))]
struct Words([u64; LANES]);

macro_rules! words {
    (|$k:ident| $value:expr) => {
        each!(Words, 0, |$k| $value)
    };
}

#[derive(Clone, Copy)]
pub struct Stream {
    state: [Words; 4],
}

impl Stream {
    /// The stream of this `number`, by splitmix64 as the generator's authors advise.
    pub fn new(seed: u64, number: u64) -> Self {
        let mut counter = scrambled(seed.wrapping_add(scrambled(number.wrapping_add(GOLDEN))));
        let mut state = [Words([0; LANES]); 4];
        for word in state.iter_mut().flat_map(|words| &mut words.0) {
            counter = counter.wrapping_add(GOLDEN);
            *word = scrambled(counter);
        }
        Stream { state }
    }

    #[inline(always)]
    fn next(&mut self) -> Words {
        let [a, b, c, d] = self.state;
        let sum = words!(|k| a.0[k].wrapping_add(d.0[k]));
        let drawn = words!(|k| sum.0[k].rotate_left(23).wrapping_add(a.0[k]));
        let (c, d) = (words!(|k| c.0[k] ^ a.0[k]), words!(|k| d.0[k] ^ b.0[k]));
        self.state = [
            words!(|k| a.0[k] ^ d.0[k]),
            words!(|k| b.0[k] ^ c.0[k]),
            words!(|k| c.0[k] ^ (b.0[k] << 17)),
            words!(|k| d.0[k].rotate_left(45)),
        ];
        drawn
    }

    /// Uniform in [1, 2).
    #[inline(always)]
    fn uniform(&mut self) -> Lanes {
        let drawn = self.next();
        each!(Lanes, 0.0, |k| f64::from_bits((drawn.0[k] >> 12) | EXPONENT_OF_ONE))
    }

    /// Two independent standard normal numbers in every lane.
    #[inline(always)]
    pub fn normals(&mut self) -> [Lanes; 2] {
        let above_zero = Lanes::all(2.0) - self.uniform();
        let length = (Lanes::all(-2.0) * logarithm(above_zero)).sqrt();
        let (sine, cosine) = sin_cos((self.uniform() - Lanes::all(1.5)) * Lanes::all(std::f64::consts::TAU));
        [length * cosine, length * sine]
    }
}

fn scrambled(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}
