//! User's settings of the drive: series of coefficients, or a parallel crank by its physical parameters.

use super::coefficients::{Coefficients, Stiffness};
use super::crank::ParallelCrank;
use crate::drives::parameter::parameters;
use crate::drives::{Fault, Number};
use crate::motion::Fourier;
use serde::{Deserialize, Serialize};

/// The source of the coefficients.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// Finite Fourier series.
    Series(SeriesLaw),
    /// A parallel-crank drive.
    Crank(CrankLaw),
}

/// m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ), each a finite Fourier series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeriesLaw {
    /// Kind of the coordinate q.
    pub coordinate: Coordinate,
    /// m(φ) (kg·m² or kg).
    pub m: Fourier,
    /// b(φ) (N·m·s/rad or N·s/m).
    pub b: Fourier,
    /// c(φ) (N·m/rad or N/m).
    pub c: Fourier,
    /// f(φ) (N·m or N); None without excitation.
    pub f: Option<Fourier>,
}

/// Kind of the coordinate q.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinate {
    /// An angle (rad).
    Rotation,
    /// A length (m).
    Translation,
}

/// J ψ̈ + b_T q̇ + c_T(φ) q = f(φ), ψ = φ + q.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CrankLaw {
    /// Shafts, cranks and rods.
    pub crank: ParallelCrank,
    /// Moment of inertia on the driven side J (kg·m²).
    pub inertia: f64,
    /// Damping between both sides b_T (N·m·s/rad).
    pub damping: f64,
    /// Torque on the driven side f(φ) (N·m), positive in the sense of φ; None without a load.
    pub load: Option<Fourier>,
    /// The highest harmonic of c_T that counts; None for all of them.
    pub harmonics: Option<usize>,
}

parameters! {
    for CrankLaw, "crank" {
        /// Moment of inertia on the driven side; above zero
        inertia = "J", "J", INERTIA in [1e-12, 1e12], Fixed;
        /// Torsional damping between both sides
        damping = "b_T", "b_T", ROTATIONAL_DAMPING in [0.0, 1e12] or 0.0, Fixed;
        /// Torsional stiffness of the driving shaft; above zero
        crank.c_t1 = "c_T1", "c_T1", ROTATIONAL_STIFFNESS in [1e-12, 1e15], Fixed;
        /// Torsional stiffness of the driven shaft; above zero
        crank.c_t2 = "c_T2", "c_T2", ROTATIONAL_STIFFNESS in [1e-12, 1e15], Fixed;
        /// Longitudinal stiffness of a coupling rod; above zero
        crank.c_ab = "c_AB", "c_AB", STIFFNESS in [1e-12, 1e15], Fixed;
        /// Length of the cranks; above zero
        crank.r = "R", "R", LENGTH in [1e-6, 1e4], Fixed;
    }
}

impl Law {
    /// m, b, c and f.
    pub fn coefficients(&self) -> Coefficients {
        let constant = |value: f64| Fourier::new(vec![value], Vec::new());
        let load = |load: &Option<Fourier>| load.clone().unwrap_or_else(|| constant(0.0));
        match self {
            Law::Series(SeriesLaw { m, b, c, f, .. }) => {
                Coefficients { m: m.clone(), b: b.clone(), c: Stiffness::Series(c.clone()), f: load(f) }
            }
            Law::Crank(crank) => {
                let whole = Stiffness::of_crank(&crank.crank);
                Coefficients {
                    m: constant(crank.inertia),
                    b: constant(crank.damping),
                    c: crank.harmonics.map_or(whole.clone(), |order| Stiffness::Series(whole.harmonics(order))),
                    f: load(&crank.load),
                }
            }
        }
    }

    /// Whether q counts from the drive, so that the mass moves by φ + q.
    pub fn is_relative(&self) -> bool {
        matches!(self, Law::Crank(_))
    }

    /// Kind of the coordinate q.
    pub fn coordinate(&self) -> Coordinate {
        match self {
            Law::Series(series) => series.coordinate,
            Law::Crank(_) => Coordinate::Rotation,
        }
    }

    /// Refuses laws that make no drive.
    pub fn validate(&self) -> Result<(), Fault> {
        match self {
            Law::Series(series) => series.validate(),
            Law::Crank(_) => Ok(()),
        }
    }
}

impl SeriesLaw {
    fn validate(&self) -> Result<(), Fault> {
        for (name, series) in
            [("m", &self.m), ("b", &self.b), ("c", &self.c)].into_iter().chain(self.f.iter().map(|f| ("f", f)))
        {
            if !(series.bound(0) + series.bound(3)).is_finite() {
                return Err(Fault::named(name, format!(": the Fourier coefficients of {name}(φ) must be finite")));
            }
        }
        let unit = if self.coordinate == Coordinate::Rotation { "kg·m²" } else { "kg" };
        let (phi, least) = Law::Series(self.clone()).coefficients().least_mass();
        if least > 0.0 {
            return Ok(());
        }
        let message = format!(
            ": m(φ) is {} {unit} at φ = {} rad ({:.4}°), and must be above 0 over the whole turn: without mass the \
             equation has no acceleration; raise m.a[0] or lower the harmonics of m",
            Number(least),
            Number(phi),
            phi.to_degrees()
        );
        Err(Fault::named("m", message))
    }
}
