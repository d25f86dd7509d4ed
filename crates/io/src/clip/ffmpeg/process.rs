//! A program that runs beside ours: ended if it hangs or is wanted no more, and its last line is kept.

use std::io::{self, Read as _};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;
use std::time::{Duration, Instant};

use crate::clip::problem::ClipProblem;
use crate::error::Problem;
use crate::name::escaped;

/// How often a program that we wait for is looked at.
const TICK: Duration = Duration::from_millis(10);
/// Bytes of what it says that are kept: a line of this length is told whole.
const KEPT: usize = 1024;

/// All that run; `None` once no more may start.
static RUNNING: Mutex<Option<Vec<Weak<Shared>>>> = Mutex::new(Some(Vec::new()));

/// Ends all programs that were started to read and write clips, and starts none from now on: for a program that ends
/// at once, whatever its other threads are doing.
pub fn end_children() {
    let running = locked(&RUNNING).take();
    running.into_iter().flatten().filter_map(|one| one.upgrade()).for_each(|one| one.kill());
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A running program.
pub(super) struct Process {
    shared: Arc<Shared>,
    writes: bool,
}

struct Shared {
    child: Mutex<Child>,
    /// Since when we wait for it.
    since: Mutex<Option<Instant>>,
    /// How long that may be.
    patience: Duration,
    hangs: AtomicBool,
    said: Mutex<Vec<u8>>,
    /// Whether it will say no more.
    silent: AtomicBool,
}

impl Process {
    /// Starts a program whose standard error is ours, and ends it where it lets us wait for longer than `patience`.
    pub(super) fn start(
        command: &mut Command,
        (patience, writes): (Duration, bool),
    ) -> io::Result<(Self, Option<ChildStdin>, Option<ChildStdout>)> {
        apart(command).stderr(Stdio::piped());
        let mut running = locked(&RUNNING);
        let running = running.as_mut().ok_or(io::ErrorKind::Interrupted)?;
        let mut child = command.spawn()?;
        let (stdin, stdout, stderr) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let shared = Arc::new(Shared {
            child: Mutex::new(child),
            since: Mutex::default(),
            patience,
            hangs: AtomicBool::new(false),
            said: Mutex::default(),
            silent: AtomicBool::new(false),
        });
        running.retain(|one| 0 < one.strong_count());
        running.push(Arc::downgrade(&shared));
        let process = Self { shared, writes };
        let (of_said, of_hangs) = (Arc::clone(&process.shared), Arc::downgrade(&process.shared));
        thread::Builder::new().spawn(move || of_said.listen(stderr))?;
        thread::Builder::new().spawn(move || watch(&of_hangs))?;
        Ok((process, stdin, stdout))
    }

    /// Does what may wait for the program.
    pub(super) fn waiting<T>(&self, work: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
        *locked(&self.shared.since) = Some(Instant::now());
        let done = work();
        *locked(&self.shared.since) = None;
        done
    }

    /// Waits for its end; what it said last, if it said anything.
    ///
    /// # Errors
    /// [`ClipProblem::Hangs`], and [`ClipProblem::Failed`] with its last line.
    pub(super) fn end(self) -> Result<Option<String>, Problem> {
        let status = self.waiting(|| self.shared.status()).map_err(|e| Problem::file_system(e, 0))?;
        if self.shared.hangs.load(Ordering::Relaxed) {
            return Err(ClipProblem::Hangs { seconds: self.shared.patience.as_secs() }.into());
        }
        // What it said may lie in the pipe still, which a program that it started may keep open.
        let patient = Instant::now() + Duration::from_secs(1);
        while !self.shared.silent.load(Ordering::Acquire) && Instant::now() < patient {
            thread::sleep(TICK);
        }
        let said = last_line(&locked(&self.shared.said));
        if status.success() {
            return Ok(said);
        }
        let writes = self.writes;
        Err(ClipProblem::Failed { said: said.unwrap_or_else(|| status.to_string()), writes }.into())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.shared.kill();
    }
}

impl Shared {
    /// Polls, so that whoever ends it gets at it meanwhile.
    fn status(&self) -> io::Result<ExitStatus> {
        loop {
            if let Some(status) = locked(&self.child).try_wait()? {
                return Ok(status);
            }
            thread::sleep(TICK);
        }
    }

    fn kill(&self) {
        let mut child = locked(&self.child);
        // One that has ended is asked for its end alone, so that nothing of it stays.
        let _ = child.kill();
        let _ = child.wait();
    }

    /// Takes all that it says, however much, and keeps the last of it.
    fn listen(&self, stderr: Option<ChildStderr>) {
        let mut buffer = [0; 4096];
        if let Some(mut stderr) = stderr {
            while let Ok(count @ 1..) = stderr.read(&mut buffer) {
                let mut said = locked(&self.said);
                said.extend_from_slice(&buffer[..count]);
                let old = said.len().saturating_sub(KEPT);
                said.drain(..old);
            }
        }
        self.silent.store(true, Ordering::Release);
    }
}

/// Ends what lets us wait for too long.
fn watch(of: &Weak<Shared>) {
    while let Some(shared) = of.upgrade() {
        let since = *locked(&shared.since);
        if since.is_some_and(|since| shared.patience < since.elapsed()) {
            shared.hangs.store(true, Ordering::Relaxed);
            return shared.kill();
        }
        drop(shared);
        thread::sleep(5 * TICK);
    }
}

/// Signals of the terminal are for us: whoever ends us ends it.
#[cfg(unix)]
fn apart(command: &mut Command) -> &mut Command {
    std::os::unix::process::CommandExt::process_group(command, 0)
}

/// Elsewhere it hears what we hear.
#[cfg(not(unix))]
fn apart(command: &mut Command) -> &mut Command {
    command
}

fn last_line(said: &[u8]) -> Option<String> {
    let mut lines = said.rsplit(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    lines.find(|line| !line.is_empty()).map(escaped)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::io::Write as _;

    fn started(script: &str, patience: u64) -> (Process, Option<ChildStdin>, Option<ChildStdout>) {
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped());
        Process::start(&mut command, (Duration::from_millis(patience), false)).unwrap()
    }

    #[test]
    fn what_is_said_last_is_kept_however_much_it_is() {
        let flood = "i=0; while [ $i -lt 4000 ]; do echo 'a line of no use, again and again' >&2; i=$((i+1)); done";
        let (process, ..) = started(&format!("{flood}; printf 'the last\\r\\n\\n' >&2; exit 3"), 60_000);
        let Err(Problem::Clip(problem)) = process.end() else { panic!("it failed") };
        assert_eq!(problem, ClipProblem::Failed { said: "the last".into(), writes: false });
        let (process, ..) = started("exit 7", 60_000);
        assert!(process.end().unwrap_err().to_string().contains("7"), "without words its code is told");
        let (process, ..) = started("echo odd >&2", 60_000);
        assert_eq!(process.end().unwrap().as_deref(), Some("odd"));
    }

    #[test]
    fn a_program_that_hangs_is_ended_while_it_is_read_written_or_waited_for() {
        for what in ["read", "write", "wait"] {
            let (process, stdin, stdout) = started("exec sleep 100", 200);
            let began = Instant::now();
            let id = locked(&process.shared.child).id();
            match what {
                "read" => drop(process.waiting(|| stdout.unwrap().read(&mut [0; 8]))),
                "write" => assert!(process.waiting(|| stdin.unwrap().write_all(&vec![0; 1 << 20])).is_err()),
                _ => {}
            }
            let ended = process.end();
            assert!(matches!(ended, Err(Problem::Clip(ClipProblem::Hangs { .. }))), "{what}");
            assert!(began.elapsed() < Duration::from_secs(20), "{what}");
            assert!(!std::path::Path::new(&format!("/proc/{id}")).exists(), "{what}");
        }
    }

    #[test]
    fn a_program_that_is_wanted_no_more_is_ended() {
        let (process, ..) = started("exec sleep 100", 60_000);
        let id = locked(&process.shared.child).id();
        drop(process);
        assert!(!std::path::Path::new(&format!("/proc/{id}")).exists());
    }
}
