//! Why a drive cannot go on.

/// Why a drive cannot go on. In a box, since every step returns one or none.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault(pub Box<Reason>);

/// Variable and message of a [`Fault`].
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// The variable at fault, by its name in the FMU; empty where it is none in particular.
    pub variable: String,
    /// One sentence that names the quantity, its value and what would be admissible.
    pub message: String,
    /// Whether the name of the variable stands before the message, which then goes on from there.
    pub named: bool,
    /// Whether what computes is gone, such as the process of a library: other values say nothing of these.
    pub is_loss: bool,
}

impl Fault {
    /// A fault of no variable in particular.
    pub fn new(message: impl Into<String>) -> Self {
        Fault(Box::new(Reason { variable: String::new(), message: message.into(), named: false, is_loss: false }))
    }

    /// That of a variable.
    pub fn of(mut self, variable: impl Into<String>) -> Self {
        self.0.variable = variable.into();
        self
    }

    /// A fault of a variable, with whose name the message begins.
    pub fn named(variable: impl Into<String>, message: impl Into<String>) -> Self {
        Fault(Box::new(Reason { variable: variable.into(), message: message.into(), named: true, is_loss: false }))
    }

    /// The fault as it is told elsewhere: in these words, and of no variable there.
    pub fn told(self, message: String) -> Self {
        Fault(Box::new(Reason { is_loss: self.is_loss, ..*Fault::new(message).0 }))
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
        if self.named {
            write!(f, "`{}`", self.variable)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}
