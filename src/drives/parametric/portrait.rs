//! What the documentation says of the drive, its curves and its default experiment.

use super::ParametricDrive;
use super::coefficients::Coefficients;
use super::crank::SecondCrank;
use super::law::{Coordinate, CrankLaw, Law};
use crate::drives::solver::HasSolver;
use crate::drives::{Curve, Equation, Experiment, Portrait};

/// Turns of the default experiment: growth and decay take some.
const TURNS: f64 = 20.0;

/// Whole turns at constant speed; a second where the inputs or a drive at rest set no period.
pub(super) fn experiment(drive: &ParametricDrive) -> Experiment {
    Experiment::of_turns(TURNS, drive.cam.mode.speed())
}

/// c(φ), and what else varies.
pub(super) fn curves(drive: &ParametricDrive) -> Vec<Curve> {
    let Coefficients { m, b, f, .. } = &*drive.coefficients;
    let coordinate = drive.cam.law.coordinate();
    let [mass, damping, stiffness, force] = match coordinate {
        Coordinate::Rotation => ["m [kg·m²]", "b [N·m·s/rad]", "c [N·m/rad]", "f [N·m]"],
        Coordinate::Translation => ["m [kg]", "b [N·s/m]", "c [N/m]", "f [N]"],
    };
    let mut curves = vec![Curve::over_turn("Stiffness c(φ)", stiffness, |phi| drive.coefficients.c.at(phi)[0])];
    let titles = [("Mass m(φ)", mass), ("Damping b(φ)", damping), ("Load f(φ)", force)];
    for (series, (title, label)) in [m, b, f].into_iter().zip(titles) {
        if series.bound(1) > 0.0 {
            curves.push(Curve::over_turn(title, label, |phi| series.at(phi).0[0]));
        }
    }
    curves
}

pub(super) fn of(drive: &ParametricDrive) -> Portrait {
    let (summary, equations) = match &*drive.cam.law {
        Law::Series(law) => (of_series(law.coordinate), vec![series(), of_spring(law.coordinate), parametric_torque()]),
        Law::Crank(crank) => (
            of_crank(crank),
            vec![crank_motion(), stiffness(crank), transmitted("tau", "τ", "c_T", "b_T"), parametric_torque()],
        ),
    };
    let mut equations = equations;
    equations.push(energy());
    let mut accuracy = vec![
        ("Method".to_owned(), method(drive).to_owned()),
        (
            "q, der(q)".to_owned(),
            "1e-9 of the largest value so far or better over 100 turns with the default tolerance 1e-10, also while they \
             grow; in proportion to solver.tolerance down to 1e-13."
                .to_owned(),
        ),
        (
            "solver.error_estimate".to_owned(),
            "Error of q and der(q) relative to the largest motion so far, from the decay of the polynomials' coefficients \
             and from what the ends of cells or steps err by; over random drives the error is below it in 99 of 100."
                .to_owned(),
        ),
    ];
    if drive.has_method() {
        accuracy.push(("solver.method = fixed_cost".to_owned(), FIXED_COST.to_owned()));
    } else {
        accuracy.push(("growth".to_owned(), GROWTH.to_owned()));
        let text =
            "From the map of a period; refused where growth is not below 0, and at rest where c and b are not above 0.";
        accuracy.push(("Start on the periodic solution".to_owned(), text.to_owned()));
    }
    Portrait {
        summary,
        equations,
        accuracy,
        limits: limits(&drive.cam.law),
        sources: vec![
            "H. Dresig, I. Vulfson: Dynamik der Mechanismen. Springer, Wien 1989, sections 4.5.1-4.5.3.".to_owned(),
            "V. A. Yakubovich, V. M. Starzhinskii: Linear Differential Equations with Periodic Coefficients. Wiley 1975."
                .to_owned(),
        ],
    }
}

