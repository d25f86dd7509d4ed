//! Windows bitmaps, read.

use image::codecs::bmp::BmpDecoder;

use super::complaint;
use crate::Format;
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;

pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    super::describe(&mut open(input, context)?, Format::Bmp, context)
}

pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    super::decode(open(input, context)?, Format::Bmp, context)
}

fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<BmpDecoder<&'a mut dyn Input>, Problem> {
    BmpDecoder::new(input).map_err(|e| complaint(e, Format::Bmp, context))
}
