//! Progress on standard error, and signals.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use indicatif::{ProgressBar, ProgressStyle};
use selvedge_core::{Event, Observer};
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::args::{Global, Progress};

/// Shows a run and ends it on a signal. A second signal ends the program at once.
pub(crate) struct Watch {
    bar: Option<ProgressBar>,
    json: bool,
    signal: Arc<AtomicUsize>,
}

impl Watch {
    /// Starts to listen for signals.
    pub(crate) fn new(global: &Global) -> Self {
        let signal = Arc::new(AtomicUsize::new(0));
        for number in [SIGINT, SIGTERM] {
            // The first signal sets the number, the next finds it set. Where signals cannot be had, runs just go on.
            let seen = Arc::new(std::sync::atomic::AtomicBool::new(false));
            let _ = signal_hook::flag::register_conditional_shutdown(number, 128 + number, seen.clone());
            let _ = signal_hook::flag::register(number, seen);
            let _ = signal_hook::flag::register_usize(number, signal.clone(), number as usize);
        }
        let shown = match global.progress {
            Progress::Auto => !global.quiet && std::io::stderr().is_terminal(),
            Progress::Bar => true,
            Progress::Json | Progress::None => false,
        };
        Self { bar: shown.then(bar), json: global.progress == Progress::Json, signal }
    }

    /// The signal that ended the run.
    pub(crate) fn signal(&self) -> Option<u8> {
        let number = self.signal.load(Ordering::Relaxed);
        (number != 0).then_some(number as u8)
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:12} {wide_bar} {pos}/{len} {elapsed}");
    let bar = ProgressBar::new(0);
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

impl<const D: usize> Observer<D> for Watch {
    fn event(&self, event: &Event<'_, D>) {
        if let Some(bar) = &self.bar {
            bar.set_message(event.stage);
            bar.set_length(event.of);
            bar.set_position(event.done);
        }
        if self.json {
            eprintln!(
                "{}",
                serde_json::json!({"stage": event.stage, "done": event.done, "of": event.of, "energy": event.energy})
            );
        }
    }

    fn cancelled(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }
}
