//! Why a drive cannot go on.

use serde::{Deserialize, Serialize};

/// Why a drive cannot go on. In a box, since every step returns one or none.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Fault(pub Box<Reason>);

/// Variable, message and remedy of a [`Fault`].
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Reason {
    /// The variable at fault, by its name in the FMU; empty where it is none in particular.
    pub variable: String,
    /// One sentence that names the quantity, its value and what would be admissible.
    pub message: String,
    /// Whether the name of the variable stands before the message, which then goes on from there.
    pub named: bool,
    /// Whether what computes is gone, such as the process of a library: other values say nothing of these.
    pub is_loss: bool,
    /// Why there is no periodic motion, of a start that asks for one.
    pub motionless: Option<String>,
    /// What to do about it.
    pub hint: Option<String>,
}

impl Fault {
    /// A fault of no variable in particular.
    pub fn new(message: impl Into<String>) -> Self {
        let (variable, message) = (String::new(), message.into());
        Fault(Box::new(Reason { variable, message, named: false, is_loss: false, motionless: None, hint: None }))
    }

    /// That of a variable.
    pub fn of(mut self, variable: impl Into<String>) -> Self {
        self.0.variable = variable.into();
        self
    }

    /// A fault of a variable, with whose name the message begins.
    pub fn named(variable: impl Into<String>, message: impl Into<String>) -> Self {
        let mut fault = Fault::new(message).of(variable);
        fault.0.named = true;
        fault
    }

    /// The same fault with this remedy.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.0.hint = Some(hint.into());
        self
    }

    /// The same fault as that of a start in a periodic motion, which there is not for this reason.
    pub fn motionless(mut self, reason: impl Into<String>) -> Self {
        self.0.motionless = Some(reason.into());
        self
    }

    /// The same fault with its place, a file or a part, before the message.
    pub fn within(self, place: impl std::fmt::Display) -> Self {
        let message = format!("{place}: {}", self.sentence());
        self.told(message)
    }

    /// The same fault in other words.
    pub fn told(mut self, message: String) -> Self {
        (self.0.message, self.0.named) = (message, false);
        self
    }

    /// The same fault with its remedy at the end of the message, as logs have it.
    pub fn in_one_sentence(mut self) -> Self {
        if let Some(hint) = self.0.hint.take() {
            self.0.message += &format!("; {hint}");
        }
        self
    }
}

impl Reason {
    /// The message from the name of the variable on.
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
