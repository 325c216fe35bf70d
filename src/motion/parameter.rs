//! The parameters of motion laws: name, description, type and range.

/// Type and range of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterKind {
    /// A length (m), at most [`super::plan::MAX_LENGTH`] either way.
    Length,
    /// The derivative of a length by the angle of this order, 1 … 3 (m/radⁿ).
    Derivative(usize),
    /// A part of an angle (1), at which an acceleration changes sign.
    Inflection,
    /// An angle (rad) in this range, borders included.
    Angle {
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// A factor (1).
    Factor,
    /// A standard law by its number.
    Law,
}

/// A parameter of a motion law.
#[derive(Clone, Debug, PartialEq)]
pub struct LawParameter {
    /// The name, for example `a[3]` or `rise`.
    pub name: String,
    /// Description for people.
    pub text: String,
    /// Type and range.
    pub kind: ParameterKind,
}

impl LawParameter {
    /// A parameter with its name, meaning and kind of value.
    pub fn new(name: impl Into<String>, text: impl Into<String>, kind: ParameterKind) -> Self {
        LawParameter { name: name.into(), text: text.into(), kind }
    }
}
