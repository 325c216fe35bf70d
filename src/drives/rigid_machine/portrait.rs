//! What the documentation says of the rigid machine.

use super::linkage::{decimals, in_turn};
use super::{Motor, RigidMachine};
use crate::drives::{Equation, Portrait};

fn equation(title: &str, text: &str, mathml: &str) -> Equation {
    Equation { title: title.into(), text: text.into(), mathml: mathml.into() }
}

const MOTION: &str = "<mi>J</mi><mo>(</mo><mi>φ</mi><mo>)</mo><mover><mi>φ</mi><mo>¨</mo></mover><mo>+</mo>\
<mfrac><mn>1</mn><mn>2</mn></mfrac><mi>J</mi><mo>′</mo><mo>(</mo><mi>φ</mi><mo>)</mo>\
<msup><mover><mi>φ</mi><mo>˙</mo></mover><mn>2</mn></msup><mo>=</mo><msub><mi>M</mi><mi>an</mi></msub>\
<mo>−</mo><mi>τ</mi>";

const INERTIA: &str = "<mi>J</mi><mo>(</mo><mi>φ</mi><mo>)</mo><mo>=</mo><msub><mi>J</mi><mn>0</mn></msub><mo>+</mo>\
<msub><mi>J</mi><mi>v</mi></msub><mo>(</mo><mi>φ</mi><mo>)</mo><mo>+</mo><munder><mo>∑</mo><mi>j</mi></munder>\
<msub><mi>m</mi><mi>j</mi></msub><msubsup><mi>U</mi><mi>j</mi><mo>′</mo></msubsup>\
<msup><mrow><mo>(</mo><mi>φ</mi><mo>)</mo></mrow><mn>2</mn></msup>";

const LINKED: &str = "<msub><mi>U</mi><mi>j</mi></msub><mo>(</mo><mi>φ</mi><mo>)</mo><mo>=</mo><msub><mi>f</mi><mi>j</mi>\
</msub><mo>(</mo><msub><mi>χ</mi><mi>j</mi></msub><mo>(</mo><mi>φ</mi><mo>)</mo><mo>)</mo><mo>,</mo>\
<mspace width=\"1em\"/><msub><mi>J</mi><mi>j</mi></msub><mo>=</mo><msub><mi>m</mi><mi>j</mi></msub>\
<msubsup><mi>U</mi><mi>j</mi><mrow><mo>′</mo><mn>2</mn></mrow></msubsup><mo>+</mo><munder><mo>∑</mo><mi>i</mi></munder>\
<mo>(</mo><msub><mi>m</mi><mi>i</mi></msub><msup><mrow><mo>|</mo><msubsup><mi>r</mi><mi>i</mi><mo>′</mo></msubsup>\
<mo>|</mo></mrow><mn>2</mn></msup><mo>+</mo><msub><mi>J</mi><mi>i</mi></msub><msubsup><mi>β</mi><mi>i</mi>\
<mrow><mo>′</mo><mn>2</mn></mrow></msubsup><mo>)</mo>";

const KLOSS: &str = "<msub><mi>M</mi><mi>an</mi></msub><mo>=</mo><mi>sgn</mi><mo>(</mo><msub><mi>w</mi><mi>s</mi></msub>\
<mo>)</mo><mfrac><mrow><mn>2</mn><msub><mi>M</mi><mi>k</mi></msub><mi>s</mi><msub><mi>s</mi><mi>k</mi></msub></mrow>\
<mrow><msup><mi>s</mi><mn>2</mn></msup><mo>+</mo><msubsup><mi>s</mi><mi>k</mi><mn>2</mn></msubsup></mrow></mfrac>\
<mo>,</mo><mspace width=\"1em\"/><mi>s</mi><mo>=</mo><mfrac><mrow><msub><mi>w</mi><mi>s</mi></msub><mo>−</mo>\
<mover><mi>φ</mi><mo>˙</mo></mover></mrow><msub><mi>w</mi><mi>s</mi></msub></mfrac>";

const LAG: &str = "<msub><mi>T</mi><mi>el</mi></msub><msub><mover><mi>M</mi><mo>˙</mo></mover><mi>an</mi></msub>\
<mo>+</mo><msub><mi>M</mi><mi>an</mi></msub><mo>=</mo><msub><mi>M</mi><mi>Kloss</mi></msub><mo>(</mo>\
<mover><mi>φ</mi><mo>˙</mo></mover><mo>)</mo>";