/// How the output growth is found.
const GROWTH: &str = "ln of the largest modulus of the Floquet multipliers over a turn (2π of phi, whatever the period of the \
                      coefficients). Complex multipliers have the modulus exp(-½ ∮ b/m dt), which is exact; of real ones \
                      growth is as accurate as the table, but a growth of less than 1e-7 beyond that of the damping is not \
                      told from none. Where a period would take more than some 250 000 cells growth is the integral of \
                      the larger real part of the roots of m λ² + b λ + c, and where the drive does not turn it is 0.";

/// The method with equal steps.
const FIXED_COST: &str = "Gauss collocation of order 16 on equal steps that divide the communication step, each a linear \
                          system of sixteen equations. solver.step_size = 0 takes the shorter of 0.5 √(min m/max c) and half a \
                          radian of the highest harmonic of the coefficients (near a dead centre an eighth of the width of the \
                          dip) at the highest speed. Bound: a step that misses the motion by more than 1e-2 of it ends the \
                          simulation with an error; below that solver.error_estimate bounds the error.";

fn method(drive: &ParametricDrive) -> &'static str {
    if drive.cam.is_input() {
        "Gauss collocation of order 16 with error-controlled steps, which end at the communication points."
    } else {
        "The equation is solved once for a period of its coefficients when the simulation starts: by Gauss collocation of \
         order 24, as polynomials of two free motions and a forced one in cells that solver.tolerance makes short enough and \
         that keep away from the complex zeros of m and poles of c; where it vibrates more than some 16 times within a cell, by the \
         phase of the vibration. A communication step of any length then combines them; \
         n periods cost O(log n). Where more than 4096 cells would be needed, or drive.w = 0, Gauss collocation of order 16 \
         goes along the motion instead."
    }
}

fn of_series(coordinate: Coordinate) -> String {
    let (q, sense) = match coordinate {
        Coordinate::Rotation => ("an angle", "tau is the torque of spring and damper on the mass"),
        Coordinate::Translation => ("a length", "force is that of spring and damper on the mass"),
    };
    format!(
        "A vibration with one degree of freedom whose mass, damping and stiffness are finite Fourier series of the drive \
         angle phi, under a load f(phi). q is {q}; {sense}, positive in the sense of q, as f is."
    )
}

fn of_crank(crank: &CrankLaw) -> String {
    let second = match crank.crank.second {
        SecondCrank::None => "",
        SecondCrank::OwnShafts(_) => {
            " A second crank set with shafts of its own of the same stiffness runs ahead by second.angle."
        }
        SecondCrank::SharedShafts(_) => " A second crank set on the same shafts runs ahead by second.angle.",
    };
    format!(
        "A parallel-crank drive: two parallel shafts whose cranks a coupling rod joins. The drive turns the first shaft by \
         phi, the driven side turns by psi = phi + q; both dead centres, phi = 0 and 180 deg, transmit no torque.{second} \
         Angles and torques are positive in the sense of phi, f acts on the driven side; tau is the torque that the drive \
         transmits into the unit, and a positive tau loads the drive."
    )
}

fn limits(law: &Law) -> Vec<String> {
    let growth =
        "Where growth is positive the motion grows without bound and ends the simulation with an error beyond 1e100.";
    let mut limits = vec![growth.to_owned()];
    match law {
        Law::Series(_) => {
            limits.push(
                "m(phi) > 0 over the whole turn; a speed that the coefficients depend on is not followed.".to_owned(),
            );
            limits.push("Where inputs jump, q and der(q) are kept.".to_owned());
        }
        Law::Crank(crank) => {
            limits.push(
                "Linear in q: |q| small against the angle over which sin(phi) changes, near the dead centres against \
                 √(c₁₂/(c_AB R²)). No play, massless rods."
                    .to_owned(),
            );
            limits.push(
                "Where inputs jump, psi and der(psi) are kept; jumps within the rounding of the inputs are none."
                    .to_owned(),
            );
            if let Some(order) = crank.harmonics {
                limits.push(format!("Of the stiffness only the harmonics up to {order} are taken into account."));
            }
        }
    }
    limits
}

