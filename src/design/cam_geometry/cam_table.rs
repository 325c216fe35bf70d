//! The motion law as a cam table for a motion controller: electronic cam instead of a cut one.

use crate::motion::MotionLaw;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Equidistant masters between which the controller interpolates along straight lines.
pub struct CamTable {
    /// φ [rad], U [m], U′ [m/rad], U″ [m/rad²]; the last row is one turn after the first.
    pub rows: Vec<[f64; 4]>,
    /// A bound of the error of straight interpolation [m].
    pub error: f64,
}

/// The most rows of a table; controllers take some thousand.
const MOST_ROWS: usize = 65_536;

/// The unit of lengths in tables of controllers.
const MILLIMETRES: f64 = 1e3;

impl CamTable {
    /// The table of this law whose error is at most `tolerance` [m], or the longest one. Between neighbours at the distance h
    /// straight lines miss U by h² max|U″|/8 at most.
    pub fn new(law: &MotionLaw, tolerance: f64) -> Self {
        let bound = law.bound(2);
        let wanted = TAU * (bound / (8.0 * tolerance)).sqrt();
        // Multiples of 360 put a row at every whole degree.
        let n = 360 * ((wanted / 360.0).ceil().clamp(1.0, (MOST_ROWS / 360) as f64) as usize);
        let row = |i: usize| {
            let phi = TAU * i as f64 / n as f64;
            let [u, u1, u2, ..] = law.at(if i == n { 0.0 } else { phi }).0;
            [phi, u, u1, u2]
        };
        CamTable { rows: (0..=n).map(row).collect(), error: (TAU / n as f64).powi(2) * bound / 8.0 }
    }

    /// Master [°], slave [mm], and the derivatives of the slave, with a heading, as PLCopen cam editors import them.
    pub fn plcopen(&self) -> String {
        let mut text =
            String::from("MasterPosition[deg];SlavePosition[mm];SlaveVelocity[mm/deg];SlaveAcceleration[mm/deg2]\n");
        let degree = TAU / 360.0;
        for [phi, u, u1, u2] in &self.rows {
            let (u, u1, u2) = (MILLIMETRES * u, MILLIMETRES * u1 * degree, MILLIMETRES * u2 * degree * degree);
            let _ = writeln!(text, "{:.6};{u:.7};{u1:.9};{u2:.11}", phi.to_degrees());
        }
        text
    }

    /// Master [°] and slave [mm] in two columns.
    pub fn two_columns(&self) -> String {
        let mut text = String::new();
        for [phi, u, ..] in &self.rows {
            let _ = writeln!(text, "{:.6}\t{:.7}", phi.to_degrees(), MILLIMETRES * u);
        }
        text
    }
}
