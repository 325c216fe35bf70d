//! The drive models, and what they are made of, from the bottom up:
//!
//! | | holds | uses of the folders here |
//! |---|---|---|
//! | [`interface`] | what importers see of a drive | none |
//! | [`follower`] | what hangs on the shaft: equations of motion | `interface` |
//! | [`shaft`] | how the shaft moves: prescribed, or free under its torques | those above |
//! | `solver` | ways to move shaft and followers from event to event | those above |
//! | [`models`] | the drives that are published: constructors of parts, names, texts | those above |
//!
//! An equation knows no solver, a solver knows no drive.

pub mod follower;
pub mod interface;
pub mod models;
pub mod shaft;
pub mod solver;

pub use interface::*;
pub use models::*;

#[cfg(test)]
mod tests;
