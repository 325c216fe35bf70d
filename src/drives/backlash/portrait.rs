//! What the documentation says of the drive with backlash.

use super::BacklashDrive;
use crate::drives::cam_drive::DriveMode;
use crate::drives::solver::HasSolver;
use crate::drives::{Equation, Experiment, Portrait};

pub(super) fn of(drive: &BacklashDrive) -> Portrait {
    Portrait {
        summary: "A cam drives the mass m1 between two flanks with the clearance s; the mass m2 hangs on it by a \
                  spring c and a damper b. Flank A (x1 = U) pushes in +x, flank B (x1 = U + s) in −x. m1 leaves a flank \
                  when the contact force F_K would pull, and strikes a flank with the coefficient of restitution e. F_K \
                  and the impulses act on m1, positive in +x; the torque tau = U′F_K loads the drive."
            .to_owned(),
        equations: equations(),
        accuracy: accuracy(drive.has_tolerance()),
        limits: [
            "The drive keeps its motion during an impact: its inertia must be large against m1 U′².",
            "The flanks are rigid and an impact has no duration; forces within an impact are not modelled.",
            "With e > 0 the bounces of a pressed mass are summed in closed form at the end: the last impact that is listed \
             brings their impulse and energy loss, the count of impacts leaves out infinitely many vanishing ones. With \
             e > 0.999 the contact force or the damper may end them sooner, with e = 1 nothing else does: bounces that have \
             become too short to follow are then contact, and add to force, not to impulse.",
            "There is no method of fixed cost: how many switching instants a communication step holds, up to infinitely many \
             bounces, follows from the motion, and none can be put off without changing it.",
            "The work of a communication step is bounded, to about a second of computing; one that needs more (a natural \
             frequency far above 1/h, or countless bounces) ends with an error that says how far it came.",
            "Motions between impacts may be chaotic; then any difference of rounding grows from impact to impact, and only \
             statistics are reproducible between different computations.",
            "The log lists the first 32 events of a communication step and the number of the others.",
            "force and tau are without the impulses; a unit that is to receive all momentum takes force_mean or tau_mean.",
            "Where inputs jump at a communication point, a free mass keeps place and velocity; a mass on a flank follows \
             it, and the momentum m1 Δẋ1 counts as impulse. A free mass that would lie beyond a flank is set on it.",
        ]
        .map(str::to_owned)
        .to_vec(),
        sources: [
            "K. Kaltofen: Zur Dynamik spielbehafteter periodischer Antriebe. 1996.",
            "H. Dresig, I. I. Vulfson: Dynamik der Mechanismen. Springer 1989, section 4.6.",
            "B. Brogliato: Nonsmooth Mechanics. 3rd ed., Springer 2016 (restitution, accumulation of impacts).",
        ]
        .map(str::to_owned)
        .to_vec(),
    }
}

fn accuracy(has_tolerance: bool) -> Vec<(String, String)> {
    let tolerance = if has_tolerance {
        "The part of Ü that a series may leave out; it decides the number of terms: 24 for 1e-14, the default, 20 for \
         1e-10, 16 for 1e-6, 12 for 1e-3. With 16 terms a step costs four fifths of what it does with 24."
    } else {
        "This FMU has no such parameter: at constant speed the motion is right to rounding."
    };
    [
        (
            "Contact and flight",
            "Power series of time whose coefficients follow from the equations of motion; each holds for two radians of the \
             fastest change. In flight their gap is free of cancellation.",
        ),
        (
            "Switching instants",
            "Certified: the first zero of the series of the guard, passed over only where a bound shows that there is none; no \
             event is missed or doubled, instants are right to 1e-12 s and better. At constant speed they are the same \
             for every communication step.",
        ),
        ("Momentum and energy", "Balances closed to 1e-10 of their largest term; see the variables impulse, energy_loss and damping_loss."),
        ("solver.tolerance", tolerance),
        (
            "solver.error_estimate",
            "Of x1 and y relative to the largest |U|, of their velocities relative to the largest |U̇|: roundings and neglected \
             terms, taken along with the motion as a covariance. Impacts, above all grazing ones, multiply errors and the \
             estimate with them. Over 600 random scenes of up to 50 turns, of series and cycles, at constant and changing \
             speed, the error is below it in 99 of 100, in the median it exceeds the error fortyfold. An estimate near 1 \
             says that the motion is chaotic and its digits are lost.",
        ),
    ]
    .into_iter()
    .map(|(quantity, statement)| (quantity.to_owned(), statement.to_owned()))
    .collect()
}

