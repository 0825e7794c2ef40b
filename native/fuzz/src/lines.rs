//! The stripe kernels: whatever the picture and the region, a line or a sentence, and the same bytes with and without vectors.

use std::time::Duration;

use _native::entries::stripe::{line, ring, Found, Picture, Region};

use crate::pictures::{canvas, Canvas};
use crate::{guarded, Bytes};

const MOST: usize = 256 << 20;
const LONGEST: Duration = Duration::from_secs(10);
const ESTIMATORS: usize = 9;
const STATUSES: u8 = 32;

fn same(wide: &Option<Found>, scalar: &Option<Found>) {
    match (wide, scalar) {
        (Some(Ok((a, s))), Some(Ok((b, t)))) => {
            let close = |(x, y): (&f64, &f64)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan());
            assert!(a.len() == b.len() && a.iter().zip(b).all(close) && s == t, "vectors change the result");
            assert!(s.iter().all(|status| *status < STATUSES));
        }
        (Some(Err(a)), Some(Err(b))) => assert_eq!(a, b),
        (None, None) => {}
        _ => panic!("vectors change whether there is a result"),
    }
}

fn both(canvas: &Canvas, sixteen: bool, band: usize, work: impl Fn(Levels, bool) -> Option<Found>) {
    let Canvas { levels, width, height, bands } = canvas;
    let (width, height, bands) = (*width, *height, *bands);
    let eight: Vec<u8> = levels.iter().map(|level| (level >> 8) as u8).collect();
    let [wide, scalar] = [true, false].map(|vectors| {
        guarded(MOST, LONGEST, || match sixteen {
            true => work(Levels::Sixteen(Picture { data: levels, width, height, bands, band }), vectors),
            false => work(Levels::Eight(Picture { data: &eight, width, height, bands, band }), vectors),
        })
    });
    same(&wide, &scalar);
}

enum Levels<'a> {
    Eight(Picture<'a, u8>),
    Sixteen(Picture<'a, u16>),
}

/// The band asked for, as Python lets it through.
fn band(bytes: &mut Bytes, bands: usize) -> usize {
    bytes.between(0, if bands == 3 { 4 } else { bands })
}

pub fn rings(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (estimator, sixteen, exact) = (bytes.between(0, ESTIMATORS) as u8, bytes.flag(), bytes.flag());
    let centre = [bytes.number(50.0), bytes.number(50.0)];
    let radii = (bytes.number(15.0), bytes.number(60.0));
    let count = bytes.between(0, 300);
    let mut direction: Vec<[f64; 2]> =
        (0..count).map(|i| (i as f64 / count as f64 * std::f64::consts::TAU).sin_cos()).map(|(s, c)| [s, -c]).collect();
    if !exact {
        for _ in 0..bytes.between(0, 8) {
            let at = bytes.between(0, count.max(1));
            let other = [bytes.number(1.0), bytes.number(1.0)];
            direction.iter_mut().skip(at).take(1).for_each(|direction| *direction = other);
        }
    }
    let fewer = if bytes.byte() == 0 { bytes.between(0, count + 1) } else { count };
    let uncounted = bytes.between(0, count + 1);
    let counted: Vec<bool> = (0..fewer).map(|i| i >= uncounted || i % 7 == 0).collect();
    let canvas = canvas(&mut Bytes::new(bytes.rest()));
    let band = band(&mut bytes, canvas.bands);
    let region = Region { centre, radii, direction: &direction, counted: &counted };
    both(&canvas, sixteen, band, |levels, vectors| match levels {
        Levels::Eight(picture) => ring(picture, region, estimator, vectors),
        Levels::Sixteen(picture) => ring(picture, region, estimator, vectors),
    });
}

pub fn lines(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (estimator, sixteen, down) = (bytes.between(0, ESTIMATORS) as u8, bytes.flag(), bytes.flag());
    let canvas = canvas(&mut Bytes::new(bytes.rest()));
    let band = band(&mut bytes, canvas.bands);
    both(&canvas, sixteen, band, |levels, vectors| match levels {
        Levels::Eight(picture) => line(picture, estimator, down, vectors),
        Levels::Sixteen(picture) => line(picture, estimator, down, vectors),
    });
}
