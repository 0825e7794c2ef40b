//! Many points: in chunks of lanes, on several threads.

use super::cone::Cone;
use super::dispatch::{threads, widest, Work};
use super::flat::Flat;
use super::lanes::LANES;
use super::measure::{measure, Pixels, Rig, COLUMNS};
use super::modes::Mode;
use super::rig::{Kind, Make, Numbers};
use super::surface::Surface;

/// Points that are worth a thread.
const TASK: usize = 4096;

/// Where the results of some consecutive points go.
struct Share<'a> {
    from: usize,
    columns: [&'a mut [f64]; COLUMNS],
    status: &'a mut [u8],
}

impl<'a> Share<'a> {
    fn all(columns: &'a mut [f64], status: &'a mut [u8]) -> Self {
        let mut rows = columns.chunks_mut(status.len().max(1));
        Share { from: 0, columns: std::array::from_fn(|_| rows.next().unwrap_or_default()), status }
    }

    /// The first `count` points, and the others.
    fn split(self, count: usize) -> (Self, Self) {
        let count = count.min(self.status.len());
        let (status, rest) = self.status.split_at_mut(count);
        let mut columns = [const { None }; COLUMNS];
        let others = {
            let mut i = 0;
            self.columns.map(|column| {
                let (first, others) = column.split_at_mut(count);
                columns[i] = Some(first);
                i += 1;
                others
            })
        };
        let first = Share { from: self.from, columns: columns.map(Option::unwrap_or_default), status };
        (first, Share { from: self.from + count, columns: others, status: rest })
    }
}

struct Measuring<'a, S> {
    make: &'a Make,
    rig: &'a Rig<S>,
    modes: &'a [Mode],
    pixels: &'a Pixels<'a>,
    share: Share<'a>,
}

impl<S: Surface> Work for Measuring<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Share { from, mut columns, status } = self.share;
        for (chunk, status) in status.chunks_mut(LANES).enumerate() {
            let start = chunk * LANES;
            let point = measure(self.make, self.rig, self.modes, self.pixels, from + start);
            for (column, values) in columns.iter_mut().zip(point.columns) {
                values.store(&mut column[start..]);
            }
            status.copy_from_slice(&point.status[..status.len()]);
        }
    }
}

pub fn measure_all(make: &Make, numbers: &Numbers, modes: &[Mode], pixels: &Pixels, columns: &mut [f64], status: &mut [u8], wanted: usize) {
    let share = Share::all(columns, status);
    match make.kind {
        Kind::Cone => on_threads(make, &Rig::<Cone>::same(make, numbers), modes, pixels, share, wanted),
        Kind::Plane | Kind::Sheet | Kind::Beam => on_threads(make, &Rig::<Flat>::same(make, numbers), modes, pixels, share, wanted),
    }
}

fn on_threads<S: Surface>(make: &Make, rig: &Rig<S>, modes: &[Mode], pixels: &Pixels, share: Share, wanted: usize) {
    let points = share.status.len();
    let count = threads(wanted, points / TASK);
    let each = points.div_ceil(count).next_multiple_of(LANES);
    std::thread::scope(|scope| {
        let mut rest = share;
        for _ in 1..count {
            let (share, others) = rest.split(each);
            rest = others;
            scope.spawn(move || widest(Measuring { make, rig, modes, pixels, share }));
        }
        widest(Measuring { make, rig, modes, pixels, share: rest });
    });
}
