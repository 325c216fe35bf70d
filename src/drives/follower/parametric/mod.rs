//! The equation of motion, written once for numbers and for series.

pub mod coefficients;
pub mod crank;
pub mod law;

use crate::drives::follower::elastic_shaft::REACH;
use crate::drives::follower::equation::{Equation, Pace, Segments, Words};
use crate::drives::follower::flow::Flow;
use crate::drives::follower::load::Load;
use crate::drives::limits::refused_start;
use crate::drives::{Fault, Number};
use crate::motion::MotionLaw;
use crate::numerics::angle;
use crate::numerics::divisor::greatest_common_divisor;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::Scalar;
use coefficients::{Coefficients, Values, symmetry};
use law::Law;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

impl Values {
    /// −(c q + b q̇): the force that spring and damper transmit (N·m or N).
    pub fn transmitted<S: Scalar>(&self, flow: &Flow<S>) -> S {
        -(of(flow, &self.c) * flow.q + of(flow, &self.b) * flow.v)
    }

    /// ½ (m′ q̇² + c′ q²): the torque by which the drive feeds ½ m q̇² + ½ c q² as m and c vary (N·m).
    pub fn parametric_torque<S: Scalar>(&self, flow: &Flow<S>) -> S {
        (slope(flow, &self.m) * flow.v * flow.v + slope(flow, &self.c) * flow.q * flow.q) * 0.5
    }

    /// c (N·m/rad or N/m).
    pub fn stiffness<S: Scalar>(&self, flow: &Flow<S>) -> S {
        of(flow, &self.c)
    }
}

fn of<S: Scalar>(flow: &Flow<S>, &[d0, d1, d2, _]: &[f64; 4]) -> S {
    flow.phi.compose([d0, d1, d2])
}

fn slope<S: Scalar>(flow: &Flow<S>, &[_, d1, d2, d3]: &[f64; 4]) -> S {
    flow.phi.compose([d1, d2, d3])
}

/// The vibration under the law of the drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Vibration {
    /// m, b, c and f after the law; shared by all instances with the same ones.
    pub coefficients: Arc<Coefficients>,
    /// Whether q counts from the drive.
    pub relative: bool,
    /// The loads on the mass, whose place y is q, or φ + q if q counts from the drive.
    pub load: Option<Arc<Load>>,
    /// min m (kg·m² or kg).
    least_mass: f64,
    /// √(max c/min m), and half a radian of the highest harmonic of the coefficients (near a dip of the crank's stiffness an
    /// eighth of its width).
    pace: Pace,
}

impl Vibration {
    /// The vibration of this law under these loads.
    pub fn of(law: &Law, load: Option<Arc<Load>>) -> Self {
        let coefficients = law.coefficients();
        let (frequency, angle) = (coefficients.highest_frequency(), 0.25 * coefficients.least_reach());
        let (pace, least_mass) = (Pace { frequency, angle, speed: 0.0 }, coefficients.least_mass().1);
        Vibration { coefficients: Arc::new(coefficients), relative: law.is_relative(), load, least_mass, pace }
    }

    /// f + F_L − b q̇ − c q (N·m or N).
    fn force<S: Scalar>(&self, values: &Values, flow: &Flow<S>) -> S {
        let Values { m, b, c, f } = values;
        let force = of(flow, f) - of(flow, b) * flow.v - of(flow, c) * flow.q;
        let Some(load) = &self.load else { return force };
        let [place, speed] = self.base(values, flow);
        force + load.force(m[0], [place + flow.q, speed + flow.v], None, load.input.then_some(flow.force))
    }

    /// c and b of return spring and damper to the ground.
    fn ground(&self) -> [f64; 2] {
        self.load.as_ref().map_or([0.0; 2], |load| [load.stiffness(), load.damping.unwrap_or(0.0)])
    }
}

impl Equation for Vibration {
    type Law = Law;
    type Parameters = ();
    type Local = Values;

    fn parameters(&self) {}

    fn with(&self, (): ()) -> Self {
        self.clone()
    }

    fn prepare(&mut self, law: &Law) -> Result<(), Fault> {
        let anew = Vibration::of(law, self.load.clone());
        if *self != anew {
            *self = anew;
        }
        law.validate()?;
        self.load.as_ref().map_or(Ok(()), |load| load.validate("load"))
    }

