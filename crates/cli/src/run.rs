//! What every command goes through: threads, signals, and the file of options that is written at the end.

use crate::failure::Failure;
use crate::report::Done;
use crate::session::Session;
use crate::typed::Typed;
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
    let outcome: Result<Done, Failure> = pool.install(|| {
        // What cannot be saved is known before the work.
        let saved = global.save_config.as_ref().map(|_| typed.saved()).transpose()?;
        let done = typed.cli.command.execute(&session)?;
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
