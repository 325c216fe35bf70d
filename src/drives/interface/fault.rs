//! The reason why a drive cannot go on.

use serde::{Deserialize, Serialize};

/// The reason why a drive cannot go on. In a box, since every step returns one or none.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Fault(pub Box<Reason>);

/// Variable, message and remedy of a [`Fault`].
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Reason {
    /// The variable at fault, by its name in the FMU; empty for none in particular.
    pub variable: String,
    /// One sentence that names the quantity, its value and the admissible values.
    pub message: String,
    /// Whether the message begins with the name of the variable, which is then not part of `message`.
    pub named: bool,
    /// Whether the computation itself is lost, as when the process of a library ends: other values say nothing about these.
    pub is_loss: bool,
    /// The reason why a start found no periodic motion; None for other faults.
    pub motionless: Option<String>,
    /// The remedy.
    pub hint: Option<String>,
}

impl Fault {
    /// A fault of no particular variable.
    pub fn new(message: impl Into<String>) -> Self {
        let (variable, message) = (String::new(), message.into());
        Fault(Box::new(Reason { variable, message, named: false, is_loss: false, motionless: None, hint: None }))
    }

    /// Attributes the fault to a variable.
    pub fn of(mut self, variable: impl Into<String>) -> Self {
        self.0.variable = variable.into();
        self
    }

    /// A fault of a variable; the message begins with its name.
    pub fn named(variable: impl Into<String>, message: impl Into<String>) -> Self {
        let mut fault = Fault::new(message).of(variable);
        fault.0.named = true;
        fault
    }

    /// Adds a remedy.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.0.hint = Some(hint.into());
        self
    }

    /// Marks it as the fault of a start without periodic motion, for this reason.
    pub fn motionless(mut self, reason: impl Into<String>) -> Self {
        self.0.motionless = Some(reason.into());
        self
    }

    /// Puts its place, a file or a part, before the message.
    pub fn within(self, place: impl std::fmt::Display) -> Self {
        let message = format!("{place}: {}", self.sentence());
        self.with_message(message)
    }

    /// Replaces the message.
    pub fn with_message(mut self, message: String) -> Self {
        (self.0.message, self.0.named) = (message, false);
        self
    }

    /// Moves the remedy to the end of the message, as logs need it.
    pub fn in_one_sentence(mut self) -> Self {
        if let Some(hint) = self.0.hint.take() {
            self.0.message += &format!("; {hint}");
        }
        self
    }
}

impl Reason {
    /// The message including the name of the variable.
    pub fn sentence(&self) -> String {
        if self.named { format!("`{}`{}", self.variable, self.message) } else { self.message.clone() }
    }
}

impl std::ops::Deref for Fault {
    type Target = Reason;
    fn deref(&self) -> &Reason {
        &self.0
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.sentence())?;
        self.hint.iter().try_for_each(|hint| write!(f, "\n  = hint: {hint}"))
    }
}

impl std::error::Error for Fault {}
