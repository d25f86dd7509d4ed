//! `selvedge score`: what outputs are worth beside their exemplars.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Encoder, Event, Exemplar, Exemplars, Plane, Role, SourceMap, Transform};
use selvedge_io::{Fingerprint, Info, MapFile};
use selvedge_metrics::{Columns, Error, Judge, preference};
use serde_json::{Value, json};

use crate::failure::{Failure, are, n as count, shown};
use crate::ground::{check_size, made_of_another};
use crate::harmonise::{Layout, common_layout, widened};
use crate::inputs::{self, Input};
use crate::options::NonFinite;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::{memory, outputs};

/// Bytes of exemplars that outputs are judged by, for each sample and channel: 96 are seen of three channels.
const A_CHANNEL: u64 = 100;

/// Options of `score`.
#[derive(Args, Debug)]
pub(crate) struct Score {
    /// Pictures that were made from the exemplars; several of one size are ranked, best first.
    #[arg(required = true, value_name = "OUT", value_hint = ValueHint::FilePath)]
    outputs: Vec<PathBuf>,
    /// An exemplar that they were made from; give each.
    #[arg(long, required = true, value_name = "EXEMPLAR", value_hint = ValueHint::FilePath)]
    exemplar: Vec<PathBuf>,
    /// The source map of each output, in order; without, what seams cost is not told.
    #[arg(long, value_name = "FILE.exr", value_hint = ValueHint::FilePath)]
    map: Vec<PathBuf>,
    #[command(flatten)]
    nonfinite: NonFinite,
}

