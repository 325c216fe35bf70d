//! Physical quantities with their units, as the model description declares them.

/// A physical quantity: its name (ISO 80000, as MSL writes it), its coherent SI unit and the unit engineers read.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// For example "Torque"; "" where no quantity name is in use.
    pub name: &'static str,
    /// The unit, for example "N.m".
    pub unit: &'static str,
    /// Exponents of kg, m, s, rad.
    pub base: [i8; 4],
    /// Display unit and how many of it make one SI unit.
    pub display: Option<(&'static str, f64)>,
}

impl Quantity {
    /// The SI value of one unit as engineers read it.
    pub fn usual(&self) -> f64 {
        self.display.map_or(1.0, |(_, factor)| 1.0 / factor)
    }
}

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident = $quantity:literal, $unit:literal, $base:expr, $display:expr;)*) => {
        $($(#[$doc])* pub static $name: Quantity =
            Quantity { name: $quantity, unit: $unit, base: $base, display: $display };)*
    };
}

quantities! {
    /// A pure number.
    NUMBER = "Number", "1", [0, 0, 0, 0], None;
    /// Mass (kg).
    MASS = "Mass", "kg", [1, 0, 0, 0], None;
    /// Moment of inertia (kg·m²).
    INERTIA = "MomentOfInertia", "kg.m2", [1, 2, 0, 0], None;
    /// The derivative of a moment of inertia by the angle (kg·m²/rad).
    INERTIA_PER_ANGLE = "MomentOfInertiaPerAngle", "kg.m2/rad", [1, 2, 0, -1], None;
    /// Translational stiffness (N/m).
    STIFFNESS = "TranslationalSpringConstant", "N/m", [1, 0, -2, 0], Some(("N/mm", 1e-3));
    /// Translational damping (N·s/m).
    DAMPING = "TranslationalDampingConstant", "N.s/m", [1, 0, -1, 0], None;
    /// Rotational stiffness (N·m/rad).
    ROTATIONAL_STIFFNESS = "RotationalSpringConstant", "N.m/rad", [1, 2, -2, -1], None;
    /// Rotational damping (N·m·s/rad).
    ROTATIONAL_DAMPING = "RotationalDampingConstant", "N.m.s/rad", [1, 2, -1, -1], None;
    /// Length (m).
    LENGTH = "Length", "m", [0, 1, 0, 0], Some(("mm", 1e3));
    /// The first derivative of a length by the angle (m/rad).
    LENGTH_PER_ANGLE = "LengthPerAngle", "m/rad", [0, 1, 0, -1], None;
    /// The second derivative of a length by the angle (m/rad²).
    LENGTH_PER_ANGLE2 = "LengthPerAngle2", "m/rad2", [0, 1, 0, -2], None;
    /// The third derivative of a length by the angle (m/rad³).
    LENGTH_PER_ANGLE3 = "LengthPerAngle3", "m/rad3", [0, 1, 0, -3], None;
    /// A rate (1/s).
    RATE = "Rate", "1/s", [0, 0, -1, 0], None;
    /// Velocity (m/s).
    VELOCITY = "Velocity", "m/s", [0, 1, -1, 0], None;
    /// Acceleration (m/s²).
    ACCELERATION = "Acceleration", "m/s2", [0, 1, -2, 0], None;
    /// Angle (rad).
    ANGLE = "Angle", "rad", [0, 0, 0, 1], Some(("deg", 57.29577951308232));
    /// Angular velocity (rad/s).
    ANGULAR_VELOCITY = "AngularVelocity", "rad/s", [0, 0, -1, 1], Some(("rpm", 9.549296585513721));
    /// Angular acceleration (rad/s²).
    ANGULAR_ACCELERATION = "AngularAcceleration", "rad/s2", [0, 0, -2, 1], None;
    /// Force (N).
    FORCE = "Force", "N", [1, 1, -2, 0], None;
    /// Torque (N·m).
    TORQUE = "Torque", "N.m", [1, 2, -2, 0], None;
    /// Impulse (N·s).
    IMPULSE = "Impulse", "N.s", [1, 1, -1, 0], None;
    /// Energy (J).
    ENERGY = "Energy", "J", [1, 2, -2, 0], None;
    /// Time (s).
    TIME = "Time", "s", [0, 0, 1, 0], Some(("ms", 1e3));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_usual_unit_in_si() {
        // 1 kg, 1 mm, 1 ms, 1 degree.
        assert_eq!([MASS.usual(), LENGTH.usual(), TIME.usual()], [1.0, 1e-3, 1e-3]);
        assert!((ANGLE.usual().to_degrees() - 1.0).abs() < 1e-15);
    }
}
