//! Maps of two numbers side by side.

use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// A matrix of two rows: what lies on its diagonal, and beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Map {
    straight: Pair,
    crossed: Pair,
}

impl Map {
    /// The turn by the angle with this cosine and sine.
    #[inline(always)]
    pub fn turn(z: Pair) -> Self {
        Map { straight: z.firsts(), crossed: z.seconds() * Pair::new(-1.0, 1.0) }
    }

    /// The image of `x`.
    #[inline(always)]
    pub fn at(&self, x: Pair) -> Pair {
        self.straight * x + self.crossed * x.swapped()
    }
}
