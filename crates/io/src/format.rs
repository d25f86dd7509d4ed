//! The formats: what they are called, how they begin, and what they hold.

use std::fmt;
use std::path::Path;

use crate::Depth;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// Tagged Image File Format.
    Tiff,
    /// OpenEXR.
    Exr,
    /// Radiance RGBE. Shares one exponent between three 8-bit channels.
    Hdr,
    /// WebP; written lossless.
    Webp,
    /// Graphics Interchange Format; only read.
    Gif,
    /// Windows bitmap; only read.
    Bmp,
    /// Truevision TGA.
    Tga,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 9] =
        [Self::Png, Self::Jpeg, Self::Tiff, Self::Exr, Self::Hdr, Self::Webp, Self::Tga, Self::Gif, Self::Bmp];

    /// Its name in messages and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpeg",
            Self::Tiff => "tiff",
            Self::Exr => "exr",
            Self::Hdr => "hdr",
            Self::Webp => "webp",
            Self::Gif => "gif",
            Self::Bmp => "bmp",
            Self::Tga => "tga",
        }
    }

    /// The format of a name or an extension without its dot, in any case.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "png" | "apng" => Self::Png,
            "jpg" | "jpeg" | "jpe" | "jfif" => Self::Jpeg,
            "tif" | "tiff" => Self::Tiff,
            "exr" => Self::Exr,
            "hdr" | "pic" | "rgbe" => Self::Hdr,
            "webp" => Self::Webp,
            "gif" => Self::Gif,
            "bmp" | "dib" => Self::Bmp,
            "tga" | "targa" | "icb" | "vda" | "vst" => Self::Tga,
            _ => return None,
        })
    }

    /// The format that a name's extension stands for.
    pub fn of_name(path: &Path) -> Option<Self> {
        Self::of_extension(path.extension()?.to_str()?)
    }

    /// The format whose files begin like this; 18 bytes suffice. TGA has no signature: what is nothing else and has a
    /// header as that of TGA is, is one.
    pub fn of_content(start: &[u8]) -> Option<Self> {
        let signatures: [(&[u8], Self); 11] = [
            (b"\x89PNG\r\n\x1a\n", Self::Png),
            (b"\xff\xd8\xff", Self::Jpeg),
            (b"II\x2a\0", Self::Tiff),
            (b"MM\0\x2a", Self::Tiff),
            (b"II\x2b\0", Self::Tiff),
            (b"MM\0\x2b", Self::Tiff),
            (b"\x76\x2f\x31\x01", Self::Exr),
            (b"#?", Self::Hdr),
            (b"GIF87a", Self::Gif),
            (b"GIF89a", Self::Gif),
            (b"BM", Self::Bmp),
        ];
        let known = signatures.iter().find(|(signature, _)| start.starts_with(signature)).map(|(_, format)| *format);
        let webp = start.starts_with(b"RIFF") && start.get(8..12) == Some(b"WEBP");
        let tga = unread(start).is_none() && is_tga(start);
        known.or(webp.then_some(Self::Webp)).or(tga.then_some(Self::Tga))
    }

    /// The depths that can be written, the deepest last; none where files are only read.
    ///
    /// Half and float in Radiance HDR are rounded to its 8-bit mantissas; negative values become 0.
    pub const fn depths(self) -> &'static [Depth] {
        match self {
            Self::Png => &[Depth::U8, Depth::U16],
            Self::Jpeg | Self::Webp | Self::Tga => &[Depth::U8],
            Self::Tiff => &[Depth::U8, Depth::U16, Depth::F16, Depth::F32],
            Self::Exr | Self::Hdr => &[Depth::F16, Depth::F32],
            Self::Gif | Self::Bmp => &[],
        }
    }

    /// Names of all formats that can be read.
    pub(crate) fn read() -> String {
        names(|_| true)
    }

    /// Names of all formats that can be written.
    pub(crate) fn written() -> String {
        names(|f| !f.depths().is_empty())
    }

    /// Names of the other formats that hold one of its depths, of those that `which` lets pass.
    pub(crate) fn instead(self, which: impl Fn(Self) -> bool) -> String {
        let all = names(|f| f != self && which(f) && f.depths().iter().any(|d| self.depths().contains(d)));
        all.rsplit_once(", ").map_or(all.clone(), |(some, last)| format!("{some} or {last}"))
    }

    /// Names of the formats that hold a depth.
    pub fn holding(depth: Depth) -> String {
        names(|f| f.depths().contains(&depth))
    }
}

/// Whether a header is one of TGA: palettes or none, a known kind, bits that there are, and samples.
fn is_tga(start: &[u8]) -> bool {
    let Some(&[_, palette, kind, .., w0, w1, h0, h1, bits, descriptor]) = start.first_chunk::<18>() else {
        return false;
    };
    let mapped = matches!(kind, 1 | 9);
    let kinds = mapped || matches!(kind, 2 | 3 | 10 | 11);
    let sides = [w0, w1] != [0, 0] && [h0, h1] != [0, 0];
    kinds
        && palette <= 1
        && (palette == 1 || !mapped)
        && matches!(bits, 8 | 15 | 16 | 24 | 32)
        && sides
        && descriptor < 64
}

/// The name of a format that is known and not read.
pub(crate) fn unread(start: &[u8]) -> Option<&'static str> {
    let signatures: [(usize, &[u8], &str); 12] = [
        (0, b"8BPS", "a Photoshop file"),
        (0, b"DDS ", "a DDS file"),
        (0, b"\xff\x0a", "a JPEG XL file"),
        (0, b"\0\0\0\x0cJXL ", "a JPEG XL file"),
        (0, b"\0\0\0\x0cjP  ", "a JPEG 2000 file"),
        (0, b"\xff\x4f\xff\x51", "a JPEG 2000 file"),
        (4, b"ftypavif", "an AVIF file"),
        (4, b"ftypheic", "a HEIF file"),
        (4, b"ftypmif1", "a HEIF file"),
        (0, b"\xabKTX ", "a KTX file"),
        (0, b"gimp xcf", "a GIMP file"),
        (0, b"%PDF", "a PDF file"),
    ];
    let known =
        |&&(at, signature, _): &&(usize, &[u8], &str)| start.get(at..).is_some_and(|s| s.starts_with(signature));
    signatures.iter().find(known).map(|(_, _, name)| *name)
}

fn names(which: impl Fn(Format) -> bool) -> String {
    Format::ALL.iter().filter(|f| which(**f)).map(|f| f.name()).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_extensions_agree() {
        for format in Format::ALL {
            assert_eq!(Format::of_extension(format.name()), Some(format));
        }
        assert_eq!(Format::of_name(Path::new("a.b/C.JPG")), Some(Format::Jpeg));
        assert_eq!(Format::of_name(Path::new("png")), None);
    }

    #[test]
    fn what_is_known_and_not_read_is_no_tga() {
        assert_eq!(unread(b"8BPS\0\x01\0\0\0\0\0\0\0\x03\0\0\0\x10"), Some("a Photoshop file"));
        assert_eq!(unread(b"\0\0\0 ftypavif"), Some("an AVIF file"));
        let tga =
            |kind, bits, side| Format::of_content(&[0, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, side, 0, 1, 0, bits, 32]);
        assert_eq!([tga(2, 24, 1), tga(10, 32, 9), tga(3, 8, 1)], [Some(Format::Tga); 3]);
        assert_eq!([tga(1, 8, 1), tga(2, 7, 1), tga(2, 24, 0), tga(0, 24, 1)], [None; 4]);
        assert_eq!(Format::of_content(b"just a line of text that says nothing"), None);
    }
}
