//! Progress on standard error, and signals.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use selvedge_core::{Event, Observer};
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::args::{Global, Progress};
use crate::failure::Failure;
use crate::stdio;

/// How long a run may take to end by itself once a signal came.
const PATIENCE: Duration = Duration::from_millis(700);
/// How often signals are looked for.
const TICK: Duration = Duration::from_millis(20);

/// Shows a run and ends it on a signal. A second signal ends the program at once. Clones are one.
#[derive(Clone)]
pub(crate) struct Watch {
    bar: Option<ProgressBar>,
    json: bool,
    signal: Arc<AtomicUsize>,
}

impl Watch {
    /// Starts to listen for signals.
    pub(crate) fn new(global: &Global) -> Self {
        let shown = match global.progress {
            Progress::Auto => !global.quiet && std::io::stderr().is_terminal(),
            Progress::Bar => true,
            Progress::Json | Progress::None => false,
        };
        let signal = Arc::new(AtomicUsize::new(0));
        listen(&signal, global);
        Self { bar: shown.then(bar), json: global.progress == Progress::Json, signal }
    }

    /// The signal that ended the run.
    pub(crate) fn signal(&self) -> Option<u8> {
        let number = self.signal.load(Ordering::Relaxed);
        (number != 0).then_some(number as u8)
    }

    /// Says which of several runs is watched. The one before has taken the bar away.
    pub(crate) fn turn(&self, number: usize, of: usize) {
        if let (Some(bar), true) = (&self.bar, 1 < of) {
            bar.reset();
            bar.set_prefix(format!("{number} of {of}: "));
        }
    }

    /// Says what is done that cannot tell how far it is: 0 of 0 to programs.
    pub(crate) fn busy(&self, what: &'static str) {
        self.prepare(what);
        if self.json {
            Observer::<2>::event(&Self { bar: None, ..self.clone() }, &Event::step(what, 0, 0));
        }
    }

    /// The same of what comes before the work, which is told to people alone: programs wait for its first step.
    pub(crate) fn prepare(&self, what: &'static str) {
        if let Some(bar) = &self.bar {
            bar.set_message(what);
            bar.set_length(0);
            bar.set_position(0);
            bar.enable_steady_tick(Duration::from_millis(100));
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Notes the first signal for the run to see. Ends the program where the run does not do so soon (a codec asks nobody
/// whether to go on), or when a second signal comes; a run that is to keep its best so far is given all the time.
fn listen(signal: &Arc<AtomicUsize>, global: &Global) {
    // A file over the limit of sizes then fails to be written, and does not end the program.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    let raised = Arc::new(AtomicUsize::new(0));
    for &number in signals() {
        // Where signals cannot be had, runs just go on.
        let _ = signal_hook::flag::register_usize(number, raised.clone(), number as usize);
    }
    let (signal, patient, json) = (signal.clone(), global.keep_partial, global.json);
    let listener = std::thread::Builder::new().spawn(move || {
        let next = || {
            std::thread::sleep(TICK);
            raised.swap(0, Ordering::Relaxed)
        };
        let first = loop {
            match next() {
                0 => {}
                number => break number,
            }
        };
        signal.store(first, Ordering::Relaxed);
        let began = Instant::now();
        while (patient || began.elapsed() < PATIENCE) && next() == 0 {}
        if last_word() {
            selvedge_io::clip::end_children();
            let written = selvedge_io::remove_parts();
            let failure = if written { Failure::late(first as u8) } else { Failure::interrupted(first as u8) };
            std::process::exit(failure.tell(json).into());
        }
    });
    // Nor where there is no room for one more thread.
    drop(listener);
}

/// The signals that end a run: that of a closed terminal too, unless whoever started the program has it ignored, as
/// `nohup` does. Where the system does not say, it is left alone, and ends the program as it ends any other.
#[cfg(unix)]
fn signals() -> &'static [i32] {
    const ALL: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    // Signal 1 is the lowest bit.
    if ignored.is_some_and(|mask| mask & 1 == 0) { &ALL } else { &ALL[..2] }
}

/// The signals that end a run.
#[cfg(not(unix))]
fn signals() -> &'static [i32] {
    &[SIGINT, SIGTERM]
}

/// True for whoever asks first: the run that came to its end, or the signal that ended it.
pub(crate) fn last_word() -> bool {
    static TAKEN: AtomicBool = AtomicBool::new(false);
    !TAKEN.swap(true, Ordering::Relaxed)
}

/// Ends a run that was too late for the last word.
pub(crate) fn wait_for_the_end() -> ! {
    loop {
        std::thread::park();
    }
}

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix}{msg:12} {wide_bar} {pos}/{len} {elapsed}, {eta} left");
    let bar = ProgressBar::new(0);
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

impl<const D: usize> Observer<D> for Watch {
    fn event(&self, event: &Event<'_, D>) {
        if let Some(bar) = &self.bar {
            // One bar for all stages, so that what is left follows from the run's own first part.
            let [done, of] = event.work.unwrap_or([event.done, event.of]);
            bar.set_message(event.stage);
            bar.set_length(of);
            bar.set_position(done);
        }
        if self.json {
            let mut step =
                serde_json::json!({"stage": event.stage, "done": event.done, "of": event.of, "energy": event.energy});
            if let Some([done, of]) = event.work {
                step["work"] = serde_json::json!({"done": done, "of": of});
            }
            stdio::tell_program(&stdio::object(&step));
        }
    }

    fn cancelled(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }
}
