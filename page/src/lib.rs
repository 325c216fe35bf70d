//! What a page computes with: [`camdrive_cli::live`] for a browser. Texts in JSON lie in the memory, from a pointer on.
#![warn(missing_docs)]

use camdrive_cli::document::{Diagnostics, input::hold};
use camdrive_cli::live::{BUILD, Depth, Live, Values};
use serde_json::{Value, from_slice, json};
use std::cell::{Cell, RefCell};
use std::path::Path;

thread_local! {
    /// The text that a page writes or reads next.
    static TEXT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    /// The scene of the page.
    static LIVE: RefCell<Option<Live>> = const { RefCell::new(None) };
    /// The length of the answer.
    static LENGTH: Cell<usize> = const { Cell::new(0) };
}

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "page")]
// SAFETY: the page has a function of this name, which takes a number and returns nothing.
unsafe extern "C" {
    safe fn progress(part: f64);
}

#[cfg(not(target_arch = "wasm32"))]
fn progress(_: f64) {}

/// Room for a text of this length, which the page writes there.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    TEXT.with_borrow_mut(|text| {
        text.clear();
        text.resize(length, 0);
        text.as_mut_ptr()
    })
}

/// The length of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn length() -> usize {
    LENGTH.get()
}

/// Answers the written text: {"files": {NAME: TEXT}} opens a scene, the first of the files, {"values": [[KEY, TEXT]], "depth":
/// "sketch"} studies it.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> *const u8 {
    TEXT.with_borrow_mut(|text| {
        let answer = answer(&from_slice(text).unwrap_or_default());
        *text = answer.to_string().into_bytes();
        LENGTH.set(text.len());
        text.as_ptr()
    })
}

fn answer(asked: &Value) -> Value {
    if let Some(files) = asked["files"].as_array() {
        for file in files {
            if let [Some(name), Some(text)] = [0, 1].map(|i| file[i].as_str()) {
                hold(Path::new(name), text.as_bytes().to_vec());
            }
        }
        let opened = Live::open(Path::new(files[0][0].as_str().unwrap_or_default()));
        return match opened {
            Ok(live) => {
                LIVE.set(Some(live));
                json!({ "build": BUILD })
            }
            Err(Diagnostics(faults)) => {
                json!({ "faults": faults.iter().map(|of| json!({ "text": of.message })).collect::<Vec<_>>() })
            }
        };
    }
    let values: Values = serde_json::from_value(asked["values"].clone()).unwrap_or_default();
    let depth = match asked["depth"].as_str() {
        Some("sketch") => Depth::Sketch,
        Some("run") => Depth::Run,
        _ => Depth::Whole,
    };
    LIVE.with_borrow(|live| match live {
        Some(live) => live.answer(&values, depth, |part| progress(part)),
        None => json!({ "faults": [{ "text": "no scene is open" }] }),
    })
}