fn equations() -> Vec<Equation> {
    let equation =
        |title: &str, text: &str, mathml: String| Equation { title: title.to_owned(), text: text.to_owned(), mathml };
    let i = |name: &str, index: &str| format!("<msub><mi>{name}</mi><mn>{index}</mn></msub>");
    let dot = |x: &str| format!("<mover><mrow>{x}</mrow><mo>˙</mo></mover>");
    let ddot = |x: &str| format!("<mover><mrow>{x}</mrow><mo>¨</mo></mover>");
    let (m1, m2, x1, x2) = (i("m", "1"), i("m", "2"), i("x", "1"), i("x", "2"));
    let (q_dot, fk) = (dot("<mi>q</mi>"), "<msub><mi>F</mi><mi>K</mi></msub>");
    let link = format!("<mi>c</mi><mi>q</mi><mo>+</mo><mi>b</mi>{q_dot}");
    let z = "<mi>z</mi>";
    let (minus, plus) = (format!("<msup>{}<mo>−</mo></msup>", dot(z)), format!("<msup>{}<mo>+</mo></msup>", dot(z)));
    vec![
        equation(
            "Mass at the clearance",
            "m1 ẍ1 = F_K + c q + b q̇,   q = x2 − x1",
            format!(
                "<mrow>{m1}{}<mo>=</mo>{fk}<mo>+</mo>{link}<mo>,</mo><mspace width='1em'/><mi>q</mi><mo>=</mo>{x2}\
                 <mo>−</mo>{x1}</mrow>",
                ddot(&x1)
            ),
        ),
        equation(
            "Mass behind the spring",
            "m2 ẍ2 = −(c q + b q̇)",
            format!("<mrow>{m2}{}<mo>=</mo><mo>−</mo><mo>(</mo>{link}<mo>)</mo></mrow>", ddot(&x2)),
        ),
        equation(
            "Clearance",
            "z = x1 − U(φ),   0 ≤ z ≤ s",
            format!(
                "<mrow>{z}<mo>=</mo>{x1}<mo>−</mo><mi>U</mi><mo>(</mo><mi>φ</mi><mo>)</mo><mo>,</mo>\
                 <mspace width='1em'/><mn>0</mn><mo>≤</mo>{z}<mo>≤</mo><mi>s</mi></mrow>"
            ),
        ),
        equation(
            "Contact force on flank A (x1 = U) and, with the opposite sign, on flank B (x1 = U + s)",
            "F_K = m1 Ü − c q − b q̇ ≥ 0; between the flanks F_K = 0",
            format!(
                "<mrow>{fk}<mo>=</mo>{m1}{}<mo>−</mo><mi>c</mi><mi>q</mi><mo>−</mo><mi>b</mi>{q_dot}<mo>≥</mo><mn>0</mn></mrow>",
                ddot("<mi>U</mi>")
            ),
        ),
        equation(
            "Impact",
            "ż⁺ = −e ż⁻,   P = −m1 (1 + e) ż⁻,   loss ½ m1 (1 − e²) ż⁻²",
            format!(
                "<mrow>{plus}<mo>=</mo><mo>−</mo><mi>e</mi>{minus}<mo>,</mo><mspace width='1em'/><mi>P</mi><mo>=</mo>\
                 <mo>−</mo>{m1}<mo>(</mo><mn>1</mn><mo>+</mo><mi>e</mi><mo>)</mo>{minus}</mrow>"
            ),
        ),
        equation(
            "Torque that loads the drive",
            "tau = U′ F_K,   tau_mean = (∫ U′F_K dt + Σ U′P)/h",
            format!(
                "<mrow><mi>tau</mi><mo>=</mo><msup><mi>U</mi><mo>′</mo></msup>{fk}<mo>,</mo><mspace width='1em'/>\
                 <msub><mi>tau</mi><mi>mean</mi></msub><mo>=</mo><mfrac><mn>1</mn><mi>h</mi></mfrac><mo>(</mo><mo>∫</mo>\
                 <msup><mi>U</mi><mo>′</mo></msup>{fk}<mi>d</mi><mi>t</mi><mo>+</mo><mo>∑</mo>\
                 <msup><mi>U</mi><mo>′</mo></msup><mi>P</mi><mo>)</mo></mrow>"
            ),
        ),
    ]
}

/// Four turns; a second where the speed is not known.
pub(super) fn experiment(mode: &DriveMode) -> Experiment {
    Experiment::of_turns(4.0, mode.speed())
}