    fn is_undamped(&self) -> bool {
        self.coefficients.b.bound(0) == 0.0 && self.ground()[1] == 0.0
    }

    fn load(&self) -> &Option<Arc<Load>> {
        &self.load
    }

    fn load_mut(&mut self) -> &mut Option<Arc<Load>> {
        &mut self.load
    }

    fn breakpoints<'a>(&'a self, _: &'a Law) -> [&'a [f64]; 2] {
        [&[], self.process().map_or(&[], MotionLaw::breakpoints)]
    }

    fn words(&self) -> Words {
        Words {
            quantity: "q",
            turning: "the drive",
            parameters: "the coefficients",
            frequency: "the stiffness and the mass",
            damping: if self.relative { "b_T" } else { "b" },
            instead: "",
        }
    }

    /// A process force counts as part of f.
    fn at(&self, _: &Law, [_, segment]: Segments, f: &Flow<f64>) -> Values {
        let mut values = self.coefficients.at(f.phi);
        if let Some(process) = self.process() {
            let more = process.at_in(segment, angle::reduce(Double::from(f.phi))).0;
            values.f.iter_mut().zip(more).for_each(|(f, more)| *f += more);
        }
        values
    }

    fn base<S: Scalar>(&self, _: &Values, f: &Flow<S>) -> [S; 2] {
        if self.relative { [f.phi, f.w] } else { [S::from(0.0); 2] }
    }

    /// q̈ = (f + F_L − b q̇ − c q)/m, less α if q counts from the drive.
    fn acceleration<S: Scalar>(&self, values: &Values, flow: &Flow<S>) -> S {
        let acceleration = self.force(values, flow) / of(flow, &values.m);
        if self.relative { acceleration - flow.a } else { acceleration }
    }

    fn jacobian(&self, Values { m, b, c, .. }: &Values, _: &Flow<f64>) -> [f64; 2] {
        let ground = self.ground();
        [-(c[0] + ground[0]) / m[0], -(b[0] + ground[1]) / m[0]]
    }

    fn reach(&self, _: &Law, [_, segment]: Segments, phi: f64) -> f64 {
        let of_process = self.process().map_or(f64::INFINITY, |process| REACH / process.resolution_in(segment));
        self.coefficients.reach(phi).min(of_process)
    }

    fn symmetry(&self, _: &Law) -> usize {
        let (own, process) = (self.coefficients.symmetry(), self.process());
        process.map_or(own, |law| law.series().map_or(1, |series| greatest_common_divisor(own, symmetry(series))))
    }

    fn cost(&self, _: &Law) -> f64 {
        self.coefficients.cost() + self.process().map_or(0.0, MotionLaw::cost)
    }

    fn pace(&self, law: &Law, _: [f64; 2]) -> Pace {
        let Pace { frequency, angle, speed } = self.pace;
        let Some(load) = &self.load else { return self.pace };
        let breakpoints = self.breakpoints(law)[1].len().max(1) as f64;
        let of_process = load.process.as_ref().map_or(angle, |process| 0.25 * REACH / process.resolution());
        let frequency = (frequency * frequency + load.stiffness() / self.least_mass).sqrt();
        Pace { frequency, angle: angle.min(of_process).min(TAU / breakpoints), speed }
    }

    /// q = (f + F_L)/(c + c_r), F_L at q = 0 and at rest.
    fn at_rest(&self, law: &Law, flow: &Flow<f64>) -> Result<[f64; 2], Fault> {
        let values = self.at(law, self.segments(law, flow), flow);
        let ground = self.ground();
        let [b, c] = [values.b[0] + ground[1], values.c[0] + ground[0]];
        if b > 0.0 && c > 0.0 {
            return Ok([self.force(&values, &Flow { w: 0.0, q: 0.0, v: 0.0, ..*flow }) / c, 0.0]);
        }
        Err(refused_start(format!(
            "start.mode = equilibrium, and steady_state at rest, is refused at drive.w = {} rad/s: with a stiffness of {} and a damping of {} at \
             drive.phi_start no motion comes to rest; both must be above 0",
            Number(flow.w),
            Number(c),
            Number(b)
        )))
    }
}
