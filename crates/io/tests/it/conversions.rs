//! Alpha and colour tags between formats: what stays to the bit, what is converted, and what is told.

use crate::common::bits;
use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{
    Association, Depth, Format, Metadata, Problem, ReadOptions, Warning, WriteOptions, associate, changes, convert,
    decode, encode,
};

const ASSOCIATIONS: [Association; 2] = [Association::Straight, Association::Premultiplied];

fn write(plane: &Plane<2>, metadata: &Metadata, format: Format) -> Result<Vec<u8>, Problem> {
    let options = WriteOptions { format: Some(format), ..WriteOptions::default() };
    encode(plane, metadata, "a", &options).map_err(|e| e.problem)
}

fn read(bytes: &[u8]) -> selvedge_io::Picture {
    decode(bytes, "a", &ReadOptions::default()).unwrap()
}

/// Colours and alphas of any kind, valid in this association.
fn plane(depth: Depth, association: Association, colors: usize) -> Plane<2> {
    let domain = Domain::open([7, 9]);
    let values: Vec<u8> = (0..domain.len() * (colors + 1)).map(|i| (i * 37 % 251) as u8).collect();
    let bytes = Samples::U8(Grid::from_vec(domain, colors + 1, values).unwrap());
    let straight = Plane::with_alpha(Role::Color, bytes);
    let deep = convert(&straight, depth, &Metadata::default()).unwrap().plane;
    associate(&deep, association).unwrap().plane
}

#[test]
fn every_format_depth_and_association() {
    let mut same = 0;
    for format in Format::ALL {
        for (depth, association, colors) in format
            .depths()
            .iter()
            .flat_map(|d| ASSOCIATIONS.map(|a| (*d, a)))
            .flat_map(|(d, a)| [1, 3].map(|c| (d, a, c)))
        {
            // WebP makes three channels of grey.
            if format.check([7, 9], colors, true, depth).is_err() || (format, colors) == (Format::Webp, 1) {
                continue;
            }
            let plane = plane(depth, association, colors);
            let told = changes(&plane, &Metadata::default(), format);
            let back = read(&write(&plane, &Metadata::default(), format).unwrap()).plane;
            let what = format!("{format} {depth:?} {association:?} {colors}");
            assert_eq!(back.association, format.association().unwrap_or(association), "{what}");
            if back.association == association {
                same += 1;
                assert_eq!((bits(&back), told), (bits(&plane), vec![]), "{what}");
                continue;
            }
            let expected = match association {
                Association::Straight => Warning::Multiplied { format },
                Association::Premultiplied => Warning::Divided { format },
            };
            assert_eq!(told, [expected], "{what}");
            assert_eq!(bits(&back), bits(&associate(&plane, back.association).unwrap().plane), "{what}");
        }
    }
    assert_eq!(same, 27, "png 4, webp 1, tga 2, exr 4, and all of tiff");
}

/// One sample of 8 bits.
fn sample(values: [u8; 4], association: Association) -> Plane<2> {
    let grid = Grid::from_vec(Domain::open([1, 1]), 4, values.to_vec()).unwrap();
    Plane { association, ..Plane::with_alpha(Role::Color, Samples::U8(grid)) }
}

fn values(plane: &Plane<2>) -> Vec<f64> {
    (0..plane.samples.channels()).map(|c| plane.samples.value(c, 0)).collect()
}

#[test]
fn associated_tiff_becomes_straight_png() {
    let tiff = write(&sample([56, 52, 44, 128], Association::Premultiplied), &Metadata::default(), Format::Tiff);
    let associated = read(&tiff.unwrap()).plane;
    assert_eq!(associated.association, Association::Premultiplied);
    let png = write(&associated, &Metadata::default(), Format::Png).unwrap();
    assert_eq!(values(&read(&png).plane), [112.0, 104.0, 88.0, 128.0]);
}

#[test]
fn integers_and_exr_meet_in_linear_light() {
    let straight = sample([111, 104, 88, 128], Association::Straight);
    for depth in [Depth::F16, Depth::F32] {
        let floats = convert(&straight, depth, &Metadata::default()).unwrap().plane;
        let exr = read(&write(&floats, &Metadata::default(), Format::Exr).unwrap()).plane;
        let light = selvedge_core::srgb_decode(111.0 / 255.0) * 128.0 / 255.0;
        assert!((values(&exr)[0] - light).abs() < 1e-4, "{:?}", values(&exr));
        let back = convert(&exr, Depth::U8, &Metadata::default()).unwrap().plane;
        assert_eq!(back, straight);
    }
    // Associated integers were multiplied as they are stored, so they are divided before they become light.
    let associated = sample([56, 52, 44, 128], Association::Premultiplied);
    let light = convert(&associated, Depth::F32, &Metadata::default()).unwrap().plane;
    assert_eq!(light.association, Association::Straight);
    assert!((values(&light)[0] - selvedge_core::srgb_decode(56.0 / 128.0)).abs() < 1e-6);
}

