//! Documentation of a drive for people.

use super::Fault;

/// Documentation of a drive for people.
#[derive(Clone, Debug)]
pub struct Text {
    /// The file beside the drive's code: TOML with `sources` and passages `summary`, `equation`, `left_out`, `accuracy` and
    /// `limit`, each with the conditions `when` it holds. Text that holds only under a condition is written {condition|text}.
    pub file: &'static str,
    /// All conditions that the file may name, and whether they hold.
    pub conditions: Vec<(&'static str, bool)>,
}

impl Text {
    /// The text of a drive.
    pub fn new(file: &'static str, conditions: &[(&'static str, bool)]) -> Self {
        Text { file, conditions: conditions.to_vec() }
    }

    /// Whether a condition holds, "inputs" or "not inputs".
    ///
    /// # Errors
    /// The drive does not know the condition.
    pub fn holds(&self, condition: &str) -> Result<bool, Fault> {
        let (name, wanted) = condition.strip_prefix("not ").map_or((condition, true), |name| (name, false));
        let known = self.conditions.iter().find(|(known, _)| *known == name);
        known
            .map(|(_, holds)| *holds == wanted)
            .ok_or_else(|| Fault::new(format!("`{name}` is not a condition of this drive")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_condition_or_its_opposite_holds() {
        let text = Text::new("", &[("inputs", true), ("damped", false)]);
        let holds = ["inputs", "not inputs", "damped", "not damped"].map(|condition| text.holds(condition).unwrap());
        assert_eq!(holds, [true, false, false, true]);
        let told = text.holds("not known").unwrap_err().to_string();
        assert_eq!(told, "`known` is not a condition of this drive");
    }
}
