//! What importers read after each step, laid out where reading takes but a few instructions.

/// How many outputs have a place: at least those of the drive with the most that are shown; a power of two, by which a place is
/// found without a further comparison.
const PLACES: usize = 16;

/// The outputs that a drive has shown since the last step, up to date until something is set.
///
/// An output has the place by which its declaration numbers it ([`super::Variable::at`]), counted from the value reference
/// `first` on.
#[derive(Clone, Debug)]
pub struct Board {
    first: u32,
    /// How many places hold a value that is up to date.
    count: u32,
    values: [f64; PLACES],
}

impl Board {
    /// An empty board for outputs from this value reference on.
    pub fn new(first: u32) -> Self {
        Board { first, count: 0, values: [f64::NAN; PLACES] }
    }

    /// The output with this reference; NaN where it is not shown.
    #[inline(always)]
    pub fn read(&self, reference: u32) -> f64 {
        let place = reference.wrapping_sub(self.first);
        if place < self.count { self.values[place as usize % PLACES] } else { f64::NAN }
    }

    /// Shows an output; the others stay.
    #[inline(always)]
    pub fn show(&mut self, place: usize, value: f64) {
        if let Some(shown) = self.values.get_mut(place) {
            *shown = value;
        }
        self.count = PLACES as u32;
    }

    /// Takes everything off.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }
}
