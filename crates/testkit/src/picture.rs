//! A picture as the tests hold it: planar samples of 8 or 16 bits, and PNG.

use std::io::{self, BufRead, Seek};

/// Samples in the depth of the file, plane by plane, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits a sample.
    U8(Vec<u8>),
    /// 16 bits a sample.
    U16(Vec<u16>),
}

/// A planar picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Planes: 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha.
    pub channels: usize,
    /// `width * height * channels` samples.
    pub samples: Depth,
}

impl Picture {
    /// 8-bit grey.
    pub fn grey8(width: u32, height: u32, samples: Vec<u8>) -> Self {
        Self { width, height, channels: 1, samples: Depth::U8(samples) }.checked()
    }

    /// 16-bit grey.
    pub fn grey16(width: u32, height: u32, samples: Vec<u16>) -> Self {
        Self { width, height, channels: 1, samples: Depth::U16(samples) }.checked()
    }

    /// 8-bit RGB, three planes one after the other.
    pub fn rgb8(width: u32, height: u32, samples: Vec<u8>) -> Self {
        Self { width, height, channels: 3, samples: Depth::U8(samples) }.checked()
    }

    fn checked(self) -> Self {
        let len = match &self.samples {
            Depth::U8(s) => s.len(),
            Depth::U16(s) => s.len(),
        };
        assert_eq!(len, self.width as usize * self.height as usize * self.channels, "planes of equal size");
        self
    }

    /// The picture as a PNG file, packed as tightly as the encoder can.
    pub fn to_png(&self) -> Vec<u8> {
        let (color, bytes) = (color_type(self.channels), self.interleaved());
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width, self.height);
        encoder.set_color(color);
        encoder.set_depth(match self.samples {
            Depth::U8(_) => png::BitDepth::Eight,
            Depth::U16(_) => png::BitDepth::Sixteen,
        });
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header().expect("writing to memory");
        writer.write_image_data(&bytes).expect("writing to memory");
        writer.finish().expect("writing to memory");
        file
    }

    /// Reads a PNG of 8 or 16 bits without a palette.
    ///
    /// # Errors
    /// What the decoder says, or that the kind of PNG is another.
    pub fn from_png(file: impl BufRead + Seek) -> io::Result<Self> {
        let mut reader = png::Decoder::new(file).read_info().map_err(io::Error::other)?;
        let size = reader.output_buffer_size().ok_or_else(|| io::Error::other("too large"))?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes).map_err(io::Error::other)?;
        let channels = info.color_type.samples();
        let samples = match info.bit_depth {
            png::BitDepth::Eight => Depth::U8(planar(&bytes, channels)),
            png::BitDepth::Sixteen => {
                let wide: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
                Depth::U16(planar(&wide, channels))
            }
            other => return Err(io::Error::other(format!("{other:?} bits a sample"))),
        };
        Ok(Self { width: info.width, height: info.height, channels, samples })
    }

    fn interleaved(&self) -> Vec<u8> {
        let area = self.width as usize * self.height as usize;
        let order = (0..area).flat_map(|p| (0..self.channels).map(move |c| c * area + p));
        match &self.samples {
            Depth::U8(s) => order.map(|i| s[i]).collect(),
            Depth::U16(s) => order.flat_map(|i| s[i].to_be_bytes()).collect(),
        }
    }
}

fn planar<T: Copy>(interleaved: &[T], channels: usize) -> Vec<T> {
    (0..channels).flat_map(|c| interleaved.iter().skip(c).step_by(channels).copied()).collect()
}

fn color_type(channels: usize) -> png::ColorType {
    match channels {
        1 => png::ColorType::Grayscale,
        2 => png::ColorType::GrayscaleAlpha,
        3 => png::ColorType::Rgb,
        4 => png::ColorType::Rgba,
        n => panic!("a PNG has 1 to 4 channels, not {n}"),
    }
}
