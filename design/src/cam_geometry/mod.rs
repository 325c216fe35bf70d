//! From the motion law to the cam: path of the roller's centre, contours, and checks that they can be cut and run.
//!
//! The cam's centre is the origin; it turns by σφ, σ = ±1. In the fixed frame the roller's centre is p(φ), seen from the cam
//! z = e^{−iσφ} p. With v = p′ − iσp, in the fixed frame,
//!
//! z′ = e^{−iσφ} v,  z″ = e^{−iσφ} (p″ − 2iσp′ − p),  κ = Im(z̄′z″)/|z′|³,
//! contours c = z ± ϱ n, n = i z′/|z′|,  their curvature κ/(1 ∓ ϱκ).
//!
//! The pressure angle lies between the common normal iv and the direction in which the roller's centre moves. Symbols: φ
//! angle of the drive (rad); p, z positions (m); ϱ radius of the roller (m); κ curvature (1/m), positive to the left; ′ =
//! d/dφ.
//!
//! A flat face at right angles to its line, at the height h = h₀ + U, touches the contour at the distance σU′ from the cam's
//! centre: h is the support function of the contour, whose radius of curvature is h + U″, and the pressure angle is 0. p = σU′
//! + i (h + ϱ) is then the centre of a cutter of radius ϱ on the other side of the face.
//!
//! Source: VDI 2142 and VDI 2143 (cam mechanisms: roller lever, translating follower, pressure angle, undercut); Norton, *Cam
//! Design and Manufacturing Handbook*, section 7.4 (flat-faced follower); the complex forms are derived here.

pub mod cam_table;
mod checks;
mod contour;
mod figures;
pub mod files;
pub mod inverse;
mod plan;
pub mod report;
mod shape;
#[cfg(test)]
mod tests;

pub use checks::{Finding, Limits};
pub use contour::{Mesh, Outline, Side};
pub use plan::{Carrier, Cut, Plan, Second, Start};
pub use shape::{Disc, Shape, Tolerances};

use camdrive::drives::Fault;
use camdrive::motion::MotionLaw;
use num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// A point of the plane (m).
pub type Point = Complex<f64>;

const I: Point = Point::new(0.0, 1.0);

/// The follower that carries the roller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Follower {
    /// A lever of length l about a pivot at (d, 0): p = d − l e^{−isψ}, ψ = ψ₀ + U/R the angle from the line pivot–cam centre.
    Lever {
        /// d (m).
        pivot: f64,
        /// l (m).
        length: f64,
        /// ψ₀ (rad), at U = 0.
        start: f64,
        /// R (m/rad): the motion of the tool per angle of the lever; negative if they run against each other. 1 if U is an
        /// angle.
        transmission: f64,
        /// s = ±1: the side of the line pivot–cam centre on which the roller is.
        side: f64,
    },
    /// A follower on a line at the distance e from the cam's centre: p = e + i (h₀ + U).
    Translating {
        /// e (m).
        eccentricity: f64,
        /// h₀ (m), at U = 0.
        start: f64,
    },
    /// A follower that touches the cam with a flat face at the height h₀ + U.
    Flat {
        /// h₀ (m), at U = 0.
        start: f64,
    },
}

/// A cam.
#[derive(Clone, Debug, PartialEq)]
pub struct Cam {
    /// U(φ) (m or rad).
    pub law: MotionLaw,
    /// The follower that carries the roller.
    pub follower: Follower,
    /// σ: 1 if the cam turns counter-clockwise, −1 if clockwise.
    pub sense: f64,
    /// ϱ (m); for a flat face the cutter's, which may be 0.
    pub roller: f64,
}

/// The cam at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamPosition {
    /// φ (rad).
    pub phi: f64,
    /// U (m or rad).
    pub lift: f64,
    /// ψ of a lever (rad), h₀ + U of other followers (m).
    pub coordinate: f64,
    /// z (m).
    pub centre: Point,
    /// z′/|z′|.
    pub tangent: Point,
    /// |z′| (m/rad).
    pub speed: f64,
    /// κ (1/m) of the path of the roller's centre.
    pub curvature: f64,
    /// The pressure angle (rad), 0 … π/2.
    pub pressure: f64,
    /// p (m), the roller's centre in the fixed frame.
    pub place: Point,
    /// n, the normal of the path in the fixed frame that points away from the inner contour.
    pub normal: Point,
    /// n · dp/dU: the motion of the roller's centre along n per unit of U.
    pub gain: f64,
}

/// The roller's centre stands still on the cam if its speed is below this part of its distance: path and normal then have no
/// direction.
const STANDSTILL: f64 = 1e-9;

/// The roller's centre stands still on the cam at φ (rad): neither path nor contour has a direction there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standstill(pub f64);

