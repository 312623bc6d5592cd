//! Progress on standard error: a bar on a terminal, a line for each stage otherwise, or JSON lines.

use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use task::{Progress, Update};

/// Shortest time between two drawings of the bar or two JSON lines of a stage.
const PACE: Duration = Duration::from_millis(100);
/// Characters of the bar.
const WIDTH: usize = 28;
/// Characters of a message that are shown, so that a report stays on one line.
const MESSAGE: usize = 72;

struct State {
    stage: String,
    shown: Instant,
    /// Most of the stage that was shown; reports of parallel work arrive out of order.
    fraction: f64,
}

/// A progress that writes to standard error.
pub(super) fn progress(json: bool) -> Progress {
    let state = Mutex::new(State { stage: String::new(), shown: Instant::now(), fraction: 0.0 });
    let terminal = std::io::stderr().is_terminal();
    Progress::new(move |update: &Update| {
        let Ok(mut state) = state.lock() else { return };
        let new_stage = state.stage != update.stage;
        if !new_stage && (state.shown.elapsed() < PACE || update.fraction < state.fraction) {
            return;
        }
        state.stage.clear();
        state.stage.push_str(update.stage);
        state.shown = Instant::now();
        state.fraction = update.fraction;
        if json {
            let line = serde_json::json!({
                "stage": update.stage, "fraction": update.fraction, "message": update.message,
            });
            write(&format!("{line}\n"));
        } else if terminal {
            let full = (update.fraction * WIDTH as f64).round() as usize;
            let bar = format!("{}{}", "#".repeat(full), ".".repeat(WIDTH - full.min(WIDTH)));
            let message: String = update.message.chars().take(MESSAGE).collect();
            write(&format!("\r\x1b[2K{:16} [{bar}] {:3.0} %  {message}", update.stage, update.fraction * 100.0));
        } else if new_stage {
            write(&format!("{} ...\n", update.stage));
        }
    })
}

/// Clears the bar, so that what follows starts on a clean line.
pub(super) fn finish() {
    if std::io::stderr().is_terminal() {
        write("\r\x1b[2K");
    }
}

/// Writes a line to standard output. One that is closed or full is no reason to fail what has been done.
pub(super) fn print(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes()).and_then(|()| std::io::stdout().write_all(b"\n"));
}

/// Writes a line to standard error.
pub(super) fn print_error(text: &str) {
    write(&format!("{text}\n"));
}

/// Writes to standard error; a closed one is no reason to stop working.
fn write(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}
