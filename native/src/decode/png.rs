//! PNG, all colour types and depths, interlaced or not. Chunk checksums are verified; the Adler sum inside adds nothing to them.

use std::io::{BufRead, Cursor, ErrorKind, Seek};

use ::png::{BitDepth, ColorType, Decoder, DecodingError, Reader, Transformations};

use super::samples::{Image, Samples};
use super::{checked_bytes, Decoded, TOO_LARGE, TRUNCATED};

fn refusal(error: DecodingError) -> String {
    match error {
        DecodingError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => TRUNCATED.into(),
        DecodingError::LimitsExceeded => TOO_LARGE.into(),
        error => format!("its PNG data are corrupt ({error})"),
    }
}

fn opened<R: BufRead + Seek>(source: R) -> Decoded<Reader<R>> {
    let mut decoder = Decoder::new(source);
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.read_info().map_err(refusal)
}

pub fn size(source: impl BufRead + Seek) -> Decoded<(usize, usize)> {
    let (width, height) = opened(source)?.info().size();
    Ok((width as usize, height as usize))
}

pub fn decode(data: &[u8], limit: usize) -> Decoded<Image> {
    let mut reader = opened(Cursor::new(data))?;
    let grey_palette = grey_palette(&reader);
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let (colour, depth) = reader.output_color_type();
    let sixteen = depth == BitDepth::Sixteen;
    let bytes = checked_bytes(width, height, colour.samples() * if sixteen { 2 } else { 1 }, limit)?;
    let mut buffer = vec![0; bytes];
    reader.next_frame(&mut buffer).map_err(refusal)?;
    reader.finish().map_err(refusal)?;
    let samples = match sixteen {
        true => Samples::Sixteen(buffer.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()),
        false => Samples::Eight(buffer),
    };
    Ok(match (samples, grey_palette) {
        (Samples::Eight(rgb), true) => {
            let grey = rgb.chunks_exact(colour.samples()).map(|pixel| pixel[0]).collect();
            Image { height, width, channels: 1, samples: Samples::Eight(grey) }
        }
        (samples, _) => Image::without_alpha((width, height), colour.samples(), samples),
    })
}

fn grey_palette<R: BufRead + Seek>(reader: &Reader<R>) -> bool {
    let info = reader.info();
    let grey = |palette: &[u8]| palette.chunks_exact(3).all(|colour| colour[0] == colour[1] && colour[1] == colour[2]);
    info.color_type == ColorType::Indexed && info.palette.as_deref().is_some_and(grey)
}
