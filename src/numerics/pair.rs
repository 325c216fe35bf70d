//! Two numbers side by side, aligned so that the compiler keeps them in one register, for the few places where each instruction
//! counts.

use serde::{Deserialize, Serialize};
use std::ops::{Add, Mul, Sub};

/// Two numbers.
#[repr(align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pair(pub [f64; 2]);

impl Pair {
    /// These two.
    #[inline(always)]
    pub fn new(first: f64, second: f64) -> Self {
        Pair([first, second])
    }

    /// A pair of equal numbers.
    #[inline(always)]
    pub fn both(x: f64) -> Self {
        Pair([x, x])
    }

    /// The numbers one by one.
    #[inline(always)]
    pub fn array(self) -> [f64; 2] {
        self.0
    }

    /// The pair in reverse order.
    #[inline(always)]
    pub fn swapped(self) -> Self {
        Pair([self.0[1], self.0[0]])
    }

    /// The first number twice.
    #[inline(always)]
    pub fn firsts(self) -> Self {
        Pair::both(self.0[0])
    }

    /// The second number twice.
    #[inline(always)]
    pub fn seconds(self) -> Self {
        Pair::both(self.0[1])
    }
}

macro_rules! operator {
    ($($operator:ident $function:ident)*) => { $(
        impl $operator for Pair {
            type Output = Pair;
            #[inline(always)]
            fn $function(self, other: Pair) -> Pair {
                Pair([self.0[0].$function(other.0[0]), self.0[1].$function(other.0[1])])
            }
        }
    )* };
}

operator! { Add add Sub sub Mul mul }

impl From<[f64; 2]> for Pair {
    #[inline(always)]
    fn from(numbers: [f64; 2]) -> Self {
        Pair(numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_product_of_two_complex_numbers() {
        // (2 + 3i)(5 − 7i) = 31 + i.
        let (a, b) = (Pair::new(2.0, 3.0), Pair::from([5.0, -7.0]));
        assert_eq!((a.firsts() * b + a.seconds() * b.swapped() * Pair::new(-1.0, 1.0)).array(), [31.0, 1.0]);
        assert_eq!((b - a * Pair::both(0.5)).array(), [4.0, -8.5]);
    }
}