#[test]
fn light_without_alpha_survives_exr_and_is_refused_elsewhere() {
    let grid = Grid::from_vec(Domain::open([1, 2]), 4, vec![0.0, 3.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0]).unwrap();
    let fire = Plane::with_alpha(Role::Color, Samples::F32(grid));
    let fire = Plane { association: Association::Premultiplied, ..fire };
    let once = write(&fire, &Metadata::default(), Format::Exr).unwrap();
    assert_eq!(bits(&read(&once).plane), bits(&fire));
    assert_eq!(write(&read(&once).plane, &Metadata::default(), Format::Exr).unwrap(), once);
    assert_eq!(read(&write(&fire, &Metadata::default(), Format::Tiff).unwrap()).plane, fire, "tiff says so too");
    let refused = convert(&fire, Depth::U8, &Metadata::default()).unwrap_err();
    assert!(matches!(refused, Problem::LightWithoutAlpha { count: 1, x: 1, y: 0 }), "{refused}");
    assert!(refused.remedy().contains("[R,G,B]"));
}

#[test]
fn cicp_is_carried_by_png_and_told_elsewhere() {
    let opaque = Plane::new(Role::Color, Samples::U8(Grid::try_filled(Domain::open([2, 2]), 3, 9).unwrap()));
    for cicp in [[12, 13, 0, 1], [9, 16, 0, 1]] {
        let tagged = Metadata { cicp: Some(cicp), ..Metadata::default() };
        assert_eq!(changes(&opaque, &tagged, Format::Png), []);
        let back = read(&write(&opaque, &tagged, Format::Png).unwrap());
        assert_eq!(back.metadata, tagged);
        for format in [Format::Tiff, Format::Jpeg, Format::Webp] {
            assert_eq!(changes(&opaque, &tagged, format), [Warning::TagLeftOut { tag: "cicp tag", format }]);
        }
    }
}

#[test]
fn tags_without_a_place_are_told() {
    let plane =
        |colors| Plane::new(Role::Color, Samples::U8(Grid::try_filled(Domain::open([1, 1]), colors, 9).unwrap()));
    let told = |metadata: &Metadata, colors: usize, format| -> Vec<&'static str> {
        let all = changes(&plane(colors), metadata, format);
        all.into_iter().map(|w| if let Warning::TagLeftOut { tag, .. } = w { tag } else { "" }).collect()
    };
    let gamma = Metadata { gamma: Some(100_000), ..Metadata::default() };
    assert_eq!(told(&gamma, 3, Format::Png), [""; 0]);
    assert_eq!(told(&gamma, 3, Format::Tiff), ["gamma tag"]);
    let srgb = Metadata { gamma: Some(45_455), srgb: Some(0), cicp: Some([1, 13, 0, 1]), ..Metadata::default() };
    assert_eq!(told(&srgb, 3, Format::Jpeg), [""; 0], "what everyone takes for granted");
    let grey = Metadata { icc: Some(crate::common::profile(b"GRAY")), ..Metadata::default() };
    for format in [Format::Png, Format::Tiff, Format::Jpeg, Format::Webp] {
        assert_eq!(told(&grey, 1, format), [""; 0]);
        assert_eq!(told(&grey, 3, format), ["colour profile"], "{format}");
    }
    let wide = [0.3127, 0.329, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06];
    let wide = Metadata { chromaticities: Some(wide), ..Metadata::default() };
    assert_eq!(told(&wide, 3, Format::Exr), [""; 0]);
    assert_eq!(told(&wide, 3, Format::Hdr), ["chromaticities"]);
}

#[test]
fn tags_are_followed_where_integers_become_light() {
    let grey = Plane::new(Role::Color, Samples::U8(Grid::try_filled(Domain::open([1, 1]), 3, 128).unwrap()));
    let linear = Metadata { gamma: Some(100_000), ..Metadata::default() };
    let light = convert(&grey, Depth::F32, &linear).unwrap();
    assert_eq!((values(&light.plane)[0] as f32, light.warnings.len()), (128.0 / 255.0, 0));
    let other = Plane { role: Role::Scalar, ..grey.clone() };
    assert_eq!(values(&convert(&other, Depth::F32, &linear).unwrap().plane)[0] as f32, 128.0 / 255.0);
    let pq = Metadata { cicp: Some([9, 16, 0, 1]), ..Metadata::default() };
    assert_eq!(convert(&grey, Depth::F16, &pq).unwrap().warnings, [Warning::TagNotFollowed { tag: "cicp tag" }]);
    assert!(pq.converted(Depth::U8, Depth::F16).chromaticities.is_some_and(|c| c[2] == 0.708));
}
