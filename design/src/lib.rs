//! Studies and design tools around the drives.
//!
//! | module | |
//! |---|---|
//! | [`overview`] | key figures of a scene and implausible values |
//! | [`synthesis`] | cam profiles from motion tasks (harmonic synthesis) |
//! | [`smoothing`], [`harmonic_analysis`] | measured lifts: noise removed, finite Fourier series |
//! | [`lever_law`] | inverse kinematics of linkages: the lever law for a given tool motion |
//! | [`transmission`] | transmission angles of the mechanisms between cam and tool |
//! | [`cam_geometry`] | cam contours from motion laws, and whether they can be cut and run |
//! | [`forces`] | kinetostatic forces on rollers, joints and shaft |
//! | [`clearance`] | impacts and flank changes that backlash causes under a motion law |
//! | [`periodic_motions`] | all periodic motions of a machine, stable or not |
//! | [`compensation`] | cam laws that cancel the speed fluctuation of a machine |
//! | [`stability`] | speeds at which periodic coefficients excite vibrations (parametric resonance) |
//! | [`tradeoff`] | speed against accuracy of solver settings and features |
//! | [`resource`] | a resolved scene and its drive; the templates of the models |
//! | [`host`] | a simulator in this process that drives instances through the C interface |
//! | [`documentation`] | the documentation text that applies to a drive |
//! | [`plot`], [`drawing`] | diagrams and their drawing as SVG |
//! | [`text`] | numbers, tables, CSV and JSON of all reports |
//! | [`search`], `parallel` | zeros and maxima of functions that take time; work on all cores |

#![deny(unsafe_code)]
#![warn(missing_docs)]

/// How far a study is, for a progress bar.
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
pub mod documentation;
pub mod drawing;
pub mod forces;
pub mod harmonic_analysis;
#[allow(unsafe_code)]
pub mod host;
pub mod lever_law;
pub mod overview;
mod parallel;
pub mod periodic_motions;
pub mod plot;
pub mod resource;
pub mod search;
pub mod smoothing;
pub mod stability;
pub mod synthesis;
pub mod text;
pub mod tradeoff;
pub mod transmission;
