//! Pictures that a kernel could meet: dark, noise, a ring or a line, glare; or bytes as they are.

use crate::Bytes;

pub struct Canvas {
    pub levels: Vec<u16>,
    pub width: usize,
    pub height: usize,
    pub bands: usize,
}

/// Wide enough for rays, small enough for thousands of pictures a second.
const LARGEST: usize = 120;

pub fn canvas(bytes: &mut Bytes) -> Canvas {
    let (width, height) = (bytes.between(8, LARGEST), bytes.between(8, LARGEST));
    let bands = [1, 3, 2, 4][bytes.between(0, 4)];
    let (dark, bright, noise) = (f64::from(bytes.byte()), f64::from(bytes.byte()), bytes.byte());
    let (centre, radius) = ([f64::from(bytes.byte()), f64::from(bytes.byte())], f64::from(bytes.byte()) / 2.0);
    let (width_of_line, closed) = (0.3 + f64::from(bytes.byte()) / 40.0, bytes.flag());
    let mut state = u64::from(bytes.byte()) * 0x9e37_79b9 + 1;
    let levels = (0..width * height * bands).map(|at| {
        let (column, row) = ((at / bands % width) as f64, (at / bands / width) as f64);
        let place = if closed { (column - centre[0]).hypot(row - centre[1]) } else { row + column * (centre[0] - 128.0) / 512.0 };
        let line = bright * (-((place - radius) / width_of_line).powi(2) / 2.0).exp();
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let grain = if noise == 0 { 0.0 } else { (state >> 33) as f64 % f64::from(noise) };
        ((dark + line + grain).min(255.0) * 257.0) as u16
    });
    let mut levels: Vec<u16> = levels.collect();
    let stride = bytes.between(1, 40);
    let patches = bytes.rest();
    for (level, byte) in levels.iter_mut().step_by(stride).zip(patches) {
        *level = level.wrapping_add(u16::from(*byte) * 257);
    }
    Canvas { levels, width, height, bands }
}
