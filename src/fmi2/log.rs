//! Log messages to the importer, formatted without allocation.

use super::abi::{self, fmi2Status};
use crate::drives::event::LOG_CATEGORIES as CATEGORIES;
use std::ffi::CStr;
use std::fmt::{self, Write};

/// A category, as a place in [`crate::drives::event::LOG_CATEGORIES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// logStatusWarning.
    Warning = 0,
    /// logStatusError.
    Error = 1,
    /// logStatusFatal.
    Fatal = 2,
    /// logEvents.
    Events = 3,
    /// logSolver.
    Solver = 4,
    /// logAll.
    All = 5,
}

/// Takes status, category and text of a message; the text may serve as a printf format without arguments.
pub type Sink = Box<dyn Fn(fmi2Status, &CStr, &CStr)>;

/// The importer's log with the categories that it reads.
pub struct Logger {
    sink: Sink,
    enabled: [bool; CATEGORIES.len()],
}

impl Logger {
    /// A log with all categories on or off.
    pub fn new(sink: Sink, logging_on: bool) -> Self {
        Logger { sink, enabled: [logging_on; CATEGORIES.len()] }
    }

    /// Turns on the named categories (all, if none is named), or turns all off. The first unknown name is refused.
    pub fn configure<'a>(&mut self, on: bool, names: impl ExactSizeIterator<Item = &'a CStr>) -> Result<(), &'a CStr> {
        let mut enabled = [on && names.len() == 0; CATEGORIES.len()];
        for name in names {
            let category = CATEGORIES.iter().position(|(known, _)| *known == name).ok_or(name)?;
            enabled[category] = on;
        }
        if enabled[Category::All as usize] {
            enabled = [on; CATEGORIES.len()];
        }
        self.enabled = enabled;
        Ok(())
    }

    /// Whether messages of this category are passed on. Errors always are: the standard expects that the user has read the reason
    /// of an fmi2Error; the categories choose debug messages.
    pub fn wants(&self, category: Category) -> bool {
        matches!(category, Category::Error | Category::Fatal) || self.enabled[category as usize]
    }

    /// Passes a message on, if its category is on.
    pub fn log(&self, category: Category, text: fmt::Arguments) {
        if self.wants(category) {
            let status = match category {
                Category::Warning => abi::WARNING,
                Category::Error | Category::Fatal => abi::ERROR,
                Category::Events | Category::Solver | Category::All => abi::OK,
            };
            (self.sink)(status, CATEGORIES[category as usize].0, Line::new(text).text());
        }
    }
}

/// Room for one message; longer ones are cut.
const CAPACITY: usize = 1024;

/// The mark of a cut message.
const CUT: &str = " …";

/// One message on the stack: NUL-terminated UTF-8 in which `#` is doubled, since FMI reads `#r12#` as a variable, and `%`, since
/// importers treat it as a printf format.
struct Line {
    bytes: [u8; CAPACITY],
    length: usize,
}

impl Line {
    fn new(text: fmt::Arguments) -> Self {
        let mut line = Line { bytes: [0; CAPACITY], length: 0 };
        if line.write_fmt(text).is_err() {
            line.bytes[line.length..line.length + CUT.len()].copy_from_slice(CUT.as_bytes());
        }
        line
    }

    fn text(&self) -> &CStr {
        CStr::from_bytes_until_nul(&self.bytes).unwrap_or_default()
    }

    fn push(&mut self, c: char) -> fmt::Result {
        let end = self.length + c.len_utf8();
        if CAPACITY - CUT.len() - 1 < end {
            return Err(fmt::Error);
        }
        c.encode_utf8(&mut self.bytes[self.length..end]);
        self.length = end;
        Ok(())
    }
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for c in text.chars().filter(|c| *c != '\0') {
            if c == '#' || c == '%' {
                self.push(c)?;
            }
            self.push(c)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text_of(message: &str) -> String {
        Line::new(format_args!("{message}")).text().to_str().unwrap().to_owned()
    }

    #[test]
    fn text_is_cut_at_a_character_and_free_of_variable_marks() {
        assert_eq!(text_of("50 % of #r1#"), "50 %% of ##r1##");
        assert_eq!(text_of("a\0b"), "ab");
        let long = text_of(&"ä".repeat(2000));
        assert!(long.len() < CAPACITY && long.ends_with("ä …"));
    }

    #[test]
    fn categories_choose_the_messages_but_errors_always_pass() {
        let mut logger = Logger::new(Box::new(|_, _, _| ()), false);
        assert!(logger.wants(Category::Error) && !logger.wants(Category::Events));
        logger.configure(true, [c"logEvents"].into_iter()).unwrap();
        assert!(logger.wants(Category::Events) && !logger.wants(Category::Solver));
        assert_eq!(logger.configure(true, [c"logWeather"].into_iter()), Err(c"logWeather"));
        assert!(logger.wants(Category::Events), "a refused call changes nothing");
        logger.configure(true, [c"logAll"].into_iter()).unwrap();
        assert!(logger.wants(Category::Solver));
        logger.configure(true, [].into_iter()).unwrap();
        assert!(logger.wants(Category::Warning));
        logger.configure(false, [].into_iter()).unwrap();
        assert!(!logger.wants(Category::Warning));
    }
}
