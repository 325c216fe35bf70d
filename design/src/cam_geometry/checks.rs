//! Checks that a cam can be cut and run: pressure angle, undercut, curvature, crossings.

use super::contour::pieces;
use super::{Cam, Cut, Follower, Outline, Plan, Point, Side, Standstill, degrees};
use crate::report::Level;
use crate::report::terminal::shown;
use crate::report::unit::{DEG, MM};
use crate::search::summit;
use crate::transmission::Transmission;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// Admissible values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The largest pressure angle (rad).
    pub pressure: f64,
    /// The radius of the tool that cuts a hollow (m).
    pub cutter: f64,
    /// The radius of shaft and hub, which the contour of a disc must not reach (m).
    pub hub: f64,
}

/// A property of the cam with the place where it is worst.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// "pressure angle", "undercut of the inner contour" …
    pub what: String,
    /// The angle φ of the place (rad), 0 … 2π.
    pub phi: f64,
    /// The value there, in SI units; infinite without a limit.
    pub value: f64,
    /// The unit of the value.
    pub unit: &'static str,
    /// The judgement: `Mind` if the cam runs badly, `Bad` if it cannot be cut or does not move the follower as prescribed.
    pub verdict: Level,
    /// Its meaning.
    pub remark: String,
}

impl Finding {
    fn new(what: impl Into<String>, phi: f64, value: f64, unit: &'static str) -> Self {
        let what = what.into();
        Finding { what, phi: phi.rem_euclid(TAU), value, unit, verdict: Level::Good, remark: String::new() }
    }

    fn remark(self, remark: impl Into<String>) -> Self {
        Finding { remark: remark.into(), ..self }
    }

    /// With this verdict unless `good`.
    fn unless(self, good: bool, verdict: Level, remark: impl FnOnce() -> String) -> Self {
        if good { self } else { Finding { verdict, remark: remark(), ..self } }
    }

    /// The least transmission angle of a mechanism after the cam.
    pub fn of_transmission(transmission: &Transmission) -> Self {
        let Transmission { phi, least_angle, .. } = *transmission;
        let finding = Finding::new(transmission.what(), phi, least_angle, "rad").remark(transmission.remark());
        finding.unless(transmission.is_usual(), Level::Mind, || transmission.remark())
    }

    /// The property with its value and its angle.
    pub fn placed(&self) -> String {
        let at = if self.value.is_infinite() { String::new() } else { format!(" at φ = {:.1}°", degrees(self.phi)) };
        format!("{} {}{at}", self.what, self.shown())
    }

    /// The value as a workshop reads it.
    pub fn shown(&self) -> String {
        match self.unit {
            "m" if self.value.is_infinite() => "∞".to_owned(),
            "m" => shown(self.value, &MM),
            // Beyond its limit a value has the digit that shows it.
            "rad" if self.verdict == Level::Good => format!("{:.1}°", self.value.to_degrees()),
            "rad" => format!("{:.2}°", self.value.to_degrees()),
            _ => format!("{}", self.value),
        }
    }
}

/// Samples of a turn at least, and of the shortest wave of the law; the worst place is refined between its neighbours.
const SAMPLES: [f64; 2] = [1440.0, 24.0];

