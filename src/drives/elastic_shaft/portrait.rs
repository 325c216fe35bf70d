//! What the documentation says of the drive, and its default experiment.

use super::ElasticShaft;
use crate::drives::solver::HasSolver;
use crate::drives::{Equation, Experiment, Portrait};

/// Turns of the default experiment.
const TURNS: f64 = 5.0;

/// Whole turns at constant speed; a second where the inputs or a drive at rest set no period.
pub(super) fn experiment(drive: &ElasticShaft) -> Experiment {
    Experiment::of_turns(TURNS, drive.cam.mode.speed())
}

pub(super) fn of(drive: &ElasticShaft) -> Portrait {
    let equation = if drive.linear { linear() } else { nonlinear() };
    let mut portrait = portrait(drive, equation);
    if drive.has_method() {
        portrait.accuracy.push(("solver.method = fixed_cost".to_owned(), FIXED_COST.to_owned()));
    }
    portrait
}

/// The method with equal steps.
const FIXED_COST: &str = "Gauss collocation of order 16 on a grid of equal steps, with four Newton iterations per step \
                          (one where the equation is linear). At constant speed the grid starts with the simulation, so \
                          results do not depend on the communication step; on inputs it divides the communication step. \
                          solver.step_size = 0 takes the shortest of 0.5 √(J/c), 1/(2 K √(1 + m max U'²/J)) of the cam's \
                          turning (K the highest harmonic of the law, turning at |w| and the speed of the vibration) and \
                          the mean distance of the law's breakpoints. A communication step h takes at most h/step_size + 2 \
                          solutions of eight nodes where the law is smooth, 16 times as many where it has breakpoints. \
                          Bound: a step that misses the motion by more than 1e-2 of it ends the simulation with an \
                          error; below that solver.error_estimate bounds the error, with the default step usually \
                          below 1e-6.";

fn portrait(drive: &ElasticShaft, equation: Equation) -> Portrait {
    Portrait {
        summary: "A cam at the far end of an elastic input shaft. The drive turns the near end by phi, the cam turns \
                  by psi = phi + q and moves a mass without play. Angles and torques are positive in the sense of \
                  phi; tau is the torque that the drive transmits into the cam unit, and a positive tau loads the \
                  drive. The mass never leaves the cam."
            .to_owned(),
        equations: vec![equation, torque(), energy()],
        accuracy: vec![
            ("Method".to_owned(), method(drive).to_owned()),
            (
                "q, der(q)".to_owned(),
                "1e-9 of the largest value or better with the default tolerance 1e-10; in proportion to \
                 solver.tolerance down to 1e-13."
                    .to_owned(),
            ),
            (
                "solver.error_estimate".to_owned(),
                "Error of q and der(q) relative to the largest motion so far, from the decay of the polynomials' \
                 coefficients and, for the integrator, from what errors at the ends of its steps grow to along the \
                 motion; over random drives the error is below it in 99 of 100."
                    .to_owned(),
            ),
            (
                "Start on the periodic solution".to_owned(),
                "From the map of one turn, with its Floquet multipliers; refused where one is not below 1.".to_owned(),
            ),
        ],
        limits: vec![
            "J > 0; the frequency of the twist reaches √(c/J) where U' = 0, and the internal steps follow it."
                .to_owned(),
            "The linear equation holds while |q| is small against the angle over which U'U'' changes; in a \
             parametrically unstable range its solution grows without bound and ends the simulation with an error \
             beyond 1e100."
                .to_owned(),
            "Where inputs jump, psi and der(psi) are kept; jumps within the rounding of the inputs are none."
                .to_owned(),
        ],
        sources: vec!["H. Dresig, I. Vulfson: Dynamik der Mechanismen. Springer, Wien 1989, section 4.6.3.".to_owned()],
    }
}

fn method(drive: &ElasticShaft) -> &'static str {
    if drive.linear && !drive.cam.is_input() {
        "The equation, which has periodic coefficients, is solved once for a turn (half a turn where the law has odd \
         harmonics alone) when the simulation starts: by Gauss collocation of order 24, as polynomials of two free motions \
         and a forced one in cells that solver.tolerance makes short enough; where it vibrates more than some 16 times within a \
         cell, by the phase of the vibration, so that a stiffer shaft costs no more. A communication step of any length then \
         combines them. Where more than 4096 cells would be needed, or m, c or b is changed between steps, Gauss \
         collocation of order 16 goes along the motion instead."
    } else {
        "Gauss collocation of order 16 with error-controlled steps that end where the cam passes a breakpoint of its \
         law; at constant speed the steps do not depend on the communication step."
    }
}

