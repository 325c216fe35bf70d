//! The equations of motion in time, used if the angle cannot serve as the variable.
//!
//! With u = √J φ̇ the equation of motion becomes
//!
//! φ̇ = u / √J(φ),  u̇ = (M_an − τ) / √J(φ),  [T_el Ṁ_an = M_Kloss(φ̇) − M_an]
//!
//! since d(½u²)/dt = (M_an − τ) φ̇. J′ drops out, so the equations are one order smoother than the original, and without torques u,
//! hence the energy, is constant to the last digit.

use super::coupled::Polynomial;
use super::motor::{Kloss, Motor};
use super::{Shaft, State};
use crate::numerics::collocation::System;
use crate::numerics::double_double::Double;
use std::f64::consts::TAU;

/// The equations of motion on one smooth piece, for the increments of φ, u and M_an over a step.
pub struct Piece<'a> {
    shaft: &'a Shaft,
    base: &'a State,
    /// Inertia of loads over the increment of φ.
    loads: Option<Polynomial>,
    /// The start of the integrator's time after the communication point (s).
    since: f64,
    /// The most that φ may change in a step (rad).
    pub reach: f64,
}

impl<'a> Piece<'a> {
    /// The equations from the state `base` on, in a time that begins `since` (s) after the communication point.
    pub fn new(shaft: &'a Shaft, base: &'a State, since: f64) -> Self {
        // A wave of J within a step leaves eight nodes per wave. A law is not valid outside of its interval, so its continuation is
        // not followed far.
        let inertia = &shaft.inertia;
        let (low, high) = inertia.ends(base.interval);
        let wave = if inertia.varies() { TAU / inertia.resolution() } else { f64::INFINITY };
        Piece { shaft, base, loads: shaft.loads.from(base), since, reach: wave.min(high - low) }
    }

    /// φ after this increment (rad).
    fn angle(&self, increment: f64) -> f64 {
        self.base.angle.hi + (self.base.angle.lo + increment)
    }

    /// √J after this increment.
    fn root(&self, increment: f64) -> f64 {
        let own = self.shaft.profile.value(self.base.interval, self.angle(increment));
        self.loads.map_or(own, |loads| own + loads.at(increment)[0]).sqrt()
    }

    fn u(&self, increment: f64) -> f64 {
        self.base.u.hi + (self.base.u.lo + increment)
    }

    /// M_an and its derivative with respect to the speed.
    fn torque(&self, t: Double, w: f64, lagging: Option<&f64>) -> [f64; 2] {
        if let Some(increment) = lagging {
            return [self.base.torque + increment, 0.0];
        }
        if self.shaft.motor == Motor::Input {
            return [self.shaft.driving.at(self.since + t.hi), 0.0];
        }
        let [torque, slope, _] = self.shaft.motor.characteristic(w);
        [torque, slope]
    }
}

impl<const N: usize> System<N> for Piece<'_> {
    fn rhs(&self, t: Double, y: &[f64; N]) -> [f64; N] {
        let root = self.root(y[0]);
        let w = self.u(y[1]) / root;
        let [torque, _] = self.torque(t, w, y.get(2));
        let mut rate = [0.0; N];
        rate[0] = w;
        rate[1] = (torque - self.shaft.loads.at(self.since + t.hi)) / root;
        if let (Some(rate), Some(lag)) = (rate.get_mut(2), self.shaft.motor.lag()) {
            *rate = (self.shaft.motor.characteristic(w)[0] - torque) / lag;
        }
        rate
    }

    fn jacobian(&self, t: Double, y: &[f64; N]) -> [[f64; N]; N] {
        let own = self.shaft.profile.with_slope(self.base.interval, self.angle(y[0]));
        let [j, slope] = self.loads.map_or(own, |loads| [0, 1].map(|n| own[n] + loads.at(y[0])[n]));
        let root = j.sqrt();
        let w = self.u(y[1]) / root;
        let [torque, torque_slope] = self.torque(t, w, y.get(2));
        // The derivative of ln(1/√J).
        let bend = -0.5 * slope / j;
        let mut m = [[0.0; N]; N];
        (m[0][0], m[0][1]) = (w * bend, 1.0 / root);
        m[1][0] = ((torque - self.shaft.loads.at(self.since + t.hi)) + torque_slope * w) * bend / root;
        m[1][1] = torque_slope / j;
        if let (true, Some(lag)) = (N > 2, self.shaft.motor.lag()) {
            let slope = self.shaft.motor.characteristic(w)[1];
            m[1][N - 1] = 1.0 / root;
            (m[N - 1][0], m[N - 1][1]) = (slope * w * bend / lag, slope / (root * lag));
            m[N - 1][N - 1] = -1.0 / lag;
        }
        m
    }

    /// Errors of angles are relative to the radian, of u to itself, of a lagging torque to the breakdown torque.
    fn magnitude(&self, y: &[f64; N]) -> [f64; N] {
        let mut magnitude = [1.0; N];
        magnitude[1] = self.u(y[1]).abs();
        if let (Some(magnitude), Motor::Kloss(Kloss { breakdown_torque, .. })) =
            (magnitude.get_mut(2), self.shaft.motor)
        {
            *magnitude = breakdown_torque.max(self.base.torque.abs());
        }
        magnitude
    }

    /// The time in which φ changes by `reach` under the present acceleration.
    fn longest_step(&self, t: Double, y: &[f64; N]) -> f64 {
        if self.reach.is_infinite() {
            return f64::INFINITY;
        }
        let rate = self.rhs(t, y);
        let (w, a) = (rate[0].abs(), (rate[1] / self.root(y[0])).abs());
        2.0 * self.reach / (w + (w * w + 2.0 * a * self.reach).sqrt())
    }
}