const Q: &str = "<mi>q</mi>";
const Q_DOT: &str = "<mover><mi>q</mi><mo>˙</mo></mover>";
const Q_DOT_DOT: &str = "<mover><mi>q</mi><mo>¨</mo></mover>";
const OF_PHI: &str = "<mo>(</mo><mi>φ</mi><mo>)</mo>";

/// A symbol with or without an index: "c_T".
fn symbol(name: &str) -> String {
    match name.split_once('_') {
        Some((letter, index)) => format!("<msub><mi>{letter}</mi><mi>{index}</mi></msub>"),
        None => format!("<mi>{name}</mi>"),
    }
}

fn square(symbol: &str) -> String {
    format!("<msup>{symbol}<mn>2</mn></msup>")
}

fn half() -> &'static str {
    "<mfrac><mn>1</mn><mn>2</mn></mfrac>"
}

fn series() -> Equation {
    Equation {
        title: "Vibration".to_owned(),
        text: "m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ);  each m.a[0] + Σ m.a[k] cos kφ + m.b[k] sin kφ".to_owned(),
        mathml: format!(
            "<mrow><mi>m</mi>{OF_PHI}{Q_DOT_DOT}<mo>+</mo><mi>b</mi>{OF_PHI}{Q_DOT}<mo>+</mo><mi>c</mi>{OF_PHI}{Q}<mo>=</mo>\
             <mi>f</mi>{OF_PHI}<mo>,</mo><mspace width=\"1em\"/><mi>c</mi><mo>=</mo><msub><mi>a</mi><mn>0</mn></msub><mo>+</mo>\
             <munder><mo>∑</mo><mi>k</mi></munder><msub><mi>a</mi><mi>k</mi></msub><mi>cos</mi><mi>k</mi><mi>φ</mi><mo>+</mo>\
             <msub><mi>b</mi><mi>k</mi></msub><mi>sin</mi><mi>k</mi><mi>φ</mi><mo>…</mo></mrow>"
        ),
    }
}

fn crank_motion() -> Equation {
    let (b, c) = (symbol("b_T"), symbol("c_T"));
    Equation {
        title: "Motion of the driven side".to_owned(),
        text: "J ψ̈ + b_T q̇ + c_T(φ) q = f(φ),  ψ = φ + q".to_owned(),
        mathml: format!(
            "<mrow><mi>J</mi><mover><mi>ψ</mi><mo>¨</mo></mover><mo>+</mo>{b}{Q_DOT}<mo>+</mo>{c}{OF_PHI}{Q}<mo>=</mo><mi>f</mi>\
             {OF_PHI}<mo>,</mo><mspace width=\"1em\"/><mi>ψ</mi><mo>=</mo><mi>φ</mi><mo>+</mo>{Q}</mrow>"
        ),
    }
}