/// The angle and the value of the maximum of `f` over the turn; `f` takes the segment of the law and the angle.
///
/// # Errors
/// The errors of `f`.
pub fn worst(cam: &Cam, f: impl Fn(usize, f64) -> Result<f64, Standstill>) -> Result<(f64, f64), Standstill> {
    let mut best = (0.0, f64::NEG_INFINITY);
    for (from, to, segment) in pieces(cam) {
        let density = f64::max(SAMPLES[0], SAMPLES[1] * cam.law.resolution_in(segment));
        let n = ((density * (to - from) / TAU).ceil() as usize).max(8);
        let angle = |i: usize| from + (to - from) * i as f64 / n as f64;
        let values = (0..=n).map(|i| f(segment, angle(i))).collect::<Result<Vec<_>, _>>()?;
        let sampled = values.iter().fold(best.1, |most: f64, value| most.max(*value));
        for (i, value) in values.iter().enumerate() {
            if *value > best.1 {
                best = (angle(i), *value);
            }
            let beside = [i.saturating_sub(1), (i + 1).min(n)];
            let [a, b] = beside.map(|j| values[j]);
            // Between samples f rises by less than these differ: the highest peak need not have the highest sample.
            if !(*value >= a.max(b) && 2.0 * value - a.min(b) > sampled) {
                continue;
            }
            let ends = beside.map(angle);
            let mut standstill = None;
            let mut value_at =
                |phi: f64| f(segment, phi).map_err(|fault| standstill = Some(fault)).unwrap_or(f64::NEG_INFINITY);
            // At a maximum roundings decide from there on.
            let found = summit(&mut value_at, ends, (angle(i), *value), 1e-9 * (ends[1] - ends[0]));
            if let Some(fault) = standstill {
                return Err(fault);
            }
            if found.1 > best.1 {
                best = found;
            }
        }
    }
    Ok(best)
}

fn millimetres(length: f64) -> String {
    format!("{:.4} mm", (1e7 * length).round() / 1e4 + 0.0)
}

/// All findings of a cam whose contours are these polygons.
///
/// # Errors
/// A roller's centre that stands still on the cam.
pub fn findings(cam: &Cam, plan: &Plan, outlines: &[Outline]) -> Result<Vec<Finding>, Standstill> {
    let mut list = Vec::new();
    if matches!(cam.follower, Follower::Flat { .. }) {
        list.extend(face(cam)?);
        list.extend(size(cam, plan)?);
        list.extend(crossings(outlines));
        return Ok(list);
    }
    list.push(pressure(cam, plan.limits.pressure)?);
    list.extend(reach(cam, plan)?);
    list.extend(size(cam, plan)?);
    list.push(sharpest_of_path(cam)?);
    for side in plan.cut.sides() {
        list.extend(contour(cam, *side, plan.limits.cutter)?);
    }
    list.extend(crossings(outlines));
    Ok(list)
}

fn pressure(cam: &Cam, limit: f64) -> Result<Finding, Standstill> {
    let (phi, pressure) = worst(cam, |segment, phi| Ok(cam.at_in(segment, phi)?.pressure))?;
    let allowed = format!("admissible {}", shown(limit, &DEG));
    let finding = Finding::new("largest pressure angle", phi, pressure, "rad").remark(&allowed);
    Ok(finding.unless(pressure <= limit, Level::Mind, || {
        format!("above the {allowed}: choose a larger base circle, another pivot or offset")
    }))
}

/// The least width of a flat face, and the least radius of curvature h + U″ of its contour.
fn face(cam: &Cam) -> Result<[Finding; 2], Standstill> {
    let contact = |sign: f64| worst(cam, |segment, phi| Ok(sign * cam.at_in(segment, phi)?.place.re));
    let ((left_at, left), (right_at, right)) = (contact(-1.0)?, contact(1.0)?);
    let side = |at: f64, x: f64| format!("{} (φ = {:.1}°)", shown(x, &MM), degrees(at));
    let remark = format!("the contact is between x = {} and {}", side(left_at, -left), side(right_at, right));
    let farthest = if left > right { left_at } else { right_at };
    let radius = |segment: usize, phi: f64| {
        let [u, _, u2, ..] = cam.law.at_in(segment, phi).0;
        Ok(-cam.follower.coordinate(u) - u2)
    };
    let ((phi, radius), (_, low)) =
        (worst(cam, radius)?, worst(cam, |segment, phi| Ok(-cam.law.at_in(segment, phi).0[0]))?);
    let (radius, base) = (-radius, cam.follower.coordinate(-low));
    let what = "undercut of the inner contour: smallest radius of curvature";
    Ok([
        Finding::new("least width of the face", farthest, left + right, "m").remark(remark),
        Finding::new(what, phi, radius, "m").unless(radius > 0.0, Level::Bad, || {
            format!(
                "a flat face cannot touch the hollow contour needed there: enlarge the radius of the base circle from {} to above {}",
                millimetres(base),
                millimetres(base - radius)
            )
        }),
    ])
}

