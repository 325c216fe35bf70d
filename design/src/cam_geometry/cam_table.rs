//! The motion law as a cam table for a motion controller: an electronic cam instead of a cut one.

use camdrive::motion::MotionLaw;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Equidistant masters between which the controller interpolates along straight lines.
pub struct CamTable {
    /// φ (rad), U (m or rad), U′, U″; the last row is one turn after the first.
    pub rows: Vec<[f64; 4]>,
    /// A bound of the error of straight interpolation (m or rad).
    pub error: f64,
    /// True if U is an angle.
    pub angular: bool,
    /// The angles (rad) at which U″ jumps: a row there has the value after the jump, because controllers take one U″ for each
    /// master.
    pub jumps: Vec<f64>,
}

/// The most rows of a table; controllers take some thousand.
const MOST_ROWS: usize = 65_536;

/// The most listed jumps.
const MOST_TOLD: usize = 12;

/// U″ jumps where it changes at a breakpoint by more than this part of its bound; smooth laws have roundings.
const JUMP: f64 = 1e-6;

/// The units of slaves that move along a line and of slaves that turn: their number in one SI unit.
const UNITS: [(&str, f64); 2] = [("mm", 1e3), ("deg", 360.0 / TAU)];

/// The breakpoints at which U″ jumps, `bound` being its bound.
fn jumps(law: &MotionLaw, bound: f64) -> Vec<f64> {
    let breakpoints = law.breakpoints();
    let bend = |phi: f64, forward| law.at_in(law.segment(phi, forward), phi).0[2];
    let jumps = |phi: &f64| (bend(*phi, true) - bend(*phi, false)).abs() > JUMP * bound;
    breakpoints.iter().copied().filter(jumps).collect()
}

impl CamTable {
    /// The table of this law with an error of at most `tolerance` (m or rad), or the longest one. Between neighbours at the
    /// distance h straight lines miss U by at most h² max|U″|/8.
    pub fn new(law: &MotionLaw, angular: bool, tolerance: f64) -> Self {
        let bound = law.bound(2);
        let wanted = TAU * (bound / (8.0 * tolerance)).sqrt();
        // Multiples of 360 put a row at every whole degree.
        let n = 360 * ((wanted / 360.0).ceil().clamp(1.0, (MOST_ROWS / 360) as f64) as usize);
        let row = |i: usize| {
            let phi = TAU * i as f64 / n as f64;
            let [u, u1, u2, ..] = law.at(if i == n { 0.0 } else { phi }).0;
            [phi, u, u1, u2]
        };
        let error = (TAU / n as f64).powi(2) * bound / 8.0;
        CamTable { rows: (0..=n).map(row).collect(), error, angular, jumps: jumps(law, bound) }
    }

    fn unit(&self) -> (&'static str, f64) {
        UNITS[usize::from(self.angular)]
    }

    /// The angles at which U″ jumps, which its column cannot hold; None without jumps.
    pub fn jumps_told(&self) -> Option<String> {
        let shown = |phi: &f64| format!("{:.2}°", phi.to_degrees());
        let mut angles = self.jumps.iter().take(MOST_TOLD).map(shown).collect::<Vec<_>>().join(", ");
        if self.jumps.len() > MOST_TOLD {
            angles += &format!(" and {} other angles", self.jumps.len() - MOST_TOLD);
        }
        let told = || format!("U″ jumps at {angles}; a row of the cam table has only the U″ after a jump");
        (!self.jumps.is_empty()).then(told)
    }

    /// Master (deg), slave (mm or deg), and the derivatives of the slave, with a heading, as PLCopen cam editors import them.
    pub fn plcopen(&self) -> String {
        let ((unit, factor), degree) = (self.unit(), TAU / 360.0);
        let mut text = format!(
            "MasterPosition[deg];SlavePosition[{unit}];SlaveVelocity[{unit}/deg];SlaveAcceleration[{unit}/deg2]\n"
        );
        for [phi, u, u1, u2] in &self.rows {
            let (u, u1, u2) = (factor * u, factor * u1 * degree, factor * u2 * degree * degree);
            let _ = writeln!(text, "{:.6};{u:.7};{u1:.9};{u2:.11}", phi.to_degrees());
        }
        text
    }

    /// Master (deg) and slave (mm or deg) in two columns.
    pub fn two_columns(&self) -> String {
        let (_, factor) = self.unit();
        let mut text = String::new();
        for [phi, u, ..] in &self.rows {
            let _ = writeln!(text, "{:.6}\t{:.7}", phi.to_degrees(), factor * u);
        }
        text
    }
}
