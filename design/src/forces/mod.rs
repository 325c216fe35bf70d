//! Kinetostatics: the forces with which a machine at constant speed moves its tools, from the tool back to the cam.
//!
//! The tool's load is τ = m ÿ − F_L with the loads F_L on it ([`camdrive::drives::follower::load`]). The mechanisms pass it on
//! ([`mechanism`]), and with the lever Q = J_l Ü + (torque of the first mechanism) is the force on the coordinate U of the cam.
//! By virtual work the roller presses with N = Q/(n · dp/dU), and the cam's shaft needs M = Q U′. The contact (Hertz, line
//! contact of cylinders) bears
//!
//! p_H = √(N E*/(π L R)),  1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂,  R = ϱ (1 ∓ ϱκ),
//!
//! with the roller's radius reduced by the curvature of the contour; for a flat face R is the radius of the contour. Symbols: y
//! coordinate of the tool (m or rad), m its mass (kg) or moment of inertia (kg·m²); n normal of the path of the roller's centre
//! p that points away from the inner contour; N > 0 presses on the inner contour, N < 0 on the outer one; L width of the
//! contact (m).
//! Valid for rigid bodies without friction and clearance, at constant speed. Source: Dresig, Holzweißig, *Maschinendynamik*,
//! section 2.4 (kinetostatics); VDI 2142 and VDI 2143 (cams); Johnson, *Contact Mechanics*, section 4.2 (Hertz).

mod contact;
pub mod figures;
mod machine;
pub mod mechanism;
pub mod quantity;
pub mod report;
#[cfg(test)]
mod tests;
mod turn;

pub use contact::Held;
pub use report::ForceAnalysis;
pub use turn::{Machine, MachineTurn, least_place};

use crate::cam_geometry::{self, Cam, Follower as Carrier, Plan, Point, Side};
use camdrive::drives::Fault;
use camdrive::drives::elastic_shaft;
use camdrive::drives::follower::load::Load;
use camdrive::drives::rigid_machine::Follower;
use camdrive::drives::rigid_machine::linkage::{Linkage, in_turn};
pub use mechanism::Teeth;
use mechanism::{Demand, Reactions, reactions};
use std::f64::consts::PI;

/// The contact of roller and cam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// L (m).
    pub width: f64,
    /// E₁, E₂ (Pa) of cam and roller.
    pub elasticity: [f64; 2],
    /// ν₁, ν₂.
    pub poisson: [f64; 2],
}

/// What gives between drive and tool.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Compliance {
    /// Nothing.
    #[default]
    Rigid,
    /// A spring c (N/m) with a damper b (N·s/m) before the tool.
    Output([f64; 2]),
    /// A shaft before the cam, and whether its equation is linearised.
    Shaft(elastic_shaft::Parameters, bool),
}

/// The loads on a follower, and the parts that bear them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loads {
    /// J_l (kg·m²) of all parts that turn with the lever.
    pub lever_inertia: f64,
    /// Loads on the tool.
    pub load: Load,
    /// Part of the mass (kg) that is on the cam's side of an elasticity or clearance, and loads on it.
    pub roller: (f64, Load),
    /// True if the follower may leave its cam in the FMU's motion.
    pub may_leave: bool,
    /// What gives in the FMU's motion.
    pub compliance: Compliance,
    /// True if the contact opens in the motion that a motor gives the shaft, which is not at constant speed.
    pub opens: bool,
    /// Teeth of its gears.
    pub teeth: Teeth,
    /// The material of the contact.
    pub material: Option<Material>,
}

/// A cam, what it moves and what acts on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Its name.
    pub name: String,
    /// Law, mechanisms and tool.
    pub follower: Follower,
    /// The geometry of the cam, if it is known.
    pub plan: Option<Plan>,
    /// Its loads.
    pub loads: Loads,
    /// The contacts that can bear its force.
    contacts: Vec<Bearing>,
}

/// A flank on which a roller can run.
#[derive(Clone, Debug, PartialEq)]
struct Bearing {
    /// "F" and "P" of a conjugate pair, else empty.
    name: &'static str,
    cam: Cam,
    side: Side,
}

impl Bearing {
    /// Its name after the drive's.
    fn suffix(&self) -> String {
        if self.name.is_empty() { String::new() } else { format!(" {}", self.name) }
    }
}

/// A contact of roller and cam at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The force (N), positive if it presses.
    pub force: f64,
    /// The force for Q = 1.
    pub gain: f64,
    /// The pressure angle (rad).
    pub pressure_angle: f64,
    /// p_H (Pa), 0 without pressure.
    pub hertzian: f64,
    /// Its component along x (N), with which a translating follower presses against its guide; for a flat face its moment about
    /// the line of the follower (N·m).
    pub side: f64,
}