/// The range of the follower's coordinate. A lever must not reach the line pivot–cam centre, and a translating roller not the
/// height of the cam's centre (the second one of a pair is below it): no contour moves them there.
fn reach(cam: &Cam, plan: &Plan) -> Result<[Finding; 2], Standstill> {
    let coordinate = |segment: usize, phi: f64| cam.follower.coordinate(cam.law.at_in(segment, phi).0[0]);
    let (low_at, low) = worst(cam, |segment, phi| Ok(-coordinate(segment, phi)))?;
    let (high_at, high) = worst(cam, |segment, phi| Ok(coordinate(segment, phi)))?;
    let low = -low;
    let (what, unit, good) = match cam.follower {
        Follower::Lever { .. } => ("angle of the lever to the line pivot–cam centre", "rad", [low > 0.0, high < PI]),
        Follower::Translating { .. } | Follower::Flat { .. } => {
            let good = low > 0.0 || high < 0.0;
            ("height of the roller above the cam's centre", "m", [good, good])
        }
    };
    let remedy = || out_of_reach(cam, plan, [low, high]);
    let of = |word: &str, phi: f64, value: f64, good: bool| {
        Finding::new(format!("{word} {what}"), phi, value, unit).unless(good, Level::Bad, remedy)
    };
    Ok([of("least", low_at, low, good[0]), of("largest", high_at, high, good[1])])
}

/// The reason why a cam cannot move a follower with this range of its coordinate, and the key that changes it.
fn out_of_reach(cam: &Cam, plan: &Plan, [low, high]: [f64; 2]) -> String {
    let degrees = |angle: f64| format!("{:.3}°", angle.to_degrees());
    let second = match plan.cut {
        Cut::Conjugate(second) if !plan.is_first(cam) => Some(second),
        _ => None,
    };
    match (cam.follower, second) {
        // ψ₂ = λ − ψ must stay between 0 and π.
        (Follower::Lever { .. }, Some(second)) => format!(
            "the second arm turns through the line pivot–cam centre, where a cam cannot move it: change `second_arm_angle` from {} to above {}, the largest angle of the first arm, and below {}",
            degrees(second.place),
            degrees(second.place - low),
            degrees(PI + second.place - high)
        ),
        (Follower::Lever { .. }, None) => {
            let more = if low <= 0.0 { "larger" } else { "smaller" };
            format!("the arm turns through the line pivot–cam centre, where a cam cannot move it: choose a {more} `start_angle`, `prime_radius` or `base_radius`")
        }
        // h₂ = h − D must stay below the cam's centre.
        (_, Some(second)) => format!(
            "the second roller passes the cam's centre, where a cam cannot move it: change `roller_distance` from {} to above {}, the largest height of the first roller",
            millimetres(second.place),
            millimetres(second.place + high)
        ),
        (_, None) => {
            "the roller passes the cam's centre, where a cam cannot move it: choose a larger `start_height`, `prime_radius` or `base_radius`".to_owned()
        }
    }
}

