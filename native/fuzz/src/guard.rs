//! Bounds on one call: its peak of memory, the processor time it took, and whose panic it was.

use std::alloc::{GlobalAlloc, Layout, System};
use std::panic;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::Once;
use std::time::Duration;

/// The system's allocator, counting.
pub struct Counting;

/// s of processor time
const HANGING: i64 = 60;
static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is passed on to the system's allocator
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Relaxed) + layout.size();
        MOST.fetch_max(held, Relaxed);
        System.alloc(layout)
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Relaxed) + layout.size();
        MOST.fetch_max(held, Relaxed);
        System.alloc_zeroed(layout)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        System.dealloc(pointer, layout)
    }
}

#[repr(C)]
struct Timespec(i64, i64);

#[repr(C)]
struct Timer {
    interval: Timespec,
    value: Timespec,
}

extern "C" {
    fn clock_gettime(clock: i32, time: *mut Timespec) -> i32;
    fn setitimer(which: i32, new: *const Timer, old: *mut Timer) -> i32;
    fn signal(number: i32, handler: extern "C" fn(i32)) -> usize;
}

/// libFuzzer's own time limit is of the wall, and a run may be stopped for minutes.
extern "C" fn hanging(_: i32) {
    std::process::abort();
}

/// From now on a call is ended after `seconds` of processor time; 0: it is not.
fn end_after(seconds: i64) {
    const OF_PROCESSOR: i32 = 2;
    const SIGNAL: i32 = 27;
    let timer = Timer { interval: Timespec(0, 0), value: Timespec(seconds, 0) };
    // SAFETY: a timeval on Linux is two 64 bit numbers too, and the handler touches nothing
    unsafe {
        signal(SIGNAL, hanging);
        setitimer(OF_PROCESSOR, &timer, std::ptr::null_mut());
    }
}

/// Processor time of this process, that of a machine which does other things too.
fn processor() -> Duration {
    const PROCESS: i32 = 2;
    let mut time = Timespec(0, 0);
    // SAFETY: a timespec on Linux is two 64 bit numbers
    unsafe { clock_gettime(PROCESS, &mut time) };
    Duration::new(time.0 as u64, time.1 as u32)
}

/// Panics of other crates' decoders are caught and told as errors (`decode::guarded`); ours are defects.
fn only_our_panics_abort() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let _ = panic::take_hook();
        panic::set_hook(Box::new(|panic| {
            let ours = panic.location().is_none_or(|place| !place.file().contains("/registry/"));
            if ours {
                eprintln!("{panic}\n{}", std::backtrace::Backtrace::force_capture());
                std::process::abort();
            }
            eprintln!("caught: {}", panic.location().map(ToString::to_string).unwrap_or_default());
        }));
    });
}

/// `work`, which may hold `most` bytes more than before and take `longest` of processor time.
pub fn guarded<R>(most: usize, longest: Duration, work: impl FnOnce() -> R) -> R {
    only_our_panics_abort();
    let (held, from) = (HELD.load(Relaxed), processor());
    MOST.store(held, Relaxed);
    end_after(HANGING);
    let result = work();
    end_after(0);
    let (peak, took) = (MOST.load(Relaxed).saturating_sub(held), processor() - from);
    assert!(peak <= most, "the call held {peak} bytes, {most} are allowed");
    assert!(took <= longest, "the call took {took:?} of the processor, {longest:?} are allowed");
    result
}
