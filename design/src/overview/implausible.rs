//! Limits beyond which a figure is implausible, each with its reason; a value beyond them mostly lacks its unit.

use super::{Overview, Warning};
use std::f64::consts::TAU;

/// A figure, named without its follower; its limit in coherent SI; the reason; and the remedy.
type Limit = (&'static str, f64, &'static str, Remedy);

/// A remedy for a unit that may be missing, and one for a scene with its units.
type Remedy = [&'static str; 2];

const SPEED: f64 = 1e5 * TAU / 60.0;
const FORGOTTEN_RPM: Remedy = ["a plain number is in rad/s; write the unit: \"1800 rpm\"", "lower the speed"];

const FORGOTTEN_LENGTH: Remedy = ["a plain number is in m; write the unit: \"0.94 mm\"", "choose a smaller length"];

/// A unit missing in m or c, or in the natural frequency, or in the speed.
const FORGOTTEN_IN_VIBRATION: Remedy = [
    "a plain natural frequency is in rad/s, a plain speed too; write \"270 Hz\", \"1800 rpm\", and units of m and c",
    "lower the speed, or raise the natural frequency",
];

const FORGOTTEN_IN_MOTION: Remedy =
    ["write speeds and lengths with their units: \"1800 rpm\", \"0.94 mm\"", "lower the speed or the stroke"];

const LIMITS: [Limit; 12] = [
    // Above 1 nothing swings back; the machine members in the literature have 0.005 … 0.1.
    (
        "damping_ratio",
        1.0,
        "the member does not vibrate at all; damping ratios of machines are some hundredths",
        ["a percentage is written with its sign: \"3 %\""; 2],
    ),
    // The rim of a steel disc of 100 mm runs at 520 m/s at this speed, beyond its bursting speed.
    ("speed", SPEED, "a cam of steel would burst", FORGOTTEN_RPM),
    ("synchronous_speed", SPEED, "a shaft of steel would burst", FORGOTTEN_RPM),
    ("mean_speed", SPEED, "a shaft of steel would burst", FORGOTTEN_RPM),
    // Pulled at its end with this acceleration, a steel bar of 1 m carries ρ l a = 800 N/mm² from its own mass alone.
    ("largest_acceleration", 1e5, "ten thousand times gravity tears steel apart", FORGOTTEN_IN_MOTION),
    // The cam would be larger than this.
    ("stroke", 10.0, "no cam moves a tool that far", FORGOTTEN_LENGTH),
    ("crank_radius", 10.0, "no crank of a machine is that large", FORGOTTEN_LENGTH),
    // The grippers of looms reach some 50 m/s. With a stroke forgotten in mm the tool is as fast as a rifle bullet.
    ("largest_velocity", 100.0, "no tool of a machine moves that fast", FORGOTTEN_IN_MOTION),
    // Backlash is some hundredths of a millimetre.
    ("clearance_of_stroke", 0.3, "the tool would hardly follow the cam", FORGOTTEN_LENGTH),
    // The tool would not follow its law; in HS drives of machines it misses some per cent.
    ("kinetostatic_deformation_of_stroke", 0.3, "the tool would hardly follow the cam", FORGOTTEN_IN_VIBRATION),
    // In the middle of the first tongue of instability it is 2.
    ("frequency_ratio", 10.0, "so far above its natural frequency no member follows its drive", FORGOTTEN_IN_VIBRATION),
    // At slip 2 the shaft turns backwards with the synchronous speed; motors for standstill come to a little above 1.
    (
        "breakdown_slip",
        2.0,
        "the torque would be largest where the motor is turned backwards",
        ["a percentage is written with its sign: \"15 %\""; 2],
    ),
];

/// Warns of figures beyond their limits; the kinetostatic deformation says nothing on a motion that is `judged` itself.
pub fn warn(overview: &mut Overview, judged: bool) {
    for figure in overview.figures.iter().filter(|of| !judged || of.name != "kinetostatic_deformation_of_stroke") {
        let name = figure.name.rsplit('.').next().unwrap_or_default();
        let angular = figure.unit.starts_with("rad") && !name.ends_with("speed");
        let Some((_, limit, why, hint)) = LIMITS.iter().find(|(limited, ..)| *limited == name && !angular) else {
            continue;
        };
        if figure.value.abs() >= *limit {
            let message = format!("{} {}: {why}", figure.name.replace('_', " "), figure.shown);
            overview.warnings.push(Warning { message, hint: hint[0].to_owned() });
        }
    }
}

impl Overview {
    /// Remedies for a scene that has its units.
    pub fn with_units(&mut self) {
        for warning in &mut self.warnings {
            if let Some((.., [_, remedy])) = LIMITS.iter().find(|(.., [unit, _])| *unit == warning.hint) {
                warning.hint = (*remedy).to_owned();
            }
        }
    }
}
