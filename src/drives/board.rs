//! What importers read after each step, laid out where reading takes but a few instructions.

/// How many outputs have a place: those of the drive with the most that are shown. Each takes its part of the 2 kB of an
/// instance.
const PLACES: usize = 11;

/// The outputs that a drive has shown since the last step, up to date until something is set.
///
/// An output has the place by which its declaration numbers it ([`super::Variable::at`]), counted from the value reference
/// `first` on.
#[derive(Clone, Debug)]
pub struct Board {
    first: usize,
    /// NaN where nothing is shown.
    values: [f64; PLACES],
}

impl Board {
    /// An empty board for outputs from this value reference on.
    pub fn new(first: u32) -> Self {
        Board { first: first as usize, values: [f64::NAN; PLACES] }
    }

    /// The output with this reference; NaN where it is not shown.
    #[inline(always)]
    pub fn read(&self, reference: u32) -> f64 {
        let place = (reference as usize).wrapping_sub(self.first);
        self.values.get(place).copied().unwrap_or(f64::NAN)
    }

    /// Shows an output; the others stay.
    #[inline(always)]
    pub fn show(&mut self, place: usize, value: f64) {
        if let Some(shown) = self.values.get_mut(place) {
            *shown = value;
        }
    }

    /// Takes everything off.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.values = [f64::NAN; PLACES];
    }
}
