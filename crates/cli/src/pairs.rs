//! `--guide`: pictures in pairs, of which one lies under the exemplars and the other under the output.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Grid, Guidance, Guide, Plane};
use selvedge_guides::encode_together;

use crate::failure::{Failure, n, shown};
use crate::followed::{self, Followed};
use crate::ground;
use crate::inputs::{Input, white};
use crate::loom::Loom;
use crate::used::Used;
use crate::weaving::Weaving;

/// Options about guides.
#[derive(Args, Clone, Debug)]
pub(crate) struct GuideArgs {
    /// Follow a picture of your own: one that lies under the exemplar, and one that lies under the output. With several
    /// exemplars write theirs as one list, separated by commas. May be given several times.
    #[arg(long, num_args = 2, value_names = ["SRC", "TGT"], value_hint = ValueHint::FilePath)]
    guide: Vec<PathBuf>,
}

/// Options about guides that are followed as one.
#[derive(Args, Clone, Debug)]
pub(crate) struct GuidanceArgs {
    #[command(flatten)]
    guides: GuideArgs,
    /// Follow what each --guide asks for only where this picture is white; elsewhere the texture goes on as it likes.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath, requires = "guide")]
    guide_where: Option<PathBuf>,
}

impl GuidanceArgs {
    /// How many guides there are.
    pub(crate) fn len(&self) -> usize {
        self.guides.len()
    }

    /// Channels of all of them, at most.
    pub(crate) fn channels(&self) -> usize {
        self.guides.len() * 3
    }

    /// The pairs that were typed.
    pub(crate) fn pairs(&self, weaving: &Weaving) -> Result<Vec<Pair>, Failure> {
        self.guides.pairs(weaving)
    }

    /// Files that are read beside the pairs'.
    pub(crate) fn mask(&self) -> Option<&PathBuf> {
        self.guide_where.as_ref()
    }

    /// All that is followed as one guide, with the weight of all together; pictures of no weight are not read.
    pub(crate) fn guidance(&self, loom: &mut Loom<'_>, weaving: &Weaving) -> Result<Option<Guidance<2>>, Failure> {
        let pairs: Vec<Pair> = self.pairs(weaving)?.into_iter().filter(|pair| pair.weight != 0.0).collect();
        if pairs.is_empty() {
            return Ok(None);
        }
        let guides = pairs.iter().map(|pair| Ok((pair.read(loom)?, pair.weight)));
        let guides = guides.collect::<Result<Vec<(Guide<2>, f64)>, Failure>>()?;
        let guide = Guide::join(&guides).map_err(|e| Failure::from(e).remedy("change --weight"))?;
        let guide = match &self.guide_where {
            Some(path) => {
                let mask = loom.read(&Input::new(loom.session, path)?)?;
                check_shape(path, &mask, loom.domain.shape, "the output")?;
                guide.asking(white(&mask, path)?)?
            }
            None => guide,
        };
        Ok(Some(Guidance { guide, weight: pairs.iter().map(|pair| pair.weight).sum() }))
    }

    /// The options as used; none where nothing is followed.
    pub(crate) fn used(&self, loom: &Loom<'_>, used: Used) -> Used {
        if self.len() == 0 { used } else { self.guides.used(loom, used) }
    }
}

/// Files of one `--guide`.
pub(crate) struct Pair {
    /// One an exemplar.
    pub(crate) sources: Vec<PathBuf>,
    pub(crate) target: PathBuf,
    pub(crate) weight: f64,
}

