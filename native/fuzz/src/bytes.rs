//! Arguments from the fuzzer's bytes; zeros where they end.

/// Numbers that programs trip over.
const HOSTILE: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1e-300,
    -1e-300,
    5e-324,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    1_048_576.0,
    -1_048_576.0,
    1_048_577.0,
    4_294_967_296.0,
    9_223_372_036_854_775_808.0,
    std::f64::consts::PI,
    std::f64::consts::FRAC_PI_2,
    f64::EPSILON,
    0.999_999_999_999_999_9,
];

pub struct Bytes<'a> {
    data: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub fn new(data: &'a [u8]) -> Self {
        Bytes { data }
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.data.split_at(self.data.len().min(N));
        self.data = rest;
        std::array::from_fn(|i| first.get(i).copied().unwrap_or(0))
    }

    pub fn byte(&mut self) -> u8 {
        self.take::<1>()[0]
    }

    pub fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// A whole number from `low` on, below `end`.
    pub fn between(&mut self, low: usize, end: usize) -> usize {
        low + usize::from(u16::from_le_bytes(self.take())) % (end - low)
    }

    /// A number about `usual`, a hostile one, or any bits.
    pub fn number(&mut self, usual: f64) -> f64 {
        let kind = self.byte();
        match kind {
            0..=24 => HOSTILE[usize::from(kind) % HOSTILE.len()],
            25..=40 => f64::from_bits(u64::from_le_bytes(self.take())),
            41..=56 => -usual,
            _ => usual * (f64::from(i16::from_le_bytes(self.take())) / 16384.0 + if kind & 1 == 1 { 1.0 } else { 0.0 }),
        }
    }

    pub fn numbers(&mut self, count: usize, usual: f64) -> Vec<f64> {
        (0..count).map(|_| self.number(usual)).collect()
    }

    pub fn rest(&self) -> &'a [u8] {
        self.data
    }
}