/// The forces of a drive at one angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// y, ẏ, ÿ.
    pub tool: [f64; 3],
    /// Q (N, of an angular law N·m).
    pub load: f64,
    /// Q at rest, its growth by damping for each rad/s, and by inertia for each (rad/s)².
    pub parts: [f64; 3],
    /// dy/dU: Q for F₀ = 1.
    pub travel: f64,
    /// M (N·m).
    pub torque: f64,
    /// (b ẏ − P) dy/dφ (N·m): the part of process and damping in M.
    pub process: f64,
    /// Reactions in each mechanism, from the cam to the tool.
    pub mechanisms: Vec<Reactions>,
    /// Forces in each contact.
    pub contacts: Vec<Contact>,
}

impl Forces {
    /// The load on the tool (N or N·m): after mechanisms the output of the last one.
    pub fn on_tool(&self) -> f64 {
        self.mechanisms.last().map_or(self.load, |last| last.output)
    }

    fn is_finite(&self) -> bool {
        let joints = self.mechanisms.iter().flat_map(|mechanism| &mechanism.joints);
        let contacts = self.contacts.iter().flat_map(|contact| [contact.force, contact.hertzian]);
        let all = [self.load, self.torque].into_iter().chain(self.parts).chain(joints.map(|f| f.norm()));
        all.chain(contacts).all(f64::is_finite)
    }
}

impl Loads {
    /// The loads on the tool and on the cam's side.
    fn on(&self) -> [&Load; 2] {
        [&self.load, &self.roller.1]
    }

    /// F_L at rest at y, for the follower's total mass `m`.
    fn push(&self, m: f64, y: f64, process: f64) -> f64 {
        let (m_roller, roller) = &self.roller;
        // Without a second mass both loads act on the only one.
        let tool = if m > *m_roller { m - m_roller } else { m };
        self.load.force(tool, [y, 0.0], Some(process), None) + roller.force(*m_roller, [y, 0.0], None, None)
    }
}

impl Material {
    /// p_H (Pa) for a force (N) and an equivalent radius R (m); 0 without pressure.
    fn hertzian(&self, force: f64, radius: f64) -> f64 {
        if force <= 0.0 {
            return 0.0;
        }
        let compliance: f64 = (0..2).map(|i| (1.0 - self.poisson[i].powi(2)) / self.elasticity[i]).sum();
        (force / (compliance * PI * self.width * radius)).sqrt()
    }
}

impl Drive {
    /// A drive with the contacts of its geometry.
    ///
    /// # Errors
    /// A base or prime circle that no follower of these lengths has.
    pub fn new(name: String, follower: Follower, plan: Option<Plan>, loads: Loads) -> Result<Drive, Fault> {
        let mut contacts = Vec::new();
        for (name, cam) in plan.map_or(Ok(Vec::new()), |plan: Plan| plan.cams(&follower.cam))? {
            let sides = plan.map_or(&[][..], |plan| plan.cut.sides());
            contacts.extend(sides.iter().map(|side| Bearing { name, cam: cam.clone(), side: *side }));
        }
        Ok(Drive { name, follower, plan, loads, contacts })
    }

    /// True if force alone keeps the contact: a single contact, or a return spring without a geometry.
    pub fn is_force_closed(&self) -> bool {
        self.contacts.len() == 1
            || self.plan.is_none()
                && self.loads.on().iter().any(|load| load.spring.is_some())
                && self.follower.has_cam()
    }

    /// True if force alone keeps the contact, and a load of the scene acts; without any the scene does not say what holds it.
    fn is_held(&self) -> bool {
        let acts = self.loads.lever_inertia > 0.0 || self.loads.on().iter().any(|load| !load.is_none());
        acts && self.is_force_closed()
    }

    /// True if the follower has a flat face.
    fn is_flat(&self) -> bool {
        self.plan.is_some_and(|plan| plan.carrier == cam_geometry::Carrier::Flat)
    }

    /// F₀ (N or N·m) of all its springs.
    fn preload(&self) -> f64 {
        self.loads.on().map(|load| load.spring.map_or(0.0, |spring| spring.preload)).iter().sum()
    }

