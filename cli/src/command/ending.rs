//! The end of the program after a signal: files under way are finished, and no temporary folders stay.

#[cfg(unix)]
use camdrive_design::host::TemporaryFolder;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering::SeqCst};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Locked while files are written: a signal waits, so that no hidden files and no part of the results stay.
static WRITING: Mutex<()> = Mutex::new(());
/// The received signal, or 0.
static CAME: AtomicU8 = AtomicU8::new(0);
/// True if the signal ends the program as soon as no file is being written.
static ENDING: AtomicBool = AtomicBool::new(false);
/// The work that stops at the first signal.
static STOPPED: Mutex<Option<Arc<AtomicBool>>> = Mutex::new(None);

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// True if a closed terminal ends the program. `nohup` and a parent that ignores SIGHUP pass this on, and Linux shows it.
#[cfg(unix)]
fn ends_with_terminal() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| (mask >> (signal_hook::consts::SIGHUP - 1)) & 1 == 0)
}

/// Waits for signals in a separate thread. On Windows the system ends the program.
pub fn watch() {
    #[cfg(unix)]
    let hangup = ends_with_terminal().then_some(signal_hook::consts::SIGHUP);
    #[cfg(unix)]
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(hangup.iter().chain(signal_hook::consts::TERM_SIGNALS))
    {
        std::thread::spawn(move || {
            for signal in signals.forever() {
                CAME.store(signal as u8, SeqCst);
                if let Some(stop) = held(&STOPPED).take() {
                    stop.store(true, SeqCst);
                    continue;
                }
                ENDING.store(true, SeqCst);
                let _written = held(&WRITING);
                TemporaryFolder::remove_all();
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        });
    }
}

/// Makes signals wait while it lives.
pub fn writing() -> impl Drop {
    struct Written(Option<MutexGuard<'static, ()>>);
    impl Drop for Written {
        fn drop(&mut self) {
            self.0 = None;
            // The other thread ends the program.
            while is_near() {
                std::thread::park();
            }
        }
    }
    Written(Some(held(&WRITING)))
}

/// True if the program ends as soon as no file is being written.
pub fn is_near() -> bool {
    ENDING.load(SeqCst)
}

/// Lets the first signal only set `stop`, so that the program ends by itself; a second signal ends it at once.
pub fn stopping(stop: &Arc<AtomicBool>) {
    *held(&STOPPED) = Some(stop.clone());
}

/// The exit code after a signal, as in shells.
pub fn code() -> Option<u8> {
    Some(CAME.load(SeqCst)).filter(|signal| *signal != 0).map(|signal| 128 + signal)
}