const IN_ANGLE: &str = "<mi>E</mi><mo>=</mo><mfrac><mn>1</mn><mn>2</mn></mfrac><mi>J</mi>\
<msup><mover><mi>φ</mi><mo>˙</mo></mover><mn>2</mn></msup><mo>,</mo><mspace width=\"1em\"/>\
<mfrac><mrow><mi>d</mi><mi>E</mi></mrow><mrow><mi>d</mi><mi>φ</mi></mrow></mfrac><mo>=</mo><msub><mi>M</mi>\
<mi>an</mi></msub><mo>−</mo><mi>τ</mi><mo>,</mo><mspace width=\"1em\"/><mfrac><mrow><mi>d</mi><mi>t</mi></mrow>\
<mrow><mi>d</mi><mi>φ</mi></mrow></mfrac><mo>=</mo><mfrac><mn>1</mn><mover><mi>φ</mi><mo>˙</mo></mover></mfrac>";

const SOLVED: &str = "<mi>u</mi><mo>=</mo><msqrt><mi>J</mi></msqrt><mover><mi>φ</mi><mo>˙</mo></mover><mo>,</mo>\
<mspace width=\"1em\"/><mover><mi>φ</mi><mo>˙</mo></mover><mo>=</mo><mfrac><mi>u</mi><msqrt><mi>J</mi></msqrt></mfrac>\
<mo>,</mo><mspace width=\"1em\"/><mover><mi>u</mi><mo>˙</mo></mover><mo>=</mo><mfrac><mrow><msub><mi>M</mi><mi>an</mi>\
</msub><mo>−</mo><mi>τ</mi></mrow><msqrt><mi>J</mi></msqrt></mfrac>";

/// The method with equal steps.
const FIXED_COST: &str = "Gauss collocation of order 16 for the angle and u = √J φ̇ in time, on a grid of equal steps from \
the start on, with four Newton iterations per step and none repeated. While the torques do not depend on time, results do \
not depend on the communication step; a load that jumps or depends on time ends a step at the communication point. \
solver.step_size = 0 takes 2/(R √(J_max/J_min)) of the shaft's turning (R the highest harmonic of J, twice that of a law; \
at w_s or the speed that the energy of the start reaches), the mean distance of the laws' breakpoints where that is less, \
and not more than the time w_s s_k J/M_k in which the motor follows, down to a 32nd; 1 ms where no speed is known. A \
communication step h takes at most h/solver.step_size + 2 solutions of eight nodes (40 evaluations each) where the laws are \
smooth, 17 times as many where they have breakpoints. Bound: a step that misses the motion by more than 1e-2 of it ends the \
simulation with an error; below that solver.error_estimate bounds the error. With the default step half of the errors over \
random machines are below 1e-12, nine of ten below 1e-6";

impl RigidMachine {
    pub(super) fn describe(&self) -> Portrait {
        let mut equations = vec![
            equation("Motion of the shaft", "J(φ) φ̈ + ½ J′(φ) φ̇² = M_an − τ", MOTION),
            equation("Reduced moment of inertia", "J(φ) = J0 + J_v(φ) + Σ m_j U_j′(φ)²", INERTIA),
        ];
        if self.inertia.is_linked() {
            let text = "U_j(φ) = f_j(χ_j(φ)),  J_j = m_j U_j′² + Σ (m_i |r_i′|² + J_i β_i′²) instead of m_j U_j′²";
            equations.push(equation("Followers behind mechanisms: lever χ, links i", text, LINKED));
        }
        if matches!(self.motor, Motor::Kloss { .. }) {
            let text = "M_an = sgn(w_s) 2 M_k s s_k / (s² + s_k²),  s = (w_s − φ̇) / w_s";
            equations.push(equation("Torque of the motor (Kloss)", text, KLOSS));
        }
        if self.motor.lag().is_some() {
            let text = "T_el dM_an/dt + M_an = M_Kloss(φ̇)";
            equations.push(equation("Lag of the motor's torque", text, LAG));
        }
        if self.motor.lag().is_none() {
            let text = "E = ½ J φ̇²,  dE/dφ = M_an − τ,  dt/dφ = 1/φ̇";
            equations.push(equation("As solved while the shaft turns", text, IN_ANGLE));
        }
        equations.push(equation("As solved in time", "u = √J φ̇,  φ̇ = u/√J,  u̇ = (M_an − τ)/√J", SOLVED));
        Portrait {
            summary:
                "A machine of rigid links with one degree of freedom: its inertia depends on the angle of the main \
                shaft, a motor drives it and a load brakes it. A positive `tau` loads the shaft, a positive `M_an` \
                accelerates it. Standstill, reversal and a load that drives the motor are ordinary states."
                    .into(),
            equations,
            accuracy: self.accuracy(),
            limits: self.limits(),
            sources: vec![
                "K. Kaltofen, HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit, equation (2)".into(),
                "H. Dresig, F. Holzweißig, Maschinendynamik, Springer, chapter 2 (the rigid machine)".into(),
                "M. Kloss, Drehmoment und Schlüpfung des Drehstrommotors, Archiv für Elektrotechnik 5 (1916) 59–87"
                    .into(),
                "E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006, II.1.3"
                    .into(),
            ],
        }
    }