    /// The part on which the torque of an angular law acts.
    fn turned(&self) -> &'static str {
        if self.follower.has_cam() { "torque on the lever" } else { "torque on the crank" }
    }

    /// J_l with respect to U: a law that is a length turns the lever by U/R.
    fn reduced_inertia(&self) -> f64 {
        match self.contacts.first().map(|bearing| bearing.cam.follower) {
            Some(Carrier::Lever { transmission, .. }) if !self.follower.cam_turns() => {
                self.loads.lever_inertia / (transmission * transmission)
            }
            _ => self.loads.lever_inertia,
        }
    }

    /// The tool's coordinate and its derivatives, mechanism by mechanism from the law of the cam.
    fn motions(&self, lever: [f64; 3]) -> Vec<[f64; 3]> {
        let mut motions = vec![lever];
        for mechanism in &self.follower.linkage.0 {
            let input = motions[motions.len() - 1];
            motions.push(Linkage(vec![*mechanism]).tool(input));
        }
        motions
    }

    /// Q and the reactions of the mechanisms with U, U̇, Ü in `lever` and the load `push` on the tool (N or N·m); without the
    /// weight of links for `weight` = 0, with it for 1.
    fn backward(&self, lever: [f64; 3], push: f64, weight: f64) -> (f64, Vec<Reactions>) {
        let motions = self.motions(lever);
        let mass = self.follower.m;
        let mut load = mass * motions[motions.len() - 1][2] - push;
        let mut list = Vec::new();
        for (i, mechanism) in self.follower.linkage.0.iter().enumerate().rev() {
            let frame = self.loads.load.frames.get(i).map_or([0.0; 2], |gravity| gravity.map(|g| g * weight));
            let gravity = Point::new(frame[0], frame[1]);
            let demand = Demand { tau: load, carried: mass, gravity };
            list.push(reactions(mechanism, [motions[i], motions[i + 1]], demand, self.loads.teeth));
            load = list[list.len() - 1].input;
        }
        list.reverse();
        (load + self.reduced_inertia() * lever[2], list)
    }

    /// The forces at φ on the piece of the turn with its middle at `within`, at the speed ω (rad/s).
    ///
    /// # Errors
    /// A roller's centre that stands still on the cam, a bearing contour that is undercut, and values beyond the range of
    /// numbers.
    pub fn at(&self, within: f64, phi: f64, w: f64) -> Result<Forces, Fault> {
        let law = &self.follower.cam;
        let segment = law.segment(within, true);
        let [u, u1, u2, ..] = law.at_in(segment, phi).0;
        let place = self.follower.tool([u, 1.0]);
        let process = self.loads.load.process.as_ref().map_or(0.0, |p| p.at_in(p.segment(within, true), phi).0[0]);
        let lever = [u, u1 * w, u2 * w * w];
        let push = self.loads.push(self.follower.m, place[0], process);
        let damping = -self.loads.on().map(|load| load.damping.unwrap_or(0.0)).iter().sum::<f64>() * place[1] * u1;
        let (load, mechanisms) = self.backward(lever, push + damping * w, 1.0);
        let (at_rest, _) = self.backward([u, 0.0, 0.0], push, 1.0);
        let (by_damping, _) = self.backward([u, 0.0, 0.0], damping, 0.0);
        let (by_inertia, _) = self.backward([u, u1, u2], 0.0, 0.0);
        let contacts = self.contacts.iter().map(|contact| self.contact(contact, segment, phi, load));
        let forces = Forces {
            tool: self.follower.tool(lever),
            load,
            parts: [at_rest, by_damping, by_inertia],
            travel: place[1],
            torque: load * u1,
            process: -(process + damping * w) * place[1] * u1,
            mechanisms,
            contacts: contacts.collect::<Result<_, _>>()?,
        };
        if forces.is_finite() {
            return Ok(forces);
        }
        let (place, name) = (in_turn(phi, 3), &self.name);
        Err(Fault::new(format!("at φ = {place}° the forces of {name} exceed the range of numbers")))
    }

    /// A contact under the force `load` on the cam's coordinate.
    fn contact(&self, bearing: &Bearing, segment: usize, phi: f64, load: f64) -> Result<Contact, Fault> {
        let Bearing { cam, side, .. } = bearing;
        let at = cam.at_in(segment, phi)?;
        let gain = if *side == Side::Outer { -1.0 } else { 1.0 } / at.gain;
        if !gain.is_finite() {
            let (place, name) = (in_turn(phi, 3), &self.name);
            return Err(Fault::new(format!(
                "at φ = {place}° the pressure angle of {name} is 90°: no roller force moves it"
            )));
        }
        let (force, radius) = (gain * load, side.closeness(cam, &at));
        if force > 0.0 && radius <= 0.0 && self.loads.material.is_some() {
            return Err(Fault::new(format!(
                "at φ = {}° the {} of {}{} is undercut, so there is no contact pressure; find what fits with `camdrive cam`",
                in_turn(phi, 3),
                side.name(),
                self.name,
                bearing.suffix()
            )));
        }
        let pressure = |material: Material| material.hertzian(force, radius);
        Ok(Contact {
            force,
            gain,
            pressure_angle: at.pressure,
            hertzian: self.loads.material.map_or(0.0, pressure),
            side: load / at.gain * if self.is_flat() { at.place.re } else { at.normal.re },
        })
    }
}