impl Score {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("score");
        let files: Vec<PathBuf> = self.exemplar.iter().chain(&self.outputs).chain(&self.map).cloned().collect();
        inputs::check_streams(&files)?;
        outputs::check::<&Path>(session, &[], &files)?;
        let (maps, outs) = (self.map.len(), self.outputs.len());
        if maps != 0 && maps != outs {
            let what = format!("{} for {}", count("map", maps), count("output", outs));
            return Err(Failure::new(2, what).remedy("give one --map for each output, or none"));
        }
        let maps = self.maps(session, &mut report)?;
        let files = self.exemplar.iter().chain(&self.outputs);
        let files = files.map(|path| Input::new(session, path)).collect::<Result<Vec<_>, _>>()?;
        let needed = self.bytes(session, &files, &maps)?;
        memory::check_fixed(&session.limits, needed)?;
        report.estimate = Some(needed.0);
        let planes = self.read(session, &files, &mut report)?;
        report.stage("read");
        self.check(&planes, &maps, &report)?;
        let maps: Vec<SourceMap<2>> = maps.into_iter().map(|file| file.map).collect();
        let scored = self.scored(session, &planes, &maps)?;
        session.watch.finish();
        report.stage("score");
        report.stats = json!({ "outputs": scored.iter().map(Scored::json).collect::<Vec<_>>() });
        Ok(Done::answered(report, text(&scored)))
    }

    /// An upper bound of all that is held, by the headers of exemplars and outputs.
    fn bytes(&self, session: &Session<'_>, files: &[Input], maps: &[MapFile]) -> Result<Bytes, Failure> {
        let options = inputs::options(session.limits, Role::Color, self.nonfinite);
        let infos = files.iter().map(|input| input.probe(&options)).collect::<Result<Vec<_>, _>>()?;
        let layout = common_layout(files.iter().map(|input| input.path.as_path()).zip(infos.iter().map(Layout::of)))?;
        let held = infos.iter().map(|info| memory::picture(domain(info), layout.channels(), info.depth)).sum::<Bytes>();
        let (exemplars, outputs) = infos.split_at(self.exemplar.len());
        let samples = |domains: &mut dyn Iterator<Item = Domain<2>>| -> Bytes {
            domains.map(|domain| Bytes::of_samples(domain, layout.colors as u64)).sum()
        };
        // A map's exemplars are prepared in its own orientations.
        let turned = maps.iter().map(|map| samples(&mut map.map.table.sources().iter().map(|(_, domain)| *domain)));
        let prepared = turned.fold(samples(&mut exemplars.iter().map(domain)), Bytes::max);
        let largest = outputs.iter().map(domain).map(|output| samples(&mut std::iter::once(output)));
        let largest = largest.max().unwrap_or_default();
        let maps = maps.iter().map(|map| memory::places(map.map.domain())).sum::<Bytes>();
        Ok(memory::PROGRAM + memory::reading(&infos) + held + maps + prepared * A_CHANNEL + largest * 2)
    }

    /// Exemplars, then outputs, with the same channels.
    fn read(&self, session: &Session<'_>, files: &[Input], report: &mut Report) -> Result<Vec<Plane<2>>, Failure> {
        let options = inputs::options(session.limits, Role::Color, self.nonfinite);
        let mut read = |input: &Input| Ok::<_, Failure>(input.read(session, &options, report)?.plane);
        let planes = files.iter().map(&mut read).collect::<Result<Vec<_>, _>>()?;
        let layout = |plane: &Plane<2>| Layout { colors: plane.color_channels(), alpha: plane.alpha };
        let common = common_layout(files.iter().map(|input| input.path.as_path()).zip(planes.iter().map(layout)))?;
        planes.into_iter().map(|plane| widened(plane, common)).collect()
    }

    fn maps(&self, session: &Session<'_>, report: &mut Report) -> Result<Vec<MapFile>, Failure> {
        let mut read = |path: &PathBuf| {
            let read = Input::new(session, path)?.read_map(session)?;
            report.inputs.push(read.entry);
            Ok(read.file)
        };
        self.map.iter().map(&mut read).collect()
    }

    /// Refuses outputs that are transparent anywhere, and maps of other outputs or exemplars.
    fn check(&self, planes: &[Plane<2>], maps: &[MapFile], report: &Report) -> Result<(), Failure> {
        let (exemplars, outputs) = planes.split_at(self.exemplar.len());
        for (path, plane) in self.exemplar.iter().zip(exemplars) {
            let nothing = plane.validity()?.is_some_and(|seen| !seen.samples().contains(&true));
            if nothing {
                let failure = Failure::new(3, "all of it is transparent, so that there is nothing to judge by");
                return Err(failure.about(path).remedy("give an exemplar with something in it"));
            }
        }
        for (path, plane) in self.outputs.iter().zip(outputs) {
            let holes = plane.validity()?.map_or(0, |seen| seen.samples().iter().filter(|seen| !**seen).count());
            if holes != 0 {
                let what = format!("{} {} transparent, and cannot be judged", count("pixel", holes), are(holes));
                return Err(Failure::new(3, what).about(path).remedy("give an output that shows something everywhere"));
            }
        }
        for ((path, file), (name, output)) in self.map.iter().zip(maps).zip(self.outputs.iter().zip(outputs)) {
            let (shape, of) = (output.domain().shape, format!("'{}' has", shown(name)));
            check_size(path, file.map.domain().shape, Some(shape), &of, "give the map of this output")?;
            self.check_made_of(file, report).map_err(|failure| failure.about(path))?;
        }
        Ok(())
    }

    /// A map's exemplars are the ones that were given, in their order.
    fn check_made_of(&self, file: &MapFile, report: &Report) -> Result<(), Failure> {
        let read = |path: &PathBuf| {
            let path = selvedge_io::path_text(path);
            report.inputs.iter().find(|input| input["path"] == path).and_then(|input| input["blake3"].as_str())
        };
        let given: Vec<Option<&str>> = self.exemplar.iter().map(read).collect();
        for (origin, _) in file.map.table.sources() {
            let number = usize::from(origin.exemplar);
            let Fingerprint { name, blake3 } = &file.exemplars[number];
            let same = |one: &Option<&str>| *one == Some(blake3.as_str());
            if given.get(number).is_some_and(same) {
                continue;
            }
            if given.iter().any(same) {
                let what = format!("has '{name}' as its exemplar {}, and it is not given there", number + 1);
                return Err(Failure::new(3, what).remedy("give --exemplar in the order of the run that made the map"));
            }
            return Err(made_of_another(name, &self.exemplar));
        }
        Ok(())
    }

    /// An error about exemplars, with the name of the one that is too small.
    fn small(&self, exemplars: &[Plane<2>], error: Error) -> Failure {
        let Error::TooSmall { shape } = &error else { return error.into() };
        let small = exemplars.iter().position(|plane| plane.domain().shape[..] == shape[..]);
        let failure = Failure::from(error);
        match small {
            Some(number) => failure.about(&self.exemplar[number]),
            None => failure,
        }
    }

    /// All outputs, best first; equal ones in the order given.
    fn scored(
        &self,
        session: &Session<'_>,
        planes: &[Plane<2>],
        maps: &[SourceMap<2>],
    ) -> Result<Vec<Scored>, Failure> {
        let (exemplars, outputs) = planes.split_at(self.exemplar.len());
        let slices: Vec<&[Plane<2>]> = exemplars.iter().map(std::slice::from_ref).collect();
        let encoder = Encoder::fit(&slices)?;
        let mut judge: Option<(Vec<Vec<Transform>>, Judge)> = None;
        let mut scored = Vec::new();
        for (i, output) in outputs.iter().enumerate() {
            session.check_signal()?;
            session.run::<2>().observer.event(&Event::step("score", i as u64, outputs.len() as u64));
            let about = |f: Failure| f.about(&self.outputs[i]);
            let transforms = transforms(maps.get(i), exemplars.len());
            // Exemplars are prepared again only for a map with other orientations.
            if judge.as_ref().is_none_or(|(of, _)| *of != transforms) {
                let shown = slices.iter().zip(&transforms).map(|(planes, of)| Exemplar::new(planes).shown(of));
                let sources = Exemplars::new(&encoder, &shown.collect::<Vec<_>>())?;
                let small = |e| self.small(exemplars, e);
                judge = Some((transforms, Judge::new(&sources, Default::default()).map_err(small)?));
            }
            let Some((_, judge)) = &judge else { continue };
            let features = encoder.encode(std::slice::from_ref(output)).map_err(|e| about(e.into()))?;
            let features = match maps.get(i) {
                // A map says whether the output tiles.
                Some(map) if map.domain().shape == features.domain().shape => {
                    let channels = features.channels();
                    selvedge_core::Grid::from_vec(map.domain(), channels, features.into_vec())?
                }
                _ => features,
            };
            let columns = judge.columns(&features, maps.get(i)).map_err(|e| about(e.into()))?;
            scored.push(Scored {
                name: shown(&self.outputs[i]).to_string(),
                preference: preference(&columns),
                columns,
            });
        }
        scored.sort_by(|a, b| b.preference.total_cmp(&a.preference));
        Ok(scored)
    }
}

