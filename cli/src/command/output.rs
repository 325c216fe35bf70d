//! Output for people: reports on the standard output, messages and progress on the standard error.

use super::Failure;
use camdrive_design::{Progress, text};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle, WeakProgressBar};
use std::io::{IsTerminal as _, Write};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Characters of a line if its width is unknown; help uses the same number.
const USUAL_WIDTH: usize = 100;

/// Narrower lines would hold one word each.
const LEAST_WIDTH: usize = 40;

/// The words at the start of messages, with the codes of their colours.
const WORDS: [(&str, &str); 5] =
    [("error:", "1;31"), ("warning:", "1;33"), ("note:", "1;36"), ("= hint:", "1;32"), ("= admissible:", "1")];

/// Characters of a line: COLUMNS, the terminal's width, or the usual width.
fn width_of(is_terminal: bool) -> usize {
    let columns = std::env::var("COLUMNS").ok().and_then(|columns| columns.trim().parse().ok());
    let terminal = || terminal_size::terminal_size().filter(|_| is_terminal).map(|(width, _)| usize::from(width.0));
    columns.or_else(terminal).filter(|width| 0 < *width).unwrap_or(USUAL_WIDTH).max(LEAST_WIDTH)
}

/// Characters of a line on the standard output.
pub fn width() -> usize {
    width_of(std::io::stdout().is_terminal())
}

/// Writes a result to the standard output unchanged.
pub fn print(text: &str) -> Result<(), Failure> {
    written(std::io::stdout().lock(), text)
}

/// Writes a report for people to the standard output.
pub fn show(report: &str) -> Result<(), Failure> {
    written(anstream::stdout().lock(), &painted(&text::wrapped(&text::visible(report), width())))
}

fn written(mut out: impl Write, text: &str) -> Result<(), Failure> {
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // The reader needs no more: `camdrive describe X | head`.
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(super::failure(format!("the result cannot be written: {e}"))),
        Ok(()) => Ok(()),
    }
}

/// Writes messages to the standard error.
pub fn print_message(messages: &str) {
    let width = width_of(std::io::stderr().is_terminal());
    // The line of a file stays above the mark of its place.
    let is_excerpt = |line: &str| line.trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit()).starts_with('|');
    let line = |line: &str| if is_excerpt(line) { line.to_owned() } else { text::wrapped(line, width) };
    let lines: Vec<String> = text::visible(messages).split('\n').map(line).collect();
    // A closed terminal is no error.
    let write = || drop(write!(anstream::stderr(), "{}", painted(&lines.join("\n"))));
    let bar = COUNTER.lock().unwrap_or_else(PoisonError::into_inner).as_ref().and_then(WeakProgressBar::upgrade);
    bar.map_or_else(write, |bar| bar.suspend(write));
}

/// Colours the words at the start of messages; the stream removes colours without a terminal or with NO_COLOR.
fn painted(text: &str) -> String {
    let line = |line: &str| {
        let (indent, content) = line.split_at(line.len() - line.trim_start().len());
        match WORDS.iter().find(|(word, _)| content.starts_with(word)) {
            Some((word, code)) => format!("{indent}\x1b[{code}m{word}\x1b[0m{}", &content[word.len()..]),
            None => line.to_owned(),
        }
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// A progress bar on the standard error, hidden without a terminal. It only grows: the known total of a study changes from stage to
/// stage, so each stage takes half of the rest.
pub struct Bar {
    bar: ProgressBar,
    /// The stage, and the position of the bar at its start.
    stage: Mutex<(String, u64)>,
}

/// The length of a bar, finer than a terminal's columns.
const LENGTH: u64 = 10_000;

impl Bar {
    fn new(name: &str) -> Self {
        let target =
            if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{prefix} {msg:>20} {wide_bar} {elapsed}");
        let bar = ProgressBar::with_draw_target(Some(LENGTH), target)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
            .with_prefix(name.to_owned());
        // The time goes on during a long part of a stage.
        bar.enable_steady_tick(Duration::from_secs(1));
        Bar { bar, stage: Mutex::default() }
    }

    /// Shows the progress of the work on this scene or task.
    pub fn during<R>(name: &str, work: impl FnOnce(&(dyn Fn(Progress<'_>) + Sync)) -> R) -> R {
        let bar = Bar::new(name);
        let result = work(&|progress| bar.show(progress));
        bar.bar.finish_and_clear();
        result
    }

    fn show(&self, Progress { done, total, stage }: Progress<'_>) {
        let mut state = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        if state.0 != stage {
            *state = (stage.to_owned(), self.bar.position());
            self.bar.set_message(stage.to_owned());
        }
        let part = (done as f64 / total.max(1) as f64).min(1.0);
        let position = state.1 + (0.5 * part * (LENGTH - state.1) as f64) as u64;
        self.bar.set_position(position.max(self.bar.position()));
    }
}

/// The current bar, which makes room for messages.
static COUNTER: Mutex<Option<WeakProgressBar>> = Mutex::new(None);

/// A bar for this many parts of one kind, with their rate and the remaining time.
pub fn counter(name: &str, total: u64) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let style = ProgressStyle::with_template("{prefix} {human_pos} of {human_len} {wide_bar} {per_sec}, {eta} left");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::with_draw_target(Some(total), target).with_style(style).with_prefix(name.to_owned());
    *COUNTER.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.downgrade());
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_bars_only_grow() {
        let bar = Bar::new("x");
        let mut last = 0;
        // A total that grows, a stage that starts again, and a stage without parts.
        for (done, total, stage) in [
            (1, 4, "errors"),
            (2, 4, "errors"),
            (3, 12, "errors"),
            (12, 12, "errors"),
            (0, 40, "times"),
            (1, 40, "times"),
            (0, 1, "laws"),
            (40, 40, "times"),
            (0, 0, "end"),
        ] {
            bar.show(Progress { done, total, stage });
            let position = bar.bar.position();
            assert!((last..LENGTH).contains(&position), "{stage} {done} of {total}: {position} after {last}");
            last = position;
        }
        assert!(LENGTH / 2 < last);
    }
}
