//! What the documentation says of the drive, and its default experiment.

use super::ElasticOutput;
use crate::drives::{Equation, Experiment, Portrait};

/// Turns of the default experiment.
const TURNS: f64 = 5.0;

/// Whole turns at constant speed; a second where the inputs or a drive at rest set no period.
pub(super) fn experiment(drive: &ElasticOutput) -> Experiment {
    Experiment::of_turns(TURNS, drive.cam.mode.speed())
}

pub(super) fn of(drive: &ElasticOutput) -> Portrait {
    let closed = drive.cam.law.series().is_some() && !drive.cam.is_input();
    let method = if drive.cam.is_input() && drive.cam.law.series().is_some() {
        "The impulse response times the acceleration of the cam, integrated over a communication step in one go: by \
         Hermite's interpolation between its ends, with as many derivatives of the law as the tolerance asks for, or else, \
         over longer steps and with derivatives of the inputs, by a Gauss rule of up to 16 nodes; beyond, exponential \
         quadrature on pieces that follow the motion of the cam. Inputs that have kept their speed for a while go on in \
         closed form until they change."
    } else if closed {
        "Closed form: the response to each harmonic and the free motion, in phase to the last digit after any number \
         of turns; on and beside an undamped resonance the growing part by itself."
    } else {
        "At constant speed the turn is tabulated in cells by collocation, whole turns by powers of its map. With inputs, \
         with parameters tuned on the way, and where the oscillator turns by more than 512 rad within one turn of the cam, \
         exponential quadrature: the acceleration of the cam as Chebyshev polynomials on pieces that follow its \
         motion and end at the breakpoints of the law, the oscillator solved exactly on each."
    };
    let tolerance = if drive.cam.is_input() {
        "Each communication step, or each piece of it, may add a thousandth of it to the error of q, relative to the \
         largest |q|; the number of evaluations follows from it. 0 means 1e-10."
    } else {
        "There is none: at constant speed the result is at rounding level, and a coarser one would save nothing."
    };
    let accuracy = if closed {
        "1e-12 of the largest |q|, after one turn as after a million, at any communication step and damping."
    } else {
        "1e-12 of the largest |q| over some turns; rounding adds up with the turns, to about 1e-10 after 1e5 \
         turns without damping. Stiffness costs no digits."
    };
    let cost = if closed {
        "Each communication step, of any length, evaluates the closed form once."
    } else {
        "Nothing is iterated or repeated, so that there is no method of fixed cost to choose: with h the communication step and K \
         the highest harmonic, a Fourier law on inputs takes at most 7 orders of its series or 16 nodes where the cam turns by \
         less than about 1/K rad, else, as any other law, about 17 evaluations for each piece, of which there are some K |w| h/2 + 1 \
         and one more for each breakpoint passed and for each 12 rad or 12 time constants of the slower mode."
    };
    Portrait {
        summary: "A mass on an elastic output member behind a rigid cam. Spring and damper lie between the cam's \
                  motion x = U(phi) and the mass at y = x + q. The force is positive in the sense of y; tau is the \
                  torque that the drive transmits into the cam unit, and a positive tau loads the drive. The follower \
                  keeps contact with its cam."
            .to_owned(),
        equations: vec![motion(), force(), torque(), energy()],
        accuracy: vec![
            ("Method".to_owned(), method.to_owned()),
            ("q, der(q)".to_owned(), accuracy.to_owned()),
            ("solver.tolerance".to_owned(), tolerance.to_owned()),
            ("Cost".to_owned(), cost.to_owned()),
            (
                "Start on the periodic solution".to_owned(),
                "In closed form for a Fourier law, else from the map of one turn; refused where a harmonic meets an \
                 undamped resonance, where c = 0 and where the drive follows inputs."
                    .to_owned(),
            ),
        ],
        limits: vec![
            "Linear spring and damper; the follower never leaves the cam, whatever the sign of the force.".to_owned(),
            "Without damping a harmonic on the natural frequency makes q grow in proportion to time.".to_owned(),
            "Where inputs jump, the mass keeps y and der(y); jumps within the rounding of the inputs are none."
                .to_owned(),
        ],
        sources: vec!["H. Dresig, I. Vulfson: Dynamik der Mechanismen. Springer, Wien 1989, section 4.6.2.".to_owned()],
    }
}

fn motion() -> Equation {
    Equation {
        title: "Motion of the mass relative to the cam".to_owned(),
        text: "m q̈ + b q̇ + c q = −m ẍ,  ẍ = U″ ω² + U′ α,  y = U(φ) + q".to_owned(),
        mathml: "<mrow><mi>m</mi><mover><mi>q</mi><mo>¨</mo></mover><mo>+</mo><mi>b</mi><mover><mi>q</mi><mo>˙</mo></mover>\
                 <mo>+</mo><mi>c</mi><mi>q</mi><mo>=</mo><mo>−</mo><mi>m</mi><mover><mi>x</mi><mo>¨</mo></mover><mo>,</mo>\
                 <mspace width=\"1em\"/><mover><mi>x</mi><mo>¨</mo></mover><mo>=</mo><msup><mi>U</mi><mo>″</mo></msup>\
                 <msup><mi>ω</mi><mn>2</mn></msup><mo>+</mo><msup><mi>U</mi><mo>′</mo></msup><mi>α</mi><mo>,</mo>\
                 <mspace width=\"1em\"/><mi>y</mi><mo>=</mo><mi>U</mi><mo>(</mo><mi>φ</mi><mo>)</mo><mo>+</mo><mi>q</mi></mrow>"
            .to_owned(),
    }
}

fn force() -> Equation {
    Equation {
        title: "Force on the mass".to_owned(),
        text: "force = −(c q + b q̇) = m ÿ".to_owned(),
        mathml: "<mrow><mi>F</mi><mo>=</mo><mo>−</mo><mo>(</mo><mi>c</mi><mi>q</mi><mo>+</mo><mi>b</mi>\
                 <mover><mi>q</mi><mo>˙</mo></mover><mo>)</mo><mo>=</mo><mi>m</mi><mover><mi>y</mi><mo>¨</mo></mover></mrow>"
            .to_owned(),
    }
}

fn torque() -> Equation {
    Equation {
        title: "Torque from the drive into the cam unit".to_owned(),
        text: "tau = U′ · force".to_owned(),
        mathml: "<mrow><mi>τ</mi><mo>=</mo><msup><mi>U</mi><mo>′</mo></msup><mi>F</mi></mrow>".to_owned(),
    }
}

fn energy() -> Equation {
    Equation {
        title: "Energy balance".to_owned(),
        text: "d/dt [m ẏ²/2 + c q²/2] = tau ω − b q̇²".to_owned(),
        mathml: "<mrow><mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac><mo>[</mo><mfrac><mn>1</mn><mn>2</mn></mfrac>\
                 <mi>m</mi><msup><mover><mi>y</mi><mo>˙</mo></mover><mn>2</mn></msup><mo>+</mo><mfrac><mn>1</mn><mn>2</mn></mfrac>\
                 <mi>c</mi><msup><mi>q</mi><mn>2</mn></msup><mo>]</mo><mo>=</mo><mi>τ</mi><mi>ω</mi><mo>−</mo><mi>b</mi>\
                 <msup><mover><mi>q</mi><mo>˙</mo></mover><mn>2</mn></msup></mrow>"
            .to_owned(),
    }
}
