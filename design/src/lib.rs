//! Tools of design around the drives: [`cam_geometry`], contours from motion laws; [`clearance`], what backlash does to a
//! motion law; [`compensation`], cams for a machine that fluctuates; [`documentation`],
//! what is said of a drive; [`forces`], what rollers, joints and shaft bear; [`lever_law`], mechanisms between cam and tool
//! backwards; [`overview`], what a scene amounts to and what of it is implausible; [`smoothing`], measured lifts without their
//! noise; [`stability`], at which speeds varying parameters make a drive vibrate; [`synthesis`], cam profiles from motion tasks; [`tradeoff`], speed against accuracy; [`transmission`], how well mechanisms pass the force on.

#![deny(unsafe_code)]
#![warn(missing_docs)]

/// How far a study is, for a progress bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Parts of this stage that are done.
    pub done: usize,
    /// Of how many, as far as known.
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
