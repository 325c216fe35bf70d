//! The tools, which a cam moves directly or by a lever and mechanisms.

use super::spectral::{Mesh, amplitude, largest};
use camdrive::drives::rigid_machine::Follower;
use camdrive::motion::{Fourier, MotionLaw};
use std::f64::consts::TAU;

/// The highest harmonic searched in the motion of a tool with mechanisms.
const HIGHEST: usize = 256;

/// Harmonics of the acceleration below this part of the largest do not count as part of the wanted motion.
const SMALL: f64 = 1e-10;

/// A tool whose motion is prescribed in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// The number of the follower in the scene, from 1.
    pub number: usize,
    /// Its mass and its mechanisms; the cam's law is [`Tool::motion`].
    follower: Follower,
    /// U(ψ), the motion in time of the part that the cam moves: the tool (m or rad) or the lever (rad).
    pub motion: MotionLaw,
    /// The motion in time of the tool: U itself; with mechanisms or if U is no series, the series of its relevant harmonics.
    pub wanted: Fourier,
}

impl Tool {
    /// The tool of the follower with this number, which is to follow its cam's law in time.
    pub fn of(number: usize, follower: Follower) -> Self {
        let motion = follower.cam.clone();
        let own = motion.series().filter(|_| follower.linkage.is_empty()).cloned();
        let mut tool = Tool { number, follower, wanted: Fourier::new(vec![0.0], Vec::new()), motion };
        tool.wanted = own.unwrap_or_else(|| tool.relevant());
        tool
    }

    /// The relevant harmonics of y(ψ).
    fn relevant(&self) -> Fourier {
        let mesh = Mesh::new(HIGHEST);
        let places: Vec<f64> = (0..mesh.len()).map(|i| self.at(mesh.point(i))[0]).collect();
        let full = mesh.series(&places);
        let share = |k: usize| (k * k) as f64 * amplitude(&full, k);
        let most = (1..=HIGHEST).map(share).fold(0.0, f64::max);
        // The rounding of the places, which the acceleration multiplies by k².
        let rounding = f64::EPSILON * places.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
        let counts = |k: &usize| share(*k) > SMALL * most && amplitude(&full, *k) > 4.0 * rounding;
        let order = (1..=HIGHEST).rev().find(counts).unwrap_or(1);
        Fourier::new(full.a[..=order].to_vec(), full.b[..=order].to_vec())
    }

    /// U(ψ) and its derivatives; at a jump after (`forward`) or before it.
    pub fn driven_beside(&self, psi: f64, forward: bool) -> [f64; 5] {
        match &self.motion {
            MotionLaw::Fourier(series) => series.at(psi).0,
            law => law.at_in(law.segment(psi.rem_euclid(TAU), forward), psi.rem_euclid(TAU)).0,
        }
    }

    /// U(ψ) and its derivatives; at a jump after it.
    pub fn driven(&self, psi: f64) -> [f64; 5] {
        self.driven_beside(psi, true)
    }

    /// The follower with this law of its cam.
    pub fn with_law(&self, law: &MotionLaw) -> Follower {
        Follower { cam: law.clone(), ..self.follower.clone() }
    }

    /// True if the tool's coordinate is an angle.
    pub fn turns(&self) -> bool {
        self.follower.turns
    }

    /// y(ψ) of the tool and its derivatives.
    pub fn at(&self, psi: f64) -> [f64; 5] {
        self.follower.tool(self.driven(psi))
    }

    /// Load of a cam with this value, slope and curvature: the moment of inertia J of tool and links with J′, and the tool's
    /// y, y′ and y″.
    pub fn carried(&self, cam: [f64; 3]) -> [f64; 5] {
        let ([j, slope, _], [y, y1, y2]) = (self.follower.inertia(cam), self.follower.tool(cam));
        [j, slope, y, y1, y2]
    }

    /// Its part of S(ψ) (kg·m²).
    pub fn inertia(&self, psi: f64) -> f64 {
        let [u, u1, ..] = self.driven(psi);
        self.follower.inertia([u, u1])[0]
    }

    /// Its part of S and S′.
    pub fn inertia_beside(&self, psi: f64, forward: bool) -> [f64; 2] {
        let [u, u1, u2, ..] = self.driven_beside(psi, forward);
        let [j, slope, _] = self.follower.inertia([u, u1, u2]);
        [j, slope]
    }

    /// The phase and the size of the largest acceleration Ω²|y″| (m/s² or rad/s²).
    pub fn acceleration(&self, mean_speed: f64) -> [f64; 2] {
        largest(self.wanted.order(), |psi| mean_speed * mean_speed * self.at(psi)[2])
    }

    /// The tool's position and its derivatives by time, from the cam law's in `cam`.
    pub fn moved<const N: usize>(&self, cam: [f64; N]) -> [f64; N] {
        self.follower.tool(cam)
    }
}
