//! `--with` and `--match`: other planes of the same exemplars, laid by the same weave, or deciding about it.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::Domain;
use selvedge_io::Info;

use crate::args::RoleArg;
use crate::exemplars::Headers;
use crate::failure::{Failure, n, shown};
use crate::planes::{Laying, PlaneHeaders, check_size};
use crate::roles;
use crate::session::Session;
use crate::used::Used;

/// Options about other planes of the exemplars.
#[derive(Args, Clone, Debug)]
pub(crate) struct With {
    /// Lay the same weave over other planes of the exemplars, such as the normals and heights of a material: a plane
    /// for each exemplar, in order (and for the picture of --over, after them); more of them make more outputs.
    /// '{name}' and '{stem}' in OUT stand for the name of exemplar and plane, with and without extension.
    #[arg(help_heading = "Other planes of the exemplars", long, value_name = "FILE", num_args = 1.., value_hint = ValueHint::FilePath)]
    pub(crate) with: Vec<PathBuf>,
    /// What the channels of the planes of --with mean: one for all, or one for each. By default names tell, as in
    /// wood_normal.png. Normals are turned with their samples, heights fused.
    #[arg(
        help_heading = "Other planes of the exemplars",
        long,
        value_enum,
        value_name = "ROLE",
        value_delimiter = ','
    )]
    pub(crate) role: Vec<RoleArg>,
    /// Copy heights of --with sample by sample as well: by default they are fused, or every seam would be a step.
    #[arg(help_heading = "Other planes of the exemplars", long)]
    pub(crate) copy: bool,
    /// Let other planes of the exemplars decide with them where samples go: a plane for each exemplar, in order.
    #[arg(help_heading = "Other planes of the exemplars", long = "match", value_name = "FILE", num_args = 1.., value_hint = ValueHint::FilePath)]
    pub(crate) matched: Vec<PathBuf>,
    /// How much each --match decides, in order, beside the exemplar's 1, however many channels it has; after the
    /// weights of each --guide, where there are any. Default: 1.
    #[arg(help_heading = "Other planes of the exemplars", long, value_name = "W", value_delimiter = ',')]
    pub(crate) weight: Vec<f64>,
}

impl With {
    /// Whether planes come along of which none decides where samples go: what is small then fits in the exemplar alone.
    pub(crate) fn is_blind(&self) -> bool {
        !self.with.is_empty() && self.matched.is_empty()
    }

    /// Checks what can be checked without a file; `guides` come before the planes that decide.
    pub(crate) fn validate(&self, exemplars: usize, guides: usize) -> Result<(), Failure> {
        for (files, flag) in [(&self.with, "--with"), (&self.matched, "--match")] {
            if !files.len().is_multiple_of(exemplars) {
                let what = format!("{} of {flag} for {}", n("plane", files.len()), n("exemplar", exemplars));
                return Err(Failure::new(2, what).remedy("give one for each, in order"));
            }
        }
        // Given by pictures and not by planes, they would be mixed.
        let told = |files: &[PathBuf]| files.iter().map(|path| roles::of_name(path)).collect::<Vec<_>>();
        let mixed = self.with.chunks(exemplars).find(|files| {
            let roles = told(files);
            roles.iter().flatten().any(|role| Some(*role) != roles[0] && roles[0].is_some())
        });
        if let (Some(files), true) = (mixed, self.role.is_empty()) {
            let names: Vec<String> = files.iter().map(|path| shown(path)).collect();
            let what = format!("{} are planes of different kinds, by their names", names.join(" and "));
            let remedy = "give all files of one plane, one for each exemplar and the picture of --over, then those of the next; or say what they are with --role";
            return Err(Failure::new(2, what).remedy(remedy));
        }
        if self.with.is_empty() && (!self.role.is_empty() || self.copy) {
            let flag = if self.copy { "--copy" } else { "--role" };
            let what = format!("{flag} says how planes of --with are laid, and there are none");
            return Err(Failure::new(2, what).remedy("leave it out, or give --with FILE"));
        }
        let (weights, layers) = (self.weight.len(), self.matched.len() / exemplars);
        if weights != 0 && weights != guides && weights != guides + layers {
            let matched = if layers == 0 { String::new() } else { format!(" and {}", n("match", layers)) };
            let (what, remedy) = if guides == 0 {
                (format!("{layers} --match"), "give one --weight for each --match, or none")
            } else {
                (format!("{}{matched}", n("guide", guides)), "give one --weight for each --guide, or none")
            };
            return Err(Failure::new(2, format!("{} for {what}", n("weight", weights))).remedy(remedy));
        }
        match self.weights(guides, layers).into_iter().find(|w| !w.is_finite() || *w < 0.0) {
            Some(weight) => {
                let failure = Failure::new(2, format!("a weight of {weight} cannot be used"));
                Err(failure.remedy("use --weight 0 or more"))
            }
            None => Ok(()),
        }
    }

    /// The weight of each plane that decides beside the exemplar, of so many.
    pub(crate) fn weights(&self, guides: usize, layers: usize) -> Vec<f64> {
        (0..layers).map(|i| self.weight.get(guides + i).copied().unwrap_or(1.0)).collect()
    }

    /// All files that are read.
    pub(crate) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.with.iter().chain(&self.matched)
    }

    /// The planes to lay, with their headers read.
    pub(crate) fn look(
        &self,
        session: &Session<'_>,
        laying: &Laying<'_>,
        headers: &Headers,
        pattern: &std::path::Path,
        output: Domain<2>,
    ) -> Result<Vec<PlaneHeaders>, Failure> {
        if self.with.is_empty() {
            return Ok(Vec::new());
        }
        let (names, domains) = (headers.paths(), headers.domains());
        let fits = |e: usize, path: &std::path::Path, info: &Info| check_size(path, info, names[e], domains[e].shape);
        let layers = laying.layers(session, &self.with, names.len(), pattern)?;
        layers.into_iter().map(|layer| laying.look(session, layer, output.shape, &fits)).collect()
    }

    /// The options as used: those that do nothing are not told. `roles` as they are typed.
    pub(crate) fn used(&self, used: Used, roles: Vec<String>) -> Used {
        let used = if self.matched.is_empty() { used.without("match") } else { used };
        let used = if self.weight.is_empty() || self.matched.is_empty() { used.without("weight") } else { used };
        let used = if self.copy { used } else { used.without("copy") };
        if self.with.is_empty() { without_planes(used) } else { used.set("role", roles) }
    }
}

/// Options as used for what no plane of --with changes: the picture itself, and the map.
pub(crate) fn without_planes(used: Used) -> Used {
    ["with", "role", "copy"].into_iter().fold(used, |used, name| if used.has(name) { used.without(name) } else { used })
}
