//! Image files: whatever the bytes, a whole image within the limit, or a sentence.

use std::time::Duration;

use _native::entries::decode::{declared, decoded};

use crate::guarded;

/// Bytes that an image may have here: small, so that millions can be tried.
const LIMIT: usize = 1 << 22;
/// Times the limit, and bytes: what a decoder may hold besides the image. A progressive JPEG keeps 16 bit coefficients of every sample, a
/// palette is widened, and strips are decoded aside.
const TIMES: usize = 5;
const BESIDES: usize = 4 << 20;
/// Times the file: it is copied where its end is mended.
const COPIES: usize = 4;
const LONGEST: Duration = Duration::from_secs(5);

/// Data that begin like the format, so that no time is spent on others.
pub fn read(data: &[u8], signature: &[u8]) {
    let mut file = data.to_vec();
    if file.len() >= signature.len() {
        file[..signature.len()].copy_from_slice(signature);
    }
    check(&file);
}

/// One file.
pub fn check(file: &[u8]) {
    let most = TIMES * LIMIT + BESIDES + COPIES * file.len();
    let image = guarded(most, LONGEST, || decoded(file, LIMIT));
    let size = guarded(BESIDES + COPIES * file.len(), LONGEST, || declared(file));
    match image {
        Ok((height, width, channels, samples, bytes)) => {
            assert!(height > 0 && width > 0 && (channels == 1 || channels == 3), "an image of {height} x {width} x {channels}");
            assert_eq!(samples, height * width * channels, "samples");
            assert!(samples * bytes <= LIMIT, "{samples} samples of {bytes} bytes are above the limit");
            assert_eq!(size, Ok((width, height)), "the header's size");
        }
        Err(why) => sentence(&why),
    }
    if let Err(why) = size {
        sentence(&why);
    }
}

/// The middle of a sentence, which people can read.
fn sentence(why: &str) {
    assert!(!why.is_empty() && why.len() < 400 && !why.contains('\n'), "no sentence: {why:?}");
}