fn domain(info: &Info) -> Domain<2> {
    Domain::open([info.height, info.width])
}

/// Orientations of each exemplar in a map; as they are without one.
fn transforms(map: Option<&SourceMap<2>>, exemplars: usize) -> Vec<Vec<Transform>> {
    let Some(map) = map else { return vec![vec![Transform::IDENTITY]; exemplars] };
    let of = |e: usize| {
        let sources = map.table.sources().iter().filter(|(origin, _)| usize::from(origin.exemplar) == e);
        sources.map(|(origin, _)| origin.transform).collect()
    };
    (0..exemplars).map(of).collect()
}

/// One output.
struct Scored {
    name: String,
    preference: f64,
    columns: Columns,
}

impl Scored {
    fn json(&self) -> Value {
        let columns: serde_json::Map<String, Value> =
            self.columns.named().into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect();
        json!({ "path": self.name, "preference": self.preference, "columns": columns })
    }
}

/// A table, one output a line block.
fn text(scored: &[Scored]) -> String {
    let one = |(rank, s): (usize, &Scored)| {
        let head = format!("{}. {}: preference {:.3}\n", rank + 1, s.name, s.preference);
        let columns = s.columns.named().into_iter().map(|(name, value)| format!("  {name}: {value:.4}\n"));
        std::iter::once(head).chain(columns).collect::<String>()
    };
    scored.iter().enumerate().map(one).collect()
}
