//! The study as a whole, on scenes whose answers are known.
