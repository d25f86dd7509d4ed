//! What every command goes through: threads, signals, and the end, at which all that it makes is written at once.

use std::ffi::OsString;
use std::path::PathBuf;

use selvedge_core::Depth;
use selvedge_io::{Metadata, StagedFile};

use crate::args::Global;
use crate::failure::{Failure, n};
use crate::outputs::Outputs;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::stdio::STREAM;
use crate::turns::Turns;
use crate::typed::{self, Stop, Typed};
use crate::{inputs, outputs, sheet, stdio, watch};

/// More threads than this help nobody.
const MOST_THREADS: usize = 256;

/// Runs what was typed; answers with the exit code.
pub(crate) fn run(typed: &Typed) -> Result<u8, Failure> {
    let global = &typed.cli.global;
    let session = Session::new(global, typed.used(), typed.names());
    for option in typed.idle() {
        session.say(&format!("note: {option} does nothing for this command"));
    }
    if MOST_THREADS < global.threads {
        session.say(&format!("note: {} threads are too many; using {MOST_THREADS}", global.threads));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(global.threads.min(MOST_THREADS)).build();
    let refused = |e| Failure::new(6, format!("the system starts no threads ({e})")).remedy("use fewer --threads");
    let pool = pool.map_err(refused)?;
    let outcome = pool.install(|| execute(typed, &session));
    let outputs = outcome.as_ref().map(|done| &done.outputs);
    let staged = outputs.map_err(Failure::clone).and_then(|outputs| outputs.stage(&session));
    session.watch.finish();
    if !watch::last_word() {
        watch::wait_for_the_end();
    }
    let staged = staged?;
    pool.install(|| finish(&session, outcome.as_ref().map_err(Failure::clone)?, staged))
}

fn execute(typed: &Typed, session: &Session<'_>) -> Result<Done, Failure> {
    let global = &typed.cli.global;
    // What cannot be saved is known before the work.
    let saved = global.save_config.as_ref().map(|_| typed.saved()).transpose()?;
    let turns = typed.turns()?;
    let mut done = if turns.all.is_empty() {
        typed.cli.command.execute(session, &|words| Ok(within(session, global, words, 0)?.1))?
    } else {
        several(session, &turns)?
    };
    session.expected()?;
    // A dry run is how options are tried: what they are is all that it writes.
    if let (Some(path), Some(text)) = (&global.save_config, saved) {
        done.outputs.bytes(path, text.into_bytes());
    }
    Ok(done)
}

/// Several runs as one, which are written together. Those that came to their end are kept where the next one is
/// interrupted and the best so far is wanted.
fn several(session: &Session<'_>, turns: &Turns) -> Result<Done, Failure> {
    let global = session.global;
    let mut done = Done::answered(Report::new(""), String::new());
    let sheet =
        turns.sheet.as_deref().map(|path| Ok::<_, Failure>((path, outputs::format(path, None, Some(Depth::U8))?)));
    let sheet = sheet.transpose()?;
    rehearse(session, turns)?;
    let mut cells = Vec::new();
    for (i, turn) in turns.all.iter().enumerate() {
        session.watch.turn(i + 1, turns.all.len());
        let held = done.outputs.held() + sheet::held(&cells);
        let (seed, one) = within(session, global, &turn.words, held).or_else(|failure| {
            let kept = global.keep_partial && session.watch.signal().is_some() && 0 < i;
            if kept {
                done.outputs.write(session)?;
            }
            Err(if kept { failure.after("run", i) } else { failure })
        })?;
        if sheet.is_some()
            && let Some(picture) = one.outputs.first()?
        {
            cells.push((sheet::cell(&picture)?, turn.label.clone()));
        }
        done.add(one, seed, global.dry_run);
    }
    if let Some((path, _)) = sheet.filter(|_| cells.is_empty() && !session.global.dry_run) {
        session.warn(path, &"is not written: frames are on no sheet");
    }
    if let Some((path, format)) = sheet.filter(|_| !cells.is_empty()) {
        let mut sheet = Outputs::default();
        sheet.picture(path, format, &sheet::sheet(&cells, turns.columns)?, &Metadata::default())?;
        done.report.outputs.extend(sheet.noted());
        done.outputs.extend(sheet);
    }
    Ok(done)
}

/// Refuses, before the first of several runs, what would end a later one: each exemplar, and each value of what is
/// swept, is tried once, as a dry run does, since seeds change nothing of what is refused; then all names are.
fn rehearse(session: &Session<'_>, turns: &Turns) -> Result<(), Failure> {
    let stream = turns.read.iter().find(|path| path.as_os_str() == STREAM || inputs::is_pipe(path));
    if let (true, Some(stream)) = (1 < turns.all.len(), stream) {
        let what = format!("can be read once, and {} would read it", n("run", turns.all.len()));
        let failure = Failure::new(2, what).remedy("save it to a file first");
        let is_input = stream.as_os_str() == STREAM;
        return Err(if is_input { failure.named("standard input") } else { failure.about(stream) });
    }
    let dry = Global { dry_run: true, quiet: true, verbose: false, ..session.global.clone() };
    // The first run refuses what is its own by itself, before it begins.
    for turn in turns.all.iter().skip(1).filter(|turn| turn.is_first) {
        within(session, &dry, &turn.words, 0)?;
    }
    let files = turns.all.iter().flat_map(|turn| turn.names.iter().cloned()).chain(turns.sheet.clone());
    let files: Vec<PathBuf> = files.filter(|path| path.as_os_str() != STREAM).collect();
    outputs::check(session, &files, &turns.read)
}

/// Runs other words with `held` bytes less: with their seed, and else by these options. Answers with the seed.
fn within(session: &Session<'_>, global: &Global, words: &[OsString], held: u64) -> Result<(u64, Done), Failure> {
    let nothing = || Failure::new(3, "the picture carries no run").remedy("give another picture");
    let typed = typed::parse(words).map_err(|stop| match stop {
        Stop::Wrong(failure) => failure,
        Stop::Answer(_) => nothing(),
    })?;
    let global = Global { seed: typed.cli.global.seed.clone(), ..global.clone() };
    let done = typed
        .cli
        .command
        .execute(&session.within(&global, (typed.used(), typed.names()), held), &|_| Err(nothing()))?;
    Ok((global.seed(), done))
}

/// Says what a command has to say, and gives its files their names once standard output has taken its part.
fn finish(session: &Session<'_>, done: &Done, staged: Vec<StagedFile<'_>>) -> Result<u8, Failure> {
    if session.global.json {
        let object = done.report.json(&session.global.seed.0, rayon::current_num_threads(), session.global.dry_run);
        stdio::answer(format!("{}\n", stdio::object(&object)).as_bytes())
    } else {
        stdio::answer(done.answer.as_bytes())
    }
    .map_err(|e| Failure::of_stream(&e))?;
    selvedge_io::finish_all(staged)?;
    for (stage, seconds) in done.report.stages() {
        session.detail(&format!("{stage}: {seconds:.3} s"));
    }
    done.lines.iter().for_each(|line| session.say(line));
    Ok(done.exit)
}
