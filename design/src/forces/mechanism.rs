//! The forces in the joints of a mechanism, link by link from its output to its input.
//!
//! Σ F = m (r̈ − g) and Σ (p − r₁) × F = J χ̈ + (r − r₁) × m (r̈ − g) of each link about its first joint r₁. Symbols: r centre
//! of mass (m), χ angle of the link (rad), m mass (kg), J moment of inertia about the centre of mass (kg·m²), g gravity
//! (m/s²), p where a force F (N) acts; a × b = Im(ā b).

use crate::cam_geometry::Point;
use camdrive::drives::rigid_machine::linkage::{FourBar, Gear, Kind, Link, Mechanism, SliderCrank};

/// Forces in the joints of a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Reactions {
    /// τ: the load on its output (N·m or N), positive against the motion of the output.
    pub output: f64,
    /// The torque that drives its input (N·m).
    pub input: f64,
    /// The force in each joint (N) in the frame of the mechanism, as it acts on the link that is closer to the output, and as
    /// the ground acts on input, output and slider. Teeth have the tangential force in the sense of the output, and the radial
    /// force that drives the wheels apart. [`joints`] names them.
    pub joints: Vec<Point>,
}

/// The teeth of gears.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Teeth {
    /// r, the pitch radius of the output wheel of a pair (m).
    pub radius: Option<f64>,
    /// α, the pressure angle of the teeth (rad).
    pub angle: f64,
}

impl Teeth {
    /// τ over the tangential force: r, for a rack 1.
    fn arm(&self, gear: &Gear) -> Option<f64> {
        if gear.output_turns { self.radius } else { Some(1.0) }
    }
}

/// The names of the joints of a mechanism.
pub fn joints(mechanism: &Mechanism, teeth: Teeth) -> &'static [&'static str] {
    match mechanism.kind {
        Kind::FourBar(_) => &["input pivot", "input–coupler", "coupler–output", "output pivot"],
        Kind::SliderCrank(_) => &["crank pivot", "crank–rod", "rod–slider", "guide"],
        Kind::Gear(gear) if teeth.arm(&gear).is_some() => &["teeth"],
        Kind::Gear(_) => &[],
    }
}

/// A place, or a direction, with its first two derivatives by time.
type Moving = [Point; 3];

/// a × b.
fn cross(a: Point, b: Point) -> f64 {
    (a.conj() * b).im
}

/// The direction e^{iχ} with these χ, χ̇, χ̈.
fn direction([angle, w, a]: [f64; 3]) -> Moving {
    let e = Point::from_polar(1.0, angle);
    [e, Point::new(0.0, w) * e, Point::new(-w * w, a) * e]
}

/// The sum of these multiples of moving directions.
fn sum(parts: &[(f64, Moving)]) -> Moving {
    std::array::from_fn(|n| parts.iter().map(|(factor, moving)| moving[n] * *factor).sum())
}

/// m (r̈ − g) of a link, and its moment about the first joint with J χ̈; χ̈ = e × ë for the direction e of the link.
fn inertia(link: &Link, joint: Moving, along: Moving, gravity: Point) -> (Point, f64) {
    let centre = Point::new(link.centre[0], link.centre[1]);
    let force = (joint[2] + centre * along[2] - gravity) * link.mass;
    (force, cross(centre * along[0], force) + link.inertia * cross(along[0], along[2]))
}

/// The loads on a mechanism besides its input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// τ: the load on the output (N·m or N).
    pub tau: f64,
    /// The mass (kg) of a tool on a slider, which weighs on its guide.
    pub carried: f64,
    /// g in the frame of the mechanism (m/s²).
    pub gravity: Point,
}

/// The reactions of a mechanism whose input and output move like `motions`.
pub fn reactions(mechanism: &Mechanism, motions: [[f64; 3]; 2], demand: Demand, teeth: Teeth) -> Reactions {
    let shifted = |[x, v, a]: [f64; 3], offset: f64| [x + offset, v, a];
    let theta = shifted(motions[0], mechanism.input_offset);
    let output = shifted(motions[1], mechanism.output_offset);
    match &mechanism.kind {
        Kind::FourBar(linkage) => four_bar(linkage, direction(theta), direction(output), demand),
        Kind::SliderCrank(linkage) => slider_crank(linkage, direction(theta), output, demand),
        Kind::Gear(gear) => gear_pair(gear, theta[2], demand.tau, teeth),
    }
}

/// (B − g) × F_B from the output link and (B − A) × F_B from the coupler; the rest follows from the sums of forces.
fn four_bar(linkage: &FourBar, input: Moving, output: Moving, demand: Demand) -> Reactions {
    let Demand { tau, gravity, .. } = demand;
    let (a, b, c) = (linkage.input.length, linkage.coupler.length, linkage.output.length);
    let zero = [Point::from(0.0); 3];
    let ground = [Point::from(linkage.ground), zero[1], zero[2]];
    let pin = sum(&[(a, input)]);
    let coupler = sum(&[(1.0 / b, ground), (c / b, output), (-1.0 / b, pin)]);
    let (force_a, moment_a) = inertia(&linkage.input, zero, input, gravity);
    let (force_b, moment_b) = inertia(&linkage.coupler, pin, coupler, gravity);
    let (force_c, moment_c) = inertia(&linkage.output, ground, output, gravity);
    let (u, v) = (output[0] * c, coupler[0] * b);
    let at_output = (v * (moment_c + tau) + u * moment_b) / cross(u, v);
    let at_input = at_output + force_b;
    Reactions {
        output: tau,
        input: moment_a + cross(pin[0], at_input),
        joints: vec![at_input + force_a, at_input, at_output, force_c - at_output],
    }
}

/// F_Bx from the slider along its line, (B − A) × F_B from the rod.
fn slider_crank(linkage: &SliderCrank, input: Moving, output: [f64; 3], demand: Demand) -> Reactions {
    let ([s, v, a], Demand { tau, carried, gravity }) = (output, demand);
    let (r, l) = (linkage.crank.length, linkage.rod.length);
    let zero = [Point::from(0.0); 3];
    let slider = [Point::new(s, linkage.offset), Point::from(v), Point::from(a)];
    let pin = sum(&[(r, input)]);
    let rod = sum(&[(1.0 / l, slider), (-1.0 / l, pin)]);
    let (force_a, moment_a) = inertia(&linkage.crank, zero, input, gravity);
    let (force_b, moment_b) = inertia(&linkage.rod, pin, rod, gravity);
    let along = linkage.slider_mass * (a - gravity.re) + tau;
    let at_slider = Point::new(along, (rod[0].im * along - moment_b / l) / rod[0].re);
    let at_crank = at_slider + force_b;
    let guide = Point::new(0.0, -at_slider.im - (linkage.slider_mass + carried) * gravity.im);
    Reactions {
        output: tau,
        input: moment_a + cross(pin[0], at_crank),
        joints: vec![at_crank + force_a, at_crank, at_slider, guide],
    }
}

/// M = J θ̈ + i τ, and on the teeth τ/r along the pitch circle, τ/r tan α across.
fn gear_pair(gear: &Gear, acceleration: f64, tau: f64, teeth: Teeth) -> Reactions {
    let forces = teeth.arm(gear).map(|arm| Point::new(tau / arm, (tau / arm).abs() * teeth.angle.tan()));
    let input = gear.inertia * acceleration + gear.ratio * tau;
    Reactions { output: tau, input, joints: forces.into_iter().collect() }
}
