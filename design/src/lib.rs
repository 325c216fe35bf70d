//! Studies and design tools around the drives; ARCHITECTURE.md lists the modules.

#![deny(unsafe_code)]
#![warn(missing_docs)]

/// The progress of a study, for a progress bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Parts of this stage that are done.
    pub done: usize,
    /// Parts in total, as far as known.
    pub total: usize,
    /// The stage that begins.
    pub stage: &'a str,
}

pub mod cam_geometry;
pub mod clearance;
pub mod compensation;
#[cfg(not(target_arch = "wasm32"))]
pub mod coupling;
pub mod documentation;
pub mod drawing;
pub mod forces;
pub mod formulas;
pub mod harmonic_analysis;
#[cfg(not(target_arch = "wasm32"))]
pub mod host;
pub mod law_motions;
pub mod lever_law;
pub mod oscillator;
pub mod overview;
mod parallel;
pub mod periodic_motions;
pub mod periodic_turn;
pub mod plot;
#[cfg(not(target_arch = "wasm32"))]
pub mod recording;
pub mod report;
pub mod resource;
pub mod search;
pub mod smoothing;
pub mod stability;
pub mod steady;
pub mod study;
pub mod synthesis;
pub mod table_error;
pub mod text;
#[cfg(not(target_arch = "wasm32"))]
pub mod tradeoff;
pub mod transmission;
pub mod work;
pub mod xml;
