//! What every command goes through: threads, signals, and the end, at which all that it makes is written at once.

use std::ffi::OsString;

use selvedge_io::Staged;

use crate::args::Global;
use crate::failure::Failure;
use crate::report::Done;
use crate::session::Session;
use crate::stdio;
use crate::typed::{self, Stop, Typed};
use crate::watch;

/// More threads than this help nobody.
const MOST_THREADS: usize = 256;

/// Runs what was typed; answers with the exit code.
pub(crate) fn run(typed: &Typed) -> Result<u8, Failure> {
    let global = &typed.cli.global;
    let session = Session::new(global, typed.used());
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
    let mut done = typed.cli.command.execute(session, &|words| again(session, words))?;
    // A dry run is how options are tried: what they are is all that it writes.
    if let (Some(path), Some(text)) = (&global.save_config, saved) {
        done.outputs.bytes(path, text.into_bytes());
    }
    Ok(done)
}

/// Runs the words that a picture carries: with its seed, and else as the session does.
fn again(session: &Session<'_>, words: &[OsString]) -> Result<Done, Failure> {
    let typed = typed::parse(words).map_err(|stop| match stop {
        Stop::Wrong(failure) => failure,
        Stop::Answer(_) => Failure::new(3, "the picture carries no run").remedy("give another picture"),
    })?;
    let global = Global { seed: typed.cli.global.seed, ..session.global.clone() };
    let nothing = |_: &[OsString]| Err(Failure::new(3, "the picture carries no run").remedy("give another picture"));
    typed.cli.command.execute(&Session::new(&global, typed.used()), &nothing)
}

/// Says what a command has to say, and gives its files their names once standard output has taken its part.
fn finish(session: &Session<'_>, done: &Done, staged: Vec<Staged<'_>>) -> Result<u8, Failure> {
    if session.global.json {
        let object = done.report.json(session.global.seed, rayon::current_num_threads(), session.global.dry_run);
        stdio::answer(format!("{object}\n").as_bytes())
    } else {
        stdio::answer(done.answer.as_bytes())
    }
    .map_err(|e| Failure::of_stream(&e))?;
    selvedge_io::finish_all(staged)?;
    for (stage, seconds) in done.report.stages() {
        session.detail(&format!("{stage}: {seconds:.3} s"));
    }
    if let Some(line) = &done.line {
        session.say(line);
    }
    Ok(done.exit)
}
