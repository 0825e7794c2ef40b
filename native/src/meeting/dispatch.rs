//! The widest vector instructions of this machine, and its cores. Neither changes a byte of the results.

pub trait Work {
    /// Inlined into a function that may use wide instructions.
    fn run(self);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma,avx512f,avx512dq,avx512bw,avx512vl")]
fn with_avx512<W: Work>(work: W) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma,avx2")]
fn with_avx2<W: Work>(work: W) {
    work.run();
}

pub fn widest<W: Work>(work: W) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        if has!("fma") && has!("avx512f") && has!("avx512dq") && has!("avx512bw") && has!("avx512vl") {
            // SAFETY: the processor has what the function needs
            return unsafe { with_avx512(work) };
        }
        if has!("avx2") && has!("fma") {
            // SAFETY: as above
            return unsafe { with_avx2(work) };
        }
    }
    work.run();
}

/// Threads worth starting for `tasks`, each of which is worth one; `wanted` 0 means all cores.
pub fn threads(wanted: usize, tasks: usize) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    (if wanted == 0 { cores() } else { wanted }).clamp(1, tasks.max(1))
}