impl GuideArgs {
    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.guide.len() / 2
    }

    /// The same with other pictures under the output.
    pub(crate) fn over(&self, target: impl Fn(&Path) -> PathBuf) -> Self {
        let of = |(i, file): (usize, &PathBuf)| if i % 2 == 1 { target(file) } else { file.clone() };
        Self { guide: self.guide.iter().enumerate().map(of).collect() }
    }

    /// The pictures under the output.
    pub(crate) fn targets(&self) -> impl Iterator<Item = &PathBuf> {
        self.guide.iter().skip(1).step_by(2)
    }

    /// The pairs that were typed, each with its weight.
    pub(crate) fn pairs(&self, weaving: &Weaving) -> Result<Vec<Pair>, Failure> {
        let exemplars = weaving.input.exemplars.len();
        weaving.with.validate(exemplars, self.len())?;
        let pair = |(i, files): (usize, &[PathBuf])| {
            let sources = listed(&files[0], exemplars, "--guide one SRC")?;
            Ok(Pair { sources, target: files[1].clone(), weight: weaving.with.weight.get(i).copied().unwrap_or(1.0) })
        };
        self.guide.chunks(2).enumerate().map(pair).collect()
    }

    /// The options as used: files by their names, and weights, which count even where no plane decides with the
    /// exemplars.
    pub(crate) fn used(&self, loom: &Loom<'_>, used: Used) -> Used {
        let name = |path: &PathBuf| selvedge_io::display_name(path);
        let files = |list: &PathBuf| files_of(list, loom.loaded.paths.len());
        let names = |list: &PathBuf| files(list).iter().map(name).collect::<Vec<_>>().join(",");
        let pairs: Vec<_> = self.guide.chunks(2).map(|pair| vec![names(&pair[0]), name(&pair[1])]).collect();
        let used = used.set("guide", pairs);
        if used.has("weight") { used } else { used.with("weight", loom.args.with.weight.clone()) }
    }
}

impl Pair {
    /// All files.
    pub(crate) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.sources.iter().chain(std::iter::once(&self.target))
    }

    /// The guide that the pictures make.
    pub(crate) fn read(&self, loom: &mut Loom<'_>) -> Result<Guide<2>, Failure> {
        let pictures = Followed::all(loom, self.files())?;
        let (under, over) = pictures.split_at(self.sources.len());
        for (i, (path, one)) in self.sources.iter().zip(under).enumerate() {
            check_under(loom, i, path, &one.plane)?;
        }
        check_shape(&self.target, &over[0].plane, loom.domain.shape, "the output")?;
        let planes: Vec<&Plane<2>> = pictures.iter().map(|one| &one.plane).collect();
        let mut maps = encode_together(&planes).map_err(|e| Failure::from(e).about(&self.target))?;
        let target = maps.pop().expect("the target's");
        over_ground(loom, &mut maps, &target)?;
        let guide = Guide::new(&loom.loaded.exemplars, &maps, target.with_periodic(loom.domain.periodic))?;
        followed::seen(guide, under, &over[0]).map_err(|e| e.about(&self.sources[0]))
    }
}

/// Under a picture that is gone on from lies what is asked for there: what stands is right.
pub(crate) fn over_ground(loom: &Loom<'_>, maps: &mut Vec<Grid<u8, 2>>, target: &Grid<u8, 2>) -> Result<(), Failure> {
    while maps.len() < loom.loaded.payload.len() {
        maps.push(target.map(|v| v)?);
    }
    Ok(())
}

/// The files of a list, one an exemplar; a name in it is that of a file where there is one exemplar. `asked` is what to
/// give.
pub(crate) fn listed(list: &Path, exemplars: usize, asked: &str) -> Result<Vec<PathBuf>, Failure> {
    let files = files_of(list, exemplars);
    if files.len() == exemplars {
        return Ok(files);
    }
    let what = format!("'{}' names {} for {}", shown(list), n("file", files.len()), n("exemplar", exemplars));
    Err(Failure::new(2, what).remedy(format!("give {asked} for each, separated by commas")))
}

fn files_of(list: &Path, exemplars: usize) -> Vec<PathBuf> {
    match list.to_str() {
        Some(text) if exemplars != 1 => text.split(',').map(PathBuf::from).collect(),
        _ => vec![list.to_path_buf()],
    }
}

/// Refuses a picture that does not lie under an exemplar.
pub(crate) fn check_under(loom: &Loom<'_>, exemplar: usize, path: &Path, plane: &Plane<2>) -> Result<(), Failure> {
    let of = shown(&loom.loaded.paths[exemplar]);
    check_shape(path, plane, loom.loaded.payload[exemplar].domain().shape, &of)
}

fn check_shape(path: &Path, plane: &Plane<2>, expected: [u32; 2], of: &str) -> Result<(), Failure> {
    let of = format!("{of} has");
    ground::check_size(path, plane.domain().shape, Some(expected), &of, "give a guide of the same size")
}
