//! The vector instructions of this machine. They change no byte of the results: nothing is added in another order, nothing is fused.

/// Whether AVX2 may be used: it is wanted, and the processor has it.
#[derive(Clone, Copy)]
pub struct Vectors(bool);

impl Vectors {
    pub fn detected(wanted: bool) -> Vectors {
        #[cfg(target_arch = "x86_64")]
        let known = std::arch::is_x86_feature_detected!("avx2");
        #[cfg(not(target_arch = "x86_64"))]
        let known = false;
        Vectors(wanted && known)
    }

    pub fn allowed(self) -> bool {
        self.0
    }
}

/// `work(arguments)`, a function that is always inlined, here into one that may use AVX2 where `vectors` allow it.
macro_rules! vectorised {
    ($vectors:expr, $work:ident $(<$kind:ident: $bound:path>)? ($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {{
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2")]
            fn wide $(<$kind: $bound>)? ($($argument: $type),*) $(-> $result)? {
                $work($($argument),*)
            }
            if $vectors.allowed() {
                // SAFETY: the processor has what the function needs, or there would be no such `Vectors`
                return unsafe { wide($($argument),*) };
            }
        }
        $work($($argument),*)
    }};
}

pub(super) use vectorised;