impl From<Standstill> for Fault {
    fn from(Standstill(phi): Standstill) -> Self {
        Fault::new(format!(
            "at φ = {:.3}° the roller's centre stands still on the cam, whose contour has no direction there; place the roller farther from the cam's centre",
            degrees(phi)
        ))
    }
}

/// An angle of the turn (°), from 0 on: to the three shown decimals a full turn is 0.
fn degrees(phi: f64) -> f64 {
    let degrees = phi.rem_euclid(TAU).to_degrees();
    if degrees < 360.0 - 5e-4 { degrees } else { 0.0 }
}

impl Follower {
    /// ψ or h₀ + U, its coordinate.
    pub fn coordinate(&self, u: f64) -> f64 {
        match *self {
            Follower::Lever { start, transmission, .. } => start + u / transmission,
            Follower::Translating { start, .. } | Follower::Flat { start } => start + u,
        }
    }

    /// p, p′, p″ of a roller and dp/dU, with U, U′, U″ in `u`.
    fn position(&self, [u, u1, u2]: [f64; 3]) -> ([Point; 3], Point) {
        match *self {
            Follower::Lever { pivot, length, start, transmission, side } => {
                let (psi, psi1, psi2) = (start + u / transmission, u1 / transmission, u2 / transmission);
                let arm = Point::from_polar(length, -side * psi);
                let p1 = I * side * psi1 * arm;
                let p2 = (I * side * psi2 + psi1 * psi1) * arm;
                ([Point::from(pivot) - arm, p1, p2], I * side * arm / transmission)
            }
            Follower::Translating { eccentricity, start } => ([Point::new(eccentricity, start + u), I * u1, I * u2], I),
            Follower::Flat { start } => ([Point::new(0.0, start + u), I * u1, I * u2], I),
        }
    }
}

impl Cam {
    /// The cam at φ, on this piece of the motion law.
    ///
    /// # Errors
    /// A roller's centre that stands still on the cam.
    pub fn at_in(&self, segment: usize, phi: f64) -> Result<CamPosition, Standstill> {
        let [u, u1, u2, ..] = self.law.at_in(segment, phi).0;
        // Turned back into the frame of the cam; angles stay.
        let back = Point::from_polar(1.0, -self.sense * phi);
        if let Follower::Flat { start } = self.follower {
            let (coordinate, radius) = (start + u, start + u + u2 + self.roller);
            let place = Point::new(self.sense * u1, coordinate + self.roller);
            return Ok(CamPosition {
                phi,
                lift: u,
                coordinate,
                centre: back * place,
                tangent: back * self.sense,
                speed: radius.abs(),
                curvature: -self.sense / radius,
                pressure: 0.0,
                place,
                normal: I,
                gain: 1.0,
            });
        }
        let ([p, p1, p2], by_lift) = self.follower.position([u, u1, u2]);
        let turn = I * self.sense;
        let v = p1 - turn * p;
        let acceleration = p2 - 2.0 * turn * p1 - p;
        let speed = v.norm();
        if speed <= STANDSTILL * p.norm() || speed.is_nan() {
            return Err(Standstill(phi));
        }
        let along = (v.conj() * by_lift).re.abs();
        let across = (v.conj() * by_lift).im.abs();
        let normal = turn * v / speed;
        Ok(CamPosition {
            phi,
            lift: u,
            coordinate: self.follower.coordinate(u),
            centre: back * p,
            tangent: back * v / speed,
            speed,
            curvature: (v.conj() * acceleration).im / speed.powi(3),
            pressure: along.atan2(across),
            place: p,
            normal,
            gain: (normal.conj() * by_lift).re,
        })
    }

    /// Contour and path at φ in one turn, with the right-hand values on a breakpoint of the law.
    ///
    /// # Errors
    /// A roller's centre that stands still on the cam.
    pub fn at(&self, phi: f64) -> Result<CamPosition, Standstill> {
        let phi = if phi > PI { phi - TAU } else { phi };
        self.at_in(self.law.segment(phi, true), phi)
    }

    /// The second cam of a conjugate pair; its follower is fixed to the first one's.
    ///
    /// For a lever ψ₂ = λ − ψ on the other side of the line pivot–cam centre, λ the angle between both arms and l₂ its own
    /// length; for a translating follower h₂ = h − D, D the distance of both rollers, so that it is on the other side of
    /// the cam's centre.
    pub fn conjugate(&self, second: Second) -> Cam {
        let follower = match self.follower {
            Follower::Lever { pivot, start, transmission, side, .. } => Follower::Lever {
                pivot,
                length: second.length,
                start: second.place - start,
                transmission: -transmission,
                side: -side,
            },
            Follower::Translating { eccentricity, start } => {
                Follower::Translating { eccentricity, start: start - second.place }
            }
            // It has no second face.
            Follower::Flat { .. } => self.follower,
        };
        Cam { law: self.law.clone(), follower, sense: self.sense, roller: second.roller }
    }
}