fn nonlinear() -> Equation {
    Equation {
        title: "Motion of the cam, U at ψ = φ + q".to_owned(),
        text: "(J + m U′²) ψ̈ + m U′ U″ ψ̇² + b q̇ + c q = 0,  y = U(ψ)".to_owned(),
        mathml:
            "<mrow><mo>(</mo><mi>J</mi><mo>+</mo><mi>m</mi><msup><mi>U</mi><mrow><mo>′</mo><mn>2</mn></mrow></msup>\
                 <mo>)</mo><mover><mi>ψ</mi><mo>¨</mo></mover><mo>+</mo><mi>m</mi><msup><mi>U</mi><mo>′</mo></msup>\
                 <msup><mi>U</mi><mo>″</mo></msup><msup><mover><mi>ψ</mi><mo>˙</mo></mover><mn>2</mn></msup><mo>+</mo>\
                 <mi>b</mi><mover><mi>q</mi><mo>˙</mo></mover><mo>+</mo><mi>c</mi><mi>q</mi><mo>=</mo><mn>0</mn>\
                 <mo>,</mo><mspace width=\"1em\"/><mi>y</mi><mo>=</mo><mi>U</mi><mo>(</mo><mi>ψ</mi><mo>)</mo></mrow>"
                .to_owned(),
    }
}

fn linear() -> Equation {
    Equation {
        title: "Twist, linearised; U at φ, ω = φ̇, α = φ̈".to_owned(),
        text: "(J + m U′²) q̈ + (b + 2 m ω U′ U″) q̇ + [c + m ω² (U″² + U′ U‴) + 2 m α U′ U″] q = −m ω² U′ U″ − (J + m U′²) α,  \
               y = U + U′ q"
            .to_owned(),
        mathml: "<mrow><mo>(</mo><mi>J</mi><mo>+</mo><mi>m</mi><msup><mi>U</mi><mrow><mo>′</mo><mn>2</mn></mrow></msup>\
                 <mo>)</mo><mover><mi>q</mi><mo>¨</mo></mover><mo>+</mo><mo>(</mo><mi>b</mi><mo>+</mo><mn>2</mn><mi>m</mi>\
                 <mi>ω</mi><msup><mi>U</mi><mo>′</mo></msup><msup><mi>U</mi><mo>″</mo></msup><mo>)</mo>\
                 <mover><mi>q</mi><mo>˙</mo></mover><mo>+</mo><mo>[</mo><mi>c</mi><mo>+</mo><mi>m</mi>\
                 <msup><mi>ω</mi><mn>2</mn></msup><mo>(</mo><msup><mi>U</mi><mrow><mo>″</mo><mn>2</mn></mrow></msup>\
                 <mo>+</mo><msup><mi>U</mi><mo>′</mo></msup><msup><mi>U</mi><mo>‴</mo></msup><mo>)</mo><mo>+</mo><mn>2</mn>\
                 <mi>m</mi><mi>α</mi><msup><mi>U</mi><mo>′</mo></msup><msup><mi>U</mi><mo>″</mo></msup><mo>]</mo><mi>q</mi>\
                 <mo>=</mo><mo>−</mo><mi>m</mi><msup><mi>ω</mi><mn>2</mn></msup><msup><mi>U</mi><mo>′</mo></msup>\
                 <msup><mi>U</mi><mo>″</mo></msup><mo>−</mo><mo>(</mo><mi>J</mi><mo>+</mo><mi>m</mi>\
                 <msup><mi>U</mi><mrow><mo>′</mo><mn>2</mn></mrow></msup><mo>)</mo><mi>α</mi><mo>,</mo>\
                 <mspace width=\"1em\"/><mi>y</mi><mo>=</mo><mi>U</mi><mo>+</mo><msup><mi>U</mi><mo>′</mo></msup><mi>q</mi></mrow>"
            .to_owned(),
    }
}

fn torque() -> Equation {
    Equation {
        title: "Torque from the drive into the cam unit".to_owned(),
        text: "tau = −(c q + b q̇)".to_owned(),
        mathml: "<mrow><mi>τ</mi><mo>=</mo><mo>−</mo><mo>(</mo><mi>c</mi><mi>q</mi><mo>+</mo><mi>b</mi>\
                 <mover><mi>q</mi><mo>˙</mo></mover><mo>)</mo></mrow>"
            .to_owned(),
    }
}

fn energy() -> Equation {
    Equation {
        title: "Energy balance (exact for the nonlinear equation)".to_owned(),
        text: "d/dt [(J + m U′²) ψ̇²/2 + c q²/2] = tau ω − b q̇²".to_owned(),
        mathml: "<mrow><mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac><mo>[</mo><mfrac><mn>1</mn><mn>2</mn></mfrac>\
                 <mo>(</mo><mi>J</mi><mo>+</mo><mi>m</mi><msup><mi>U</mi><mrow><mo>′</mo><mn>2</mn></mrow></msup><mo>)</mo>\
                 <msup><mover><mi>ψ</mi><mo>˙</mo></mover><mn>2</mn></msup><mo>+</mo><mfrac><mn>1</mn><mn>2</mn></mfrac>\
                 <mi>c</mi><msup><mi>q</mi><mn>2</mn></msup><mo>]</mo><mo>=</mo><mi>τ</mi><mi>ω</mi><mo>−</mo><mi>b</mi>\
                 <msup><mover><mi>q</mi><mo>˙</mo></mover><mn>2</mn></msup></mrow>"
            .to_owned(),
    }
}
