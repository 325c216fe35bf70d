//! Pressure angle and curvature over the turn as diagrams.

use super::{Cam, Carrier, Disc, Shape, Side};
use crate::plot::{Axis, Diagram, Rule, Series};
use std::f64::consts::TAU;

/// Points of a curve.
const POINTS: usize = 720;

fn curve(name: String, cam: &Cam, f: impl Fn(&super::CamPosition) -> f64) -> Series {
    let point = |i: usize| {
        let phi = TAU * i as f64 / POINTS as f64;
        [phi.to_degrees(), cam.at(phi).map_or(f64::NAN, |at| f(&at))]
    };
    Series::line(name, (0..=POINTS).map(point))
}

fn angle() -> Axis {
    Axis::angular("Angle of the cam [°]").between(0.0, 360.0)
}

fn named(what: &str, cam: &str) -> String {
    if cam.is_empty() { what.to_owned() } else { format!("{what} {cam}") }
}

/// The pressure angle over the turn with its admissible limit; for a flat face the place of the contact.
pub fn pressure(shape: &Shape) -> Diagram {
    if shape.plan.carrier == Carrier::Flat {
        let curves = shape.cams.iter().map(|c| curve("contact".to_owned(), &c.cam, |at| at.place.re)).collect();
        let axes = [angle(), Axis::linear("Contact from the cam's centre [m]")];
        return Diagram::new(format!("Contact on the face of {}", shape.name), axes, curves, Vec::new());
    }
    let limit = shape.plan.limits.pressure;
    let curves = shape.cams.iter().map(|c| curve(named("cam", c.name), &c.cam, |at| at.pressure));
    let limit = Rule::Horizontal(limit, "admissible".to_owned());
    let axes = [angle(), Axis::linear("Pressure angle [rad]")];
    Diagram::new(format!("Pressure angle of {}", shape.name), axes, curves.collect(), vec![limit])
}

/// The curvature of the path of the roller's centre, positive in a bulge, with the curvature at which undercut begins; for a
/// flat face the radius of curvature of the contour.
pub fn curvature(shape: &Shape) -> Diagram {
    if shape.plan.carrier == Carrier::Flat {
        let radius = |c: &Disc| curve("contour".to_owned(), &c.cam, |at| Side::Inner.closeness(&c.cam, at));
        let axes = [angle(), Axis::linear("Radius of curvature [m]")];
        let title = format!("Radius of curvature of the contour, {}", shape.name);
        return Diagram::new(title, axes, shape.cams.iter().map(radius).collect(), Vec::new());
    }
    let same = shape.cams.iter().all(|c| Some(c.cam.roller) == shape.cams.first().map(|first| first.cam.roller));
    let rules = shape.cams.iter().take(if same { 1 } else { shape.cams.len() }).flat_map(|c| {
        shape.plan.cut.sides().iter().map(move |side| {
            let sign = if *side == Side::Inner { 1.0 } else { -1.0 };
            let what = format!("undercut of the {}", side.name());
            Rule::Horizontal(sign / c.cam.roller, if same { what } else { named(&what, c.name) })
        })
    });
    let curves = shape.cams.iter().map(|c| curve(named("path", c.name), &c.cam, |at| -c.cam.sense * at.curvature));
    let title = format!("Curvature of the path of the roller's centre, {}", shape.name);
    Diagram::new(
        title,
        [angle(), Axis::linear("Curvature of the roller's path [1/m]")],
        curves.collect(),
        rules.collect(),
    )
}
