//! The balance of energy at constant speed: d/dt [½ m q̇² + ½ c q²] = f q̇ − b q̇² + ½ (m′ q̇² + c′ q²) ω.
//!
//! The motion is known at any instant of the present cell, so that the balance is struck when somebody asks for it, and costs
//! nothing else.

use super::ParametricDrive;
use super::coefficients::Values;
use crate::drives::energy::{self, Balanced};
use crate::numerics::double_double::Double;

impl ParametricDrive {
    /// |ΔE − ∫ power dt| over the last waves of the motion, relative to the largest E among them.
    pub(super) fn energy_residual(&self) -> f64 {
        let known = match (&self.course, self.table.as_ref().and_then(|table| table.map.as_ref())) {
            (Some(course), Some(map)) => Some((course, map)),
            _ => None,
        };
        let again = |time: f64| match known {
            Some((course, map)) => course.at(map, time),
            None => self.integrator.at(Double::from(time)),
        };
        let from = known.map_or(self.integrator.start().hi, |(course, _)| course.cell_start());
        energy::residual_at_last([from, self.time], self.fastest_rate(), |time| {
            let shaft = self.motion.at(time);
            self.coefficients.at(shaft.reduced).balanced(again(time), shaft.kinematics.0[1])
        })
    }

    /// The rate of the fastest of vibration, damping and coefficients [rad/s].
    fn fastest_rate(&self) -> f64 {
        let damping = self.coefficients.b.bound(0) / self.coefficients.least_mass().1;
        let [frequency, angle] = self.pace;
        // A step of fixed cost is half a radian of the shortest wave.
        frequency.max(damping).max(0.5 * self.motion.coefficients[1].abs() / angle)
    }
}

impl Values {
    /// E, its power and the rate of that at the speed ω = `w` [rad/s].
    fn balanced(&self, [q, v]: [f64; 2], w: f64) -> Balanced {
        let Values { m, b, c, f } = self;
        let a = (f[0] - b[0] * v - c[0] * q) / m[0];
        let (vv, qq) = (v * v, q * q);
        Balanced {
            energy: 0.5 * (m[0] * vv + c[0] * qq),
            power: (f[0] - b[0] * v) * v + 0.5 * (m[1] * vv + c[1] * qq) * w,
            power_rate: (f[1] - b[1] * v) * w * v
                + (f[0] - 2.0 * b[0] * v) * a
                + (0.5 * (m[2] * vv + c[2] * qq) * w + m[1] * v * a + c[1] * q * v) * w,
        }
    }
}
