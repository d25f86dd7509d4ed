//! The commands, and what all of them go through.

pub(crate) mod apply;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod graphcut;
pub(crate) mod info;
pub(crate) mod inspect;
pub(crate) mod man;
pub(crate) mod quilt;
pub(crate) mod score;
pub(crate) mod synthesize;
pub(crate) mod transfer;

use crate::args::Command;
use crate::failure::Failure;
use crate::report::Done;
use crate::session::Session;
use crate::typed::Typed;
use crate::{config, watch};

/// More threads than this help nobody.
const MOST_THREADS: usize = 256;

/// Runs what was typed; answers with the exit code.
pub(crate) fn run(typed: &Typed) -> Result<u8, Failure> {
    let global = &typed.cli.global;
    let session = Session::new(global);
    if MOST_THREADS < global.threads {
        session.say(&format!("note: {} threads are too many; using {MOST_THREADS}", global.threads));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(global.threads.min(MOST_THREADS)).build();
    let refused = |e| Failure::new(6, format!("the system starts no threads ({e})")).remedy("use fewer --threads");
    let pool = pool.map_err(refused)?;
    let outcome: Result<Done, Failure> = pool.install(|| {
        // What cannot be saved is known before the work.
        let saved = global.save_config.as_ref().map(|_| config::saved(typed)).transpose()?;
        let done = execute(&typed.cli.command, &session)?;
        if let (Some(path), Some(text), false) = (&global.save_config, saved, global.dry_run) {
            selvedge_io::write_bytes(path, text.as_bytes(), global.no_clobber)?;
        }
        Ok(done)
    });
    session.watch.finish();
    if !watch::last_word() {
        watch::wait_for_the_end();
    }
    pool.install(|| session.finish(&outcome?))
}

fn execute(command: &Command, session: &Session<'_>) -> Result<Done, Failure> {
    match command {
        Command::Synthesize(synthesize) => synthesize.run(session),
        Command::Quilt(quilt) => quilt.run(session),
        Command::Transfer(transfer) => transfer.run(session),
        Command::Graphcut(graphcut) => graphcut.run(session),
        Command::Apply(apply) => apply.run(session),
        Command::Info(info) => info.run(session),
        Command::Inspect(inspect) => inspect.run(session),
        Command::Compare(compare) => compare.run(session),
        Command::Score(score) => score.run(session),
        Command::Completions(completions) => completions.run(session),
        Command::Man(man) => man.run(session),
    }
}