/// c_T(φ) of the crank's kind.
fn stiffness(law: &CrankLaw) -> Equation {
    let sine = |of: &str| format!("<msup><mi>sin</mi><mn>2</mn></msup>{of}");
    let ahead = "<mo>(</mo><mi>φ</mi><mo>+</mo><mi>δ</mi><mo>)</mo>";
    let phi = "<mi>φ</mi>";
    let (series, total) = ("1/c₁₂ = 1/c_T1 + 1/c_T2, σ = c₁₂/(c_AB R²)", symbol("c_T"));
    let shafts = "<msub><mi>c</mi><mn>12</mn></msub>";
    let of_sum = |sum: &str| format!("{shafts}<mfrac><mrow>{sum}</mrow><mrow><mi>σ</mi><mo>+</mo>{sum}</mrow></mfrac>");
    let (text, formula) = match law.crank.second {
        SecondCrank::None => ("c_T(φ) = c₁₂ sin²φ/(σ + sin²φ)", of_sum(&sine(phi))),
        SecondCrank::OwnShafts(_) => (
            "c_T(φ) = c₁₂ sin²φ/(σ + sin²φ) + c₁₂ sin²(φ + δ)/(σ + sin²(φ + δ)), δ = second.angle",
            format!("{}<mo>+</mo>{}", of_sum(&sine(phi)), of_sum(&sine(ahead))),
        ),
        SecondCrank::SharedShafts(_) => (
            "c_T(φ) = c₁₂ S/(σ + S), S = sin²φ + sin²(φ + δ), δ = second.angle",
            of_sum(&format!("{}<mo>+</mo>{}", sine(phi), sine(ahead))),
        ),
    };
    let rod = "<mfrac><msub><mi>c</mi><mn>12</mn></msub><mrow><msub><mi>c</mi><mi>AB</mi></msub><msup><mi>R</mi><mn>2</mn></msup></mrow></mfrac>";
    let parts =
        [1, 2].map(|i| format!("<mfrac><mn>1</mn><msub><mi>c</mi><mi>T{i}</mi></msub></mfrac>")).join("<mo>+</mo>");
    Equation {
        title: "Stiffness".to_owned(),
        text: format!("{text};  {series}"),
        mathml: format!(
            "<mrow>{total}{OF_PHI}<mo>=</mo>{formula}<mo>,</mo><mspace width=\"1em\"/><mfrac><mn>1</mn>{shafts}</mfrac><mo>=</mo>\
             {parts}<mo>,</mo><mspace width=\"1em\"/><mi>σ</mi><mo>=</mo>{rod}</mrow>"
        ),
    }
}

fn of_spring(coordinate: Coordinate) -> Equation {
    match coordinate {
        Coordinate::Rotation => transmitted("tau", "τ", "c", "b"),
        Coordinate::Translation => transmitted("force", "F", "c", "b"),
    }
}

fn transmitted(name: &str, letter: &str, c: &str, b: &str) -> Equation {
    Equation {
        title: "What spring and damper transmit".to_owned(),
        text: format!("{name} = −({c} q + {b} q̇)"),
        mathml: format!(
            "<mrow><mi>{letter}</mi><mo>=</mo><mo>−</mo><mo>(</mo>{}{Q}<mo>+</mo>{}{Q_DOT}<mo>)</mo></mrow>",
            symbol(c),
            symbol(b)
        ),
    }
}

fn parametric_torque() -> Equation {
    let primed = |letter: &str| format!("<msup><mi>{letter}</mi><mo>′</mo></msup>");
    Equation {
        title: "Torque by which the drive feeds the vibration".to_owned(),
        text: "tau_parametric = ½ (m′ q̇² + c′ q²)".to_owned(),
        mathml: format!(
            "<mrow><msub><mi>τ</mi><mi>p</mi></msub><mo>=</mo>{}<mo>(</mo>{}{}<mo>+</mo>{}{}<mo>)</mo></mrow>",
            half(),
            primed("m"),
            square(Q_DOT),
            primed("c"),
            square(Q)
        ),
    }
}

fn energy() -> Equation {
    Equation {
        title: "Energy of the vibration, ω constant".to_owned(),
        text: "d/dt [m q̇²/2 + c q²/2] = f q̇ − b q̇² + tau_parametric ω".to_owned(),
        mathml: format!(
            "<mrow><mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac><mo>[</mo>{half}<mi>m</mi>{v}<mo>+</mo>{half}\
             <mi>c</mi>{x}<mo>]</mo><mo>=</mo><mi>f</mi>{Q_DOT}<mo>−</mo><mi>b</mi>{v}<mo>+</mo><msub><mi>τ</mi><mi>p</mi></msub>\
             <mi>ω</mi></mrow>",
            half = half(),
            v = square(Q_DOT),
            x = square(Q)
        ),
    }
}
