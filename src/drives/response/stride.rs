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
    /// The matrix with these rows.
    pub fn of([[a, b], [c, d]]: [[f64; 2]; 2]) -> Self {
        Map { straight: Pair::new(a, d), crossed: Pair::new(b, c) }
    }

    /// The turn by the angle with this cosine and sine.
    #[inline(always)]
    pub fn turn(z: Pair) -> Self {
        Map { straight: z.firsts(), crossed: z.seconds() * Pair::new(-1.0, 1.0) }
    }

    /// The turn by twice that angle.
    #[inline(always)]
    pub fn turn_twice(z: Pair) -> Self {
        // sin 2φ = 2 sin φ cos φ, cos 2φ = 1 − 2 sin² φ.
        let products = z.seconds() * z;
        Map {
            straight: Pair::both(1.0) + products.seconds() * Pair::both(-2.0),
            crossed: products.firsts() * Pair::new(-2.0, 2.0),
        }
    }

    /// The image of `x`.
    #[inline(always)]
    pub fn at(&self, x: Pair) -> Pair {
        self.straight * x + self.crossed * x.swapped()
    }
}
