//! Studies: many variants of a drive, each run over a window and measured.

#[cfg(not(target_arch = "wasm32"))]
pub mod coupled;
pub mod figures;
pub mod measure;
pub mod piece;
pub mod plan;
pub mod report;
pub mod run;
pub mod single;
#[cfg(test)]
mod tests;
