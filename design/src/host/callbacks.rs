//! The functions that an instance calls: log and memory.

use camdrive::fmi2::abi::*;
use std::alloc::{Layout, alloc_zeroed, dealloc};
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The most messages that are kept, and the most characters of each.
const MOST: usize = 100;
const LONGEST: usize = 2000;

/// The log of an instance, which may write it from any thread.
#[derive(Default)]
pub struct Log(Mutex<Messages>);

/// Messages that nobody has read yet.
#[derive(Default)]
pub struct Messages {
    /// Messages of errors and discarded steps.
    pub errors: Vec<String>,
    pub warnings: Vec<String>,
}

impl Log {
    /// The messages.
    pub fn messages(&self) -> MutexGuard<'_, Messages> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The callbacks that write to this log; they are valid as long as the log.
    pub fn callbacks(self: &Arc<Self>) -> fmi2CallbackFunctions {
        fmi2CallbackFunctions {
            logger: Some(logger()),
            allocateMemory: Some(allocate),
            freeMemory: Some(free),
            // Steps are synchronous.
            stepFinished: None,
            componentEnvironment: Arc::as_ptr(self).cast_mut().cast(),
        }
    }
}

/// Receives a message of an instance.
///
/// Stable Rust cannot define a variadic function. A plain one that ends with the last named argument is called like a variadic
/// one on all platforms of the FMUs: named arguments are passed alike, and the caller removes the rest. So the arguments of a
/// format are unknown here, except a single string: it is in the next of the places for arguments, which on Apple's ARM is on
/// the stack, after the registers x0 to x7.
unsafe extern "C" fn note(
    environment: fmi2ComponentEnvironment,
    _name: fmi2String,
    status: fmi2Status,
    _category: fmi2String,
    text: fmi2String,
    #[cfg(all(target_vendor = "apple", target_arch = "aarch64"))] _x5: usize,
    #[cfg(all(target_vendor = "apple", target_arch = "aarch64"))] _x6: usize,
    #[cfg(all(target_vendor = "apple", target_arch = "aarch64"))] _x7: usize,
    first: fmi2String,
) {
    if status == OK || environment.is_null() || text.is_null() {
        return;
    }
    // SAFETY: the environment is the log of the host, which outlives its instance; the library passes a string that ends in NUL.
    let (log, text) = unsafe { (&*environment.cast_const().cast::<Log>(), CStr::from_ptr(text)) };
    let mut text = text.to_string_lossy();
    if text == "%s" && !first.is_null() {
        // SAFETY: the argument of this format is a string that ends in NUL.
        text = unsafe { CStr::from_ptr(first) }.to_string_lossy();
    } else {
        text = plain(&text).into();
    }
    let text = text.replace("##", "#").trim().chars().take(LONGEST).collect();
    let mut messages = log.messages();
    let list = if status == WARNING { &mut messages.warnings } else { &mut messages.errors };
    if list.len() < MOST {
        list.push(text);
    }
}

/// A format as text: %% stands for %.
fn plain(format: &str) -> String {
    let has_arguments = format.replace("%%", "").contains('%');
    format.replace("%%", "%") + if has_arguments { " (the values for % are not known)" } else { "" }
}

/// [`note`] with the standard's type.
fn logger() -> fmi2CallbackLogger {
    // SAFETY: both are pointers to functions of the C calling convention; see `note`.
    unsafe { std::mem::transmute::<*const (), fmi2CallbackLogger>(note as *const ()) }
}

/// The size of a block stands before it; the block is aligned as by calloc.
const HEAD: usize = 16;

/// The layout of a block of this many bytes with its head.
fn layout(bytes: usize) -> Option<Layout> {
    Layout::from_size_align(bytes.checked_add(HEAD)?, HEAD).ok()
}

/// Memory for this many objects of this size, zeroed; NULL if there is none.
unsafe extern "C" fn allocate(count: usize, size: usize) -> *mut c_void {
    let Some(bytes) = count.checked_mul(size) else { return std::ptr::null_mut() };
    let Some(layout) = layout(bytes) else { return std::ptr::null_mut() };
    // SAFETY: the layout is not empty; its head takes a number.
    unsafe {
        let block = alloc_zeroed(layout);
        if block.is_null() {
            return std::ptr::null_mut();
        }
        block.cast::<usize>().write(bytes);
        block.add(HEAD).cast()
    }
}

/// Frees memory of [`allocate`]; NULL is ignored.
unsafe extern "C" fn free(object: *mut c_void) {
    if object.is_null() {
        return;
    }
    // SAFETY: the instance passes what `allocate` gave it, once; its head is before it.
    unsafe {
        let block = object.cast::<u8>().sub(HEAD);
        if let Some(layout) = layout(block.cast::<usize>().read()) {
            dealloc(block, layout);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_zeroed_aligned_and_freed() {
        for (count, size) in [(1, 1), (3, 8), (1000, 24), (0, 8)] {
            // SAFETY: the memory is written within its size, and freed once.
            unsafe {
                let block = allocate(count, size).cast::<u8>();
                assert!(!block.is_null() && block.addr().is_multiple_of(16));
                let bytes = std::slice::from_raw_parts_mut(block, count * size);
                assert!(bytes.iter().all(|byte| *byte == 0));
                bytes.fill(7);
                free(block.cast());
            }
        }
        // SAFETY: nothing is allocated, and NULL is freed.
        unsafe {
            assert!(allocate(usize::MAX, 2).is_null() && allocate(1, usize::MAX - 3).is_null());
            free(std::ptr::null_mut());
        }
    }

    #[test]
    fn formats_are_read_as_text() {
        assert_eq!(plain("50 %% of it"), "50 % of it");
        assert_eq!(plain("%d of 5 %%"), "%d of 5 % (the values for % are not known)");
    }

    /// A C function of six arguments calls the logger like a variadic one, see `note`.
    #[test]
    fn messages_are_kept_up_to_a_number() {
        let log = Arc::<Log>::default();
        let callbacks = log.callbacks();
        let (logger, to) = (callbacks.logger.unwrap(), callbacks.componentEnvironment);
        // SAFETY: the log lives, and the strings end in NUL.
        unsafe {
            logger(to, c"x".as_ptr(), WARNING, c"c".as_ptr(), c"%s".as_ptr(), c" 5 % of ##1\n".as_ptr());
            logger(to, std::ptr::null(), ERROR, std::ptr::null(), c"no arguments".as_ptr());
            logger(to, c"x".as_ptr(), OK, c"c".as_ptr(), c"nothing".as_ptr());
            logger(to, c"x".as_ptr(), ERROR, c"c".as_ptr(), std::ptr::null());
            for _ in 0..2 * MOST {
                logger(to, c"x".as_ptr(), DISCARD, c"c".as_ptr(), c"again %d".as_ptr(), 7);
            }
        }
        let messages = log.messages();
        assert_eq!(messages.warnings, ["5 % of #1"]);
        assert_eq!((messages.errors.len(), messages.errors[0].as_str()), (MOST, "no arguments"));
    }
}