/// The size of the cam.
fn size(cam: &Cam, plan: &Plan) -> Result<Vec<Finding>, Standstill> {
    // At an extreme distance from the cam's centre the contour is at right angles to it: its own distance differs by the radius
    // of the roller.
    let (low_at, nearest) = worst(cam, |segment, phi| Ok(-cam.at_in(segment, phi)?.centre.norm()))?;
    let (high_at, farthest) = worst(cam, |segment, phi| Ok(cam.at_in(segment, phi)?.centre.norm()))?;
    let mut list = Vec::new();
    if !matches!(cam.follower, Follower::Flat { .. }) {
        list.push(Finding::new("prime circle: smallest radius of the roller path", low_at, -nearest, "m"));
    }
    if plan.cut.sides().contains(&Side::Inner) {
        let (least, most, hub) = (-nearest - cam.roller, farthest - cam.roller, plan.limits.hub);
        list.push(Finding::new("base circle: smallest radius of the inner contour", low_at, least, "m").unless(
            least > hub,
            Level::Bad,
            || match hub > 0.0 {
                true => format!("the contour cuts into shaft and hub (radius {})", millimetres(hub)),
                false => format!("the roller (radius {}) covers the cam's centre", millimetres(cam.roller)),
            },
        ));
        let disc = !matches!(plan.cut, Cut::Groove);
        let pivot = match cam.follower {
            Follower::Lever { pivot, .. } if disc => pivot,
            _ => f64::INFINITY,
        };
        list.push(Finding::new("largest radius of the inner contour", high_at, most, "m").unless(
            most < pivot,
            Level::Mind,
            || format!("the cam reaches the lever's pivot, {} from its centre", millimetres(pivot)),
        ));
    }
    if plan.cut.sides().contains(&Side::Outer) {
        list.push(Finding::new("largest radius of the outer contour", high_at, farthest + cam.roller, "m"));
    }
    Ok(list)
}

/// The least radius of curvature of the path of the roller's centre.
fn sharpest_of_path(cam: &Cam) -> Result<Finding, Standstill> {
    let (phi, curvature) = worst(cam, |segment, phi| Ok(cam.at_in(segment, phi)?.curvature.abs()))?;
    let at = cam.at(phi.rem_euclid(TAU))?;
    // The path of a cam that turns counter-clockwise is run clockwise: convex to the right.
    let shape = if at.curvature * cam.sense <= 0.0 { "convex" } else { "concave" };
    Ok(Finding::new("smallest radius of curvature of the roller path", phi, 1.0 / curvature, "m").remark(shape))
}

/// Undercut, bulges and hollows of a contour.
fn contour(cam: &Cam, side: Side, cutter: f64) -> Result<Vec<Finding>, Standstill> {
    let name = side.name();
    // The roller at whose radius the contour gets a cusp, at the sharpest place of the path.
    let (phi, sharpest) = worst(cam, |segment, phi| Ok(side.sign(cam.sense) * cam.at_in(segment, phi)?.curvature))?;
    let most = if sharpest > 0.0 { 1.0 / sharpest } else { f64::INFINITY };
    let undercut = Finding::new(format!("undercut of the {name}: largest admissible roller radius"), phi, most, "m").unless(
        cam.roller < most,
        Level::Bad,
        || {
            format!(
                "the roller (radius {}) cuts away a part of the contour that it needs: choose a smaller roller or a larger base circle",
                millimetres(cam.roller)
            )
        },
    );
    let good = undercut.verdict == Level::Good;
    let mut list = vec![undercut];
    // Bulges curve around the material, which is beyond the contour as seen from the path; hollows curve away from it.
    let bulge = |segment: usize, phi: f64| {
        let at = cam.at_in(segment, phi)?;
        Ok([at.curvature, side.curvature(cam, &at)].map(|curvature| side.sign(cam.sense) * curvature))
    };
    // A roller that is too large leaves a bulge without radius.
    if good {
        let (phi, curvature) = worst(cam, |segment, phi| bulge(segment, phi).map(|[_, k]| k))?;
        if curvature > 0.0 {
            list.push(Finding::new(format!("smallest convex radius of curvature, {name}"), phi, 1.0 / curvature, "m"));
        }
    }
    // Hollows are hollows of the path too, beyond which an undercut contour turns over.
    let hollow = |[path, contour]: [f64; 2]| if path < 0.0 { -contour } else { -path };
    let (phi, curvature) = worst(cam, |segment, phi| bulge(segment, phi).map(hollow))?;
    if curvature > 0.0 {
        let radius = 1.0 / curvature;
        list.push(Finding::new(format!("smallest concave radius of curvature, {name}"), phi, radius, "m").unless(
            radius >= cutter,
            Level::Bad,
            || format!("a cutter of radius {} does not fit", millimetres(cutter)),
        ));
    }
    Ok(list)
}