    fn accuracy(&self) -> Vec<(String, String)> {
        let row = |quantity: &str, statement: &str| (quantity.to_owned(), statement.to_owned());
        let mut rows = vec![
            row(
                "Method",
                "Gauss collocation of order 16 with step control: for the energy over the angle while the shaft turns \
                 and the torques do not depend on time (the internal steps are then the same whatever the \
                 communication step); for the angle and u = √J φ̇ in time at standstill, in reversal, for a load or a \
                 torque that changes within the communication step and for a motor with lag. Internal steps end at \
                 the breakpoints of the motion laws",
            ),
            row(
                "Cost",
                "J is tabulated over the turn at the start: a step costs the same however many followers there are, \
                 and a communication step costs little more than reading a polynomial. So is the periodic motion of a \
                 motor without lag under the load of the start: near it, as after a run-up, there are no equations to \
                 solve",
            ),
            row(
                "phi, w, E",
                "relative error ≤ 1e-9 at the default tolerance, whatever the communication step; the tests find 1e-11 \
                 and less",
            ),
            row(
                "Energy",
                "½ J w² changes by the work of the torques at the nodes of the collocation; without torques it is constant to \
                 rounding",
            ),
            row(
                "solver.error_estimate",
                "the largest so far of the relative errors of the angle passed, of w and of a lagging torque. Over 320 \
                 random machines 99 % of the true errors are below it; it is less than 100 times too large in the median",
            ),
            row(
                "Number of turns",
                "whole turns are counted apart from the angle: the position within the turn keeps its digits after a \
                 million turns",
            ),
        ];
        rows.push(row("solver.method = fixed_cost", FIXED_COST));
        if matches!(self.motor, Motor::Kloss { .. }) {
            rows.push(row(
                "start.mode = steady_state",
                "period to 1e-12; of several stable orbits the fastest is taken and a log entry says so; orbits closer \
                 together than half a per cent of the speed may be overlooked",
            ));
        }
        rows
    }

    fn limits(&self) -> Vec<String> {
        let mut limits = vec![
            "The reduced moment of inertia must be positive at every angle.".to_owned(),
            "Links are rigid and joints have no play; friction enters only through `tau`.".to_owned(),
            "The speed stays below 1e7 rad/s.".to_owned(),
        ];
        if self.inertia.is_linked() {
            limits.push(
                "Four-bar linkages and slider-cranks must be assembled at every angle, with at least 1e-3 rad between \
                 coupler and output link, or rod and the normal of the slider's line."
                    .to_owned(),
            );
            limits.push(
                "Moments of inertia and centres of mass of links that the scene leaves out follow from its lengths and masses; \
                 here they are parameters of their own, which stay as they are where a length or mass is changed."
                    .to_owned(),
            );
        }
        for (j, follower) in self.inertia.followers.iter().enumerate() {
            for (i, (mechanism, extreme)) in follower.linkage.0.iter().zip(follower.transmission()).enumerate() {
                if mechanism.has_transmission_angle() {
                    limits.push(format!(
                        "follower[{}].linkage[{}] ({}): with the values of the scene the transmission angle is least at φ \
                         = {}°, {}°; usual are at least 40°.",
                        j + 1,
                        i + 1,
                        mechanism.name(),
                        in_turn(extreme.phi, 1),
                        decimals(extreme.transmission_angle().to_degrees(), 2)
                    ));
                }
            }
        }
        if let Motor::Kloss { dynamics, .. } = &self.motor {
            let follow = if dynamics.is_some() { "with the lag `motor.T_el`" } else { "at once" };
            limits.push(format!(
                "The motor's characteristic holds for constant voltage, negligible stator resistance and currents \
                 that follow the speed {follow}; `motor.w_s` must not be zero."
            ));
        }
        limits
    }
}
