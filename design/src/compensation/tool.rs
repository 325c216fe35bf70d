//! The tools: what a cam moves, itself or by a lever and the mechanisms behind it.

use super::spectral::{Mesh, amplitude, largest};
use camdrive::drives::rigid_machine::Follower;
use camdrive::motion::{Fourier, MotionLaw};

/// The highest harmonic that is looked for in the motion of a tool behind mechanisms.
const HIGHEST: usize = 256;

/// Harmonics of the acceleration below this part of the largest are no longer counted to the motion that is wanted.
const SMALL: f64 = 1e-10;

/// A tool whose motion is prescribed in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// The number of the follower in the scene, from 1.
    pub number: usize,
    /// Its mass and the mechanisms before it; the cam's law is [`Tool::motion`].
    follower: Follower,
    /// U(ψ), the motion in time of what the cam moves: of the tool (m or rad), or of the lever (rad).
    pub motion: Fourier,
    /// The motion in time of the tool: U itself, or behind mechanisms the series of its relevant harmonics.
    pub wanted: Fourier,
}

impl Tool {
    /// The tool of the follower with this number, which is to move in time as its cam's law says; None where that is no Fourier series.
    pub fn of(number: usize, follower: Follower) -> Option<Self> {
        let motion = follower.cam.series()?.clone();
        if follower.linkage.is_empty() {
            return Some(Tool { number, follower, wanted: motion.clone(), motion });
        }
        let mesh = Mesh::new(HIGHEST);
        let places: Vec<f64> = (0..mesh.len()).map(|i| follower.tool([motion.at(mesh.point(i)).0[0]])[0]).collect();
        let full = mesh.series(&places);
        let share = |k: usize| (k * k) as f64 * amplitude(&full, k);
        let most = (1..=HIGHEST).map(share).fold(0.0, f64::max);
        // The rounding of the places, which the acceleration multiplies by k².
        let rounding = f64::EPSILON * largest(motion.order(), |psi| follower.tool([motion.at(psi).0[0]])[0])[1];
        let counts = |k: &usize| share(*k) > SMALL * most && amplitude(&full, *k) > 4.0 * rounding;
        let order = (1..=HIGHEST).rev().find(counts).unwrap_or(1);
        let wanted = Fourier::new(full.a[..=order].to_vec(), full.b[..=order].to_vec());
        Some(Tool { number, follower, motion, wanted })
    }

    /// The follower with this law of its cam.
    pub fn with_law(&self, law: &MotionLaw) -> Follower {
        Follower { cam: law.clone(), ..self.follower.clone() }
    }

    /// Whether the tool's coordinate is an angle.
    pub fn turns(&self) -> bool {
        self.follower.turns
    }

    /// y(ψ) of the tool and its derivatives.
    pub fn at(&self, psi: f64) -> [f64; 5] {
        self.follower.tool(self.motion.at(psi).0)
    }

    /// The moment of inertia of the tool and all links, and the tool's y′ and y, where the cam's law has this value and slope.
    pub fn carried(&self, cam: [f64; 2]) -> [f64; 3] {
        let [y, slope] = self.follower.tool(cam);
        [self.follower.inertia(cam)[0], slope, y]
    }

    /// The part of S(ψ) (kg·m²).
    pub fn inertia(&self, psi: f64) -> f64 {
        let [u, u1, ..] = self.motion.at(psi).0;
        self.carried([u, u1])[0]
    }

    /// The phase and the size of the largest acceleration Ω²|y″| (m/s² or rad/s²).
    pub fn acceleration(&self, mean_speed: f64) -> [f64; 2] {
        largest(self.wanted.order(), |psi| mean_speed * mean_speed * self.at(psi)[2])
    }

    /// The tool's position and its derivatives by the time, where `cam` are those of the cam's law.
    pub fn moved<const N: usize>(&self, cam: [f64; N]) -> [f64; N] {
        self.follower.tool(cam)
    }
}