/// The crossings of contours with themselves or each other.
fn crossings(outlines: &[Outline]) -> Vec<Finding> {
    let mut list = Vec::new();
    let pairs =
        outlines.iter().enumerate().flat_map(|(i, first)| outlines[i..].iter().map(move |second| (first, second)));
    for (first, second) in pairs {
        let both = if first == second { vec![first] } else { vec![first, second] };
        let Some(Crossing { angles: [one, other], place }) = crossing(&both) else { continue };
        let what = match both.len() {
            1 => format!("the {} crosses itself", first.side.name()),
            _ => format!("the {} crosses the {}", first.side.name(), second.side.name()),
        };
        let remark = format!(
            "at φ = {:.3}° and {:.3}°, ({}, {}) of the cam: one passage cuts away what the other needs",
            degrees(one),
            degrees(other),
            millimetres(place.re),
            millimetres(place.im)
        );
        let finding = Finding::new(what, one, place.norm(), "m");
        list.push(finding.unless(false, Level::Bad, || remark));
    }
    list
}

/// Two places of contours at one point.
struct Crossing {
    angles: [f64; 2],
    place: Point,
}

/// The first crossing of a polygon with itself, or of two polygons with each other.
fn crossing(outlines: &[&Outline]) -> Option<Crossing> {
    let edge = |(o, i): (usize, usize)| {
        let points = &outlines[o].points;
        (points[i].1, points[(i + 1) % points.len()].1)
    };
    let angle = |(o, i): (usize, usize)| outlines[o].points[i].0;
    // Edges sorted by their least abscissa: only those that overlap in it can cross.
    let all = (0..outlines.len()).flat_map(|o| (0..outlines[o].points.len()).map(move |i| (o, i)));
    let mut order: Vec<(usize, usize)> = all.collect();
    let least = |e: (usize, usize)| edge(e).0.re.min(edge(e).1.re);
    order.sort_by(|a, b| least(*a).total_cmp(&least(*b)));
    for (place, &first) in order.iter().enumerate() {
        let (a, b) = edge(first);
        let most = a.re.max(b.re);
        for &second in order[place + 1..].iter().take_while(|second| least(**second) <= most) {
            let n = outlines[first.0].points.len();
            let same = first.0 == second.0;
            let neighbours = same && ((first.1 + 1) % n == second.1 || (second.1 + 1) % n == first.1);
            let (c, d) = edge(second);
            let apart = c.im.min(d.im) > a.im.max(b.im) || c.im.max(d.im) < a.im.min(b.im);
            // For two outlines only the crossings with each other count.
            if neighbours || apart || (same && outlines.len() > 1) {
                continue;
            }
            if let Some(at) = meeting(a, b, c, d) {
                let (one, other) = (angle(first), angle(second));
                return Some(Crossing { angles: [one.min(other), one.max(other)], place: at });
            }
        }
    }
    None
}

/// The point at which the lines a–b and c–d cross between their ends.
fn meeting(a: Point, b: Point, c: Point, d: Point) -> Option<Point> {
    let cross = |u: Point, v: Point| (u.conj() * v).im;
    let (u, v) = (b - a, d - c);
    let area = cross(u, v);
    if area == 0.0 {
        return None;
    }
    let (s, t) = (cross(c - a, v) / area, cross(c - a, u) / area);
    ((0.0..1.0).contains(&s) && (0.0..1.0).contains(&t)).then(|| a + u * s)
}
