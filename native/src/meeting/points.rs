//! Many points: in chunks of lanes, on several threads.

use super::cone::Cone;
use super::dispatch::{threads, widest, Work};
use super::flat::Flat;
use super::lanes::LANES;
use super::measure::{measure, Pixels, COLUMNS};
use super::modes::Mode;
use super::mount::{Forward, Mount, SideFacing};
use super::rig::{Make, Rig};
use super::surface::{Kind, Surface};

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

struct Measuring<'a, S, M> {
    make: &'a Make,
    rig: &'a Rig<S, M>,
    modes: &'a [Mode],
    pixels: &'a Pixels<'a>,
    share: Share<'a>,
}

impl<S: Surface, M: Mount> Work for Measuring<'_, S, M> {
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

pub fn measure_all(
    make: &Make,
    parameters: &[f64],
    modes: &[Mode],
    pixels: &Pixels,
    columns: &mut [f64],
    status: &mut [u8],
    wanted: usize,
) {
    let share = Share::all(columns, status);
    match (make.kind, make.side_facing) {
        (Kind::Cone, false) => on_threads(make, &make.same::<Cone, Forward>(parameters), modes, pixels, share, wanted),
        (Kind::Cone, true) => on_threads(make, &make.same::<Cone, SideFacing>(parameters), modes, pixels, share, wanted),
        (_, false) => on_threads(make, &make.same::<Flat, Forward>(parameters), modes, pixels, share, wanted),
        (_, true) => on_threads(make, &make.same::<Flat, SideFacing>(parameters), modes, pixels, share, wanted),
    }
}

fn on_threads<S: Surface, M: Mount>(make: &Make, rig: &Rig<S, M>, modes: &[Mode], pixels: &Pixels, share: Share, wanted: usize) {
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
