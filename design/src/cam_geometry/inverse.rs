//! From the contour of a cam to its motion law: U(φ) of the follower that runs on it.
//!
//! A periodic spline through the points, over the sum of the chords, gives the normal n in each of them. A roller that touches
//! there has its centre at z = c ± ϱ n. The centre's distance from the cam's centre gives the follower's coordinate, and with
//! it p, and φ = σ arg(p/z). A flat face that touches at c has h = Re(c n̄) and φ = σ arg(i/n). An error δ of the direction of
//! n moves the pair (φ, U) along the law and changes it by ϱδ²/2 only, so the pairs are as accurate as the points; normals of
//! the law give better pairs. The law is the periodic quintic spline through them, with its jumps of U″ ([`Corners`]). Without
//! noise the law of a flat face needs no spline: contact and curvature give U, U′ and U″ (module `flat`).
//!
//! Symbols: c point of the contour seen from the cam (m), others as in [`super`]. The contour must go around the cam's centre
//! once, and each point must be in contact at an angle of its own: hollows narrower than the roller, any hollows below a flat
//! face and parts without points are refused. Source: derived here from the forward equations of [`super`].

mod flat;

use super::contour::Side;
use super::{Cam, Carrier, I, Plan, Point, Start, degrees};
use crate::smoothing::{Corners, Outliers, SmoothingError, smooth};
use crate::table_error::told;
use camdrive::drives::Fault;
use camdrive::motion::table::{Bend, Points};
use camdrive::motion::{MotionLaw, Table};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// The law of a contour, as points of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// Angles and lifts.
    pub points: Points,
    /// U′ and U″ of the points; empty if U″ does not jump.
    pub bends: Vec<Bend>,
    /// The point of the contour of each.
    pub rows: Vec<usize>,
    /// The ratio of the standard deviations of the lifts and of the points.
    pub noise: f64,
    /// The largest uncertainty of the contour between its points (m), and the row before it; None if unknown.
    pub open: Option<(f64, usize)>,
    /// The uncertainty of U″ between the points, as a part of its largest value; None if unknown.
    pub bend_open: Option<f64>,
    /// The coordinate of the follower at U = 0.
    start: f64,
}

/// A point of the contour in contact: angle, coordinate of the follower, curvature of the contour (1/m), positive in a bulge.
#[derive(Clone, Copy)]
struct Contact {
    phi: f64,
    coordinate: f64,
    curvature: f64,
    /// Its point, among the points without repetitions.
    point: usize,
    /// h′ and h″ below a flat face.
    bend: Option<Bend>,
}

/// The reason why a contour gives no law.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// The point at fault; None if the whole contour is.
    pub index: Option<usize>,
    /// The fault.
    pub message: String,
    /// A remedy.
    pub hint: String,
}

impl Refusal {
    fn at(index: impl Into<Option<usize>>, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Refusal { index: index.into(), message: message.into(), hint: hint.into() }
    }
}

/// The fewest points of a contour.
const LEAST: usize = 8;

/// A gap is wider than this (rad), and than this many times both of its neighbours: rests are measured every two degrees. Steps
/// of 45° are always gaps.
const GAP: (f64, f64) = (PI / 72.0, 3.0);

/// The least radius may differ from the given one by this part of the stroke, the tolerance of a finished cam.
const SIZE: f64 = 0.01;

/// A bend with a radius beyond this many times the distance from the cam's centre looks straight.
const STRAIGHT: f64 = 1e3;

/// The hint on points that no follower passes in their order.
const ORDER: &str = "check the follower, its `roller_radius` and the order of the points; set `noise`, for example \"estimate\", if the points have noise";

fn millimetres(length: f64) -> String {
    format!("{:.4} mm", 1e3 * length)
}

/// The law of `plan` with this contour, seen from the cam at φ = 0: the inner contour of a groove, the first cam's of a pair.
/// `noise` is the standard deviation of its points; None in it estimates the deviation from them.
///
/// # Errors
/// A contour that does not determine the law.
pub fn trace(plan: &Plan, contour: &[Point], noise: Option<Option<f64>>) -> Result<Traced, Refusal> {
    let outline = Outline::new(plan, contour)?;
    let mut contacts = outline.contacts(noise)?;
    let (order, steps) = outline.order(&contacts.list)?;
    let start = outline.start(contacts.range)?;
    let n = order.len();
    // Begins between points that are neither so close that they count as one nor so far apart that some may be missing.
    let mut by_width: Vec<usize> = (0..n).collect();
    by_width.sort_by(|a, b| steps[*a].total_cmp(&steps[*b]));
    let seam = by_width[n / 2];
    let first = (contacts.list[order[(seam + 1) % n]].phi - 0.5 * steps[seam]).rem_euclid(TAU);
    let mut traced = outline.law(&contacts, first, start);
    if noise.is_none() && plan.carrier != Carrier::Flat {
        traced = traced.cornered();
        // The law gives better normals if the curvature jumps between points far apart.
        for _ in 0..2 {
            let Some(motion) = traced.law() else { break };
            outline.touch_again(&mut contacts.list, &plan.with(motion, start));
            traced = outline.law(&contacts, first, start).cornered();
        }
    }
    Ok(traced)
}

/// The points of a contour, which go around the cam's centre once, and the follower on them.
struct Outline<'a> {
    plan: &'a Plan,
    points: Vec<Point>,
    /// Their indices among all points.
    rows: Vec<usize>,
    /// 2π (sum of chords)/(length).
    angles: Vec<f64>,
    /// 1 if they go around counter-clockwise, else −1.
    left: f64,
}

/// The contacts of all points of a contour.
struct Contacts {
    list: Vec<Contact>,
    /// The least and the largest coordinate of the follower.
    range: [f64; 2],
    noise: f64,
    open: Option<(f64, usize)>,
    bend_open: Option<f64>,
}

impl<'a> Outline<'a> {
    fn new(plan: &'a Plan, contour: &[Point]) -> Result<Self, Refusal> {
        let (rows, angles) = around(contour)?;
        let points: Vec<Point> = rows.iter().map(|&row| contour[row]).collect();
        let n = points.len();
        let seen = steps((0..n).map(|i| (points[(i + 1) % n] / points[i]).arg()));
        let winding = seen.iter().sum::<f64>();
        if !((winding.abs() - TAU).abs() < 1.0) {
            let hint = "the origin must be the cam's centre; check columns and units";
            return Err(Refusal::at(None, "the contour does not go around the cam's centre once", hint));
        }
        let outline = Outline { plan, points, rows, angles, left: winding.signum() };
        match gap(&seen) {
            Some(k) => Err(outline.missing(seen[k], (k + 1) % n, "around the cam's centre")),
            None => Ok(outline),
        }
    }

    /// The refusal of a contour without points over this step before a point.
    fn missing(&self, step: f64, point: usize, of: &str) -> Refusal {
        let message = format!("the contour has no point in the {:.3}° {of} before this one", step.abs().to_degrees());
        let hint = "measure the whole turn; if no point is missing, the contour has a corner there by undercut; check columns and units";
        Refusal::at(self.rows[point], message, hint)
    }

    /// The distance from a point of contact outwards to the roller's centre.
    fn outwards(&self) -> f64 {
        if self.plan.cut.sides()[0] == Side::Outer { -self.plan.roller } else { self.plan.roller }
    }

    /// Angle and coordinate of the follower that touches at c, the point of this number, with this normal, and the change of
    /// the coordinate by a shift of c along the normal.
    fn place(&self, point: usize, c: Point, normal: Point) -> Result<(f64, f64, f64), Refusal> {
        let plan = self.plan;
        if plan.carrier == Carrier::Flat {
            return Ok((plan.sense * (I * normal.conj()).arg(), (c * normal.conj()).re, 1.0));
        }
        let centre = c + self.outwards() * normal;
        let coordinate = plan.coordinate_at(centre.norm()).map_err(|fault: Fault| {
            let message = format!("no roller of this follower touches the contour here: {fault}");
            Refusal::at(self.rows[point], message, "check the lengths of the follower and the unit of the points")
        })?;
        let below = matches!(plan.start, Start::Coordinate(start) if start < 0.0);
        let coordinate =
            if below && matches!(plan.carrier, Carrier::Translating { .. }) { -coordinate } else { coordinate };
        let ([held, ..], by_lift) = plan.follower(coordinate).position([0.0; 3]);
        let turned = held * centre.conj() / (held * centre).norm();
        Ok((plan.sense * turned.arg(), coordinate, 1.0 / (turned * normal * by_lift.conj()).re))
    }

    /// The contacts; a roller's by normals of a spline.
    fn contacts(&self, noise: Option<Option<f64>>) -> Result<Contacts, Refusal> {
        let (points, n) = (&self.points, self.points.len());
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        if self.plan.carrier == Carrier::Flat && noise.is_none() {
            let (list, (open, after), bend_open) =
                below_face(self.plan.sense, points, self.left > 0.0).map_err(|i| self.dented(i))?;
            list.iter().for_each(|c| (low, high) = (low.min(c.coordinate), high.max(c.coordinate)));
            let open = Some((open, self.rows[after]));
            return Ok(Contacts { list, range: [low, high], noise: 0.0, open, bend_open: Some(bend_open) });
        }
        let angles = &self.angles;
        let [x, y] = [|p: &Point| p.re, |p: &Point| p.im].map(|part| smoothed(angles, points.iter().map(part), noise));
        let (x, y) = (x?, y?);
        let (mut list, mut variance) = (Vec::new(), 0.0);
        for i in 0..n {
            let [curve, slope, bend] =
                [0, 1, 2].map(|order| Point::new(x.at(angles[i]).0[order], y.at(angles[i]).0[order]));
            let normal = -I * self.left * slope / slope.norm();
            // A shift of a point along the contour does not change it.
            let off = ((points[i] - curve) * normal.conj()).re;
            let (phi, coordinate, per) = self.place(i, curve + normal * off, normal)?;
            variance += per * per / n as f64;
            let even = self.place(i, curve, normal)?.1;
            (low, high) = (low.min(even), high.max(even));
            let curvature = self.left * (slope.conj() * bend).im / slope.norm().powi(3);
            list.push(Contact { phi, coordinate, curvature, point: i, bend: None });
        }
        Ok(Contacts { list, range: [low, high], noise: variance.sqrt(), open: None, bend_open: None })
    }

    /// The contacts in the order in which the follower passes them, and the steps of φ from each to the next.
    fn order(&self, found: &[Contact]) -> Result<(Vec<usize>, Vec<f64>), Refusal> {
        let n = found.len();
        // A cam that turns counter-clockwise sees its follower run around it clockwise.
        let mut order: Vec<usize> = (0..n).collect();
        if self.left * self.plan.sense > 0.0 {
            order.reverse();
        }
        let next = |k: usize| order[(k + 1) % n];
        let steps = steps((0..n).map(|k| found[next(k)].phi - found[order[k]].phi));
        if let Some(k) = gap(&steps) {
            let after = found[next(k)];
            return Err(self.missing(steps[k], after.point, &format!("of φ, up to {:.3}°", degrees(after.phi))));
        }
        if let Some(k) = (0..n).find(|&k| !(steps[k] > 0.0)) {
            let beside: Vec<usize> = (n + k - 2..=n + k + 3).map(|j| order[j % n]).collect();
            let (i, message) = backwards(self.plan, self.outwards(), found, &beside);
            let (phi, i) = (degrees(found[i].phi), found[i].point);
            let message = format!("at φ = {phi:.3}°, {}, {message}", placed(self.points[i]));
            return Err(Refusal::at(self.rows[i], message, ORDER));
        }
        Ok((order, steps))
    }

    /// dU over the coordinate of the follower.
    fn transmission(&self) -> f64 {
        if let Carrier::Lever { transmission, .. } = self.plan.carrier { transmission } else { 1.0 }
    }

    /// The coordinate of the follower at U = 0, if these are its least and largest one.
    fn start(&self, range: [f64; 2]) -> Result<f64, Refusal> {
        let start = match self.plan.start {
            Start::Coordinate(start) => return Ok(start),
            Start::Prime(radius) => known(self.plan, radius)?,
            Start::Base(radius) => known(self.plan, radius + self.plan.roller)?,
        };
        let [low, high] = range;
        if !((low - start).abs() <= SIZE * (high - low)) {
            let nearest = millimetres(self.points.iter().map(|c| c.norm()).fold(f64::INFINITY, f64::min));
            let message = format!(
                "the least radius of the contour is {nearest}, which `base_radius` or `prime_radius` does not fit"
            );
            let hint = "correct one of them, the unit of the points or the radius of the roller";
            return Err(Refusal::at(None, message, hint));
        }
        // If the tool moves against the arm, its least U belongs to the largest coordinate.
        Ok(if self.transmission() < 0.0 { high } else { start })
    }

    /// The law through these contacts from the angle `first` on.
    fn law(&self, contacts: &Contacts, first: f64, start: f64) -> Traced {
        let Contacts { list: found, noise, open, bend_open, .. } = contacts;
        let per = self.transmission();
        let pair = |i: usize| (first + (found[i].phi - first).rem_euclid(TAU), per * (found[i].coordinate - start), i);
        let mut pairs: Vec<(f64, f64, usize)> = (0..found.len()).map(pair).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (angles, lifts) = pairs.iter().map(|(angle, lift, _)| (*angle, *lift)).unzip();
        let bends = pairs.iter().filter_map(|(.., i)| found[*i].bend).collect();
        let rows = pairs.iter().map(|(.., i)| self.rows[found[*i].point]).collect();
        Traced {
            points: Points { angles, lifts },
            bends,
            rows,
            noise: *noise,
            open: *open,
            bend_open: *bend_open,
            start,
        }
    }

    /// Moves the contacts of a roller to those of its cam with the normals of this one.
    fn touch_again(&self, found: &mut [Contact], cam: &Cam) {
        for (i, contact) in found.iter_mut().enumerate() {
            let turned = |phi: f64| Point::from_polar(1.0, self.plan.sense * phi);
            let Ok(at) = cam.at(contact.phi.rem_euclid(TAU)) else { continue };
            if let Ok((phi, coordinate, _)) = self.place(i, self.points[i], turned(at.phi).conj() * at.normal) {
                *contact = Contact { phi, coordinate, ..*contact };
            }
        }
    }

    /// The refusal of a contour that a flat face cannot follow at this point.
    fn dented(&self, i: usize) -> Refusal {
        let n = self.points.len();
        let [before, own, after] = [i + n - 1, i, i + 1].map(|i| self.points[i % n]);
        let [arriving, leaving] = [own - before, after - own];
        let turn = (leaving / arriving).arg() * (after / before).arg().signum();
        let radius = 0.5 * (arriving.norm() + leaving.norm()) / turn.abs();
        let what = if radius > STRAIGHT * own.norm() || turn > 0.0 {
            "the contour is straight: a flat face touches all of it at one angle, at which U′ jumps".to_owned()
        } else {
            let radius = millimetres(radius);
            format!(
                "the contour is undercut: it bends inwards with a radius of {radius}, which a flat face cannot follow"
            )
        };
        let normal = if (own * (-I * leaving).conj()).re > 0.0 { -I * leaving } else { I * leaving };
        let phi = degrees(self.plan.sense * (I * normal.conj()).arg());
        Refusal::at(self.rows[i], format!("at φ = {phi:.1}°, {}, {what}", placed(own)), ORDER)
    }
}

fn placed(point: Point) -> String {
    format!("{} and {} in x and y", millimetres(point.re), millimetres(point.im))
}

/// The contacts of a flat face, the largest uncertainty of the contour with the point before it, and the uncertainty of U″ as a
/// part of its largest value.
fn below_face(sense: f64, points: &[Point], left: bool) -> Result<(Vec<Contact>, (f64, usize), f64), usize> {
    let last = points.len() - 1;
    let of = |i: usize| if left { i } else { last - i };
    let in_order: Vec<Point> = (0..=last).map(|i| points[of(i)]).collect();
    let (touches, open, bend) = flat::touches(&in_order).map_err(of)?;
    let contact = |touch: &flat::Touch| {
        let (phi, [coordinate, slope], [mut before, mut behind]) = touch.contact(sense);
        // θ falls while the cam turns counter-clockwise.
        if sense > 0.0 {
            (before, behind) = (behind, before);
        }
        let bend = Some(Bend { slope, before, behind });
        Contact { phi, coordinate, curvature: touch.curvatures[0], point: of(touch.index), bend }
    };
    let most = (0..=last).max_by(|a, b| open[*a].total_cmp(&open[*b])).unwrap_or(0);
    let mut contacts: Vec<Contact> = touches.iter().map(contact).collect();
    if !left {
        contacts.reverse();
    }
    Ok((contacts, (open[most], of(most)), bend))
}

/// The one of these points at which the follower would have to turn back, and the reason.
fn backwards(plan: &Plan, outwards: f64, found: &[Contact], beside: &[usize]) -> (usize, String) {
    let sign = if outwards < 0.0 { -1.0 } else { 1.0 };
    let bend = |i: usize| sign * found[i].curvature;
    let sharpest = beside.iter().copied().min_by(|a, b| bend(*a).total_cmp(&bend(*b))).unwrap_or(0);
    let (flat, curvature) = (plan.carrier == Carrier::Flat, found[sharpest].curvature);
    if !(if flat { curvature < 0.0 } else { outwards * curvature < -0.5 }) {
        return (beside[beside.len() / 2], "the points do not follow each other around the cam".to_owned());
    }
    let radius = millimetres(1.0 / curvature.abs());
    let what = match flat {
        true => "a flat face".to_owned(),
        false => format!("a roller with a radius of {}", millimetres(plan.roller)),
    };
    (sharpest, format!("the contour is undercut: it bends with a radius of {radius}, which {what} cannot follow"))
}

/// The steps of an angle around the turn, one of which may be wider than half of it.
fn steps(differences: impl Iterator<Item = f64>) -> Vec<f64> {
    /// The least part of the turn outside the widest gap (rad).
    const REST: f64 = 0.3;
    let mut steps: Vec<f64> = differences.map(|step| (step + PI).rem_euclid(TAU) - PI).collect();
    let sum = steps.iter().sum::<f64>();
    if let Some(widest) = steps.iter_mut().max_by(|a, b| a.abs().total_cmp(&b.abs()))
        && sum.abs() < 1.0
        && widest.abs() > REST
    {
        *widest -= TAU * widest.signum();
    }
    steps
}

/// The step that leaves out a part of the turn.
fn gap(steps: &[f64]) -> Option<usize> {
    let (n, width) = (steps.len(), |k: usize| steps[k % steps.len()].abs());
    (0..n)
        .find(|&k| width(k) > GAP.0 && (width(k) > FRAC_PI_4 || width(k) > GAP.1 * width(k + 1).max(width(k + n - 1))))
}

fn known(plan: &Plan, distance: f64) -> Result<f64, Refusal> {
    plan.coordinate_at(distance).map_err(|fault| Refusal::at(None, fault.to_string(), "choose other lengths"))
}

/// The points without those that repeat the one before, such as a closing point, and the angles 2π (sum of chords)/(length).
fn around(contour: &[Point]) -> Result<(Vec<usize>, Vec<f64>), Refusal> {
    let n = contour.len();
    let few = |n: usize| {
        Refusal::at(
            None,
            format!("a contour of {n} points"),
            format!("measure at least {LEAST} points of the whole turn"),
        )
    };
    if n < LEAST {
        return Err(few(n));
    }
    let chord = |i: usize| (contour[(i + 1) % n] - contour[i]).norm();
    let length: f64 = (0..n).map(chord).sum();
    let mut chords: Vec<f64> = (0..n).map(chord).collect();
    chords.sort_by(f64::total_cmp);
    let closed = chord(n - 1) < 0.25 * chords[n / 2];
    let rows: Vec<usize> = (0..n - usize::from(closed)).filter(|&i| i == 0 || chord(i - 1) > 1e-6 * length).collect();
    if rows.len() < LEAST {
        return Err(few(rows.len()));
    }
    let ends = rows.iter().zip(rows.iter().skip(1).chain([&rows[0]]));
    let chords: Vec<f64> = ends.map(|(a, b)| (contour[*b] - contour[*a]).norm()).collect();
    let length: f64 = chords.iter().sum();
    let sums = chords.iter().scan(0.0, |sum, chord| Some(std::mem::replace(sum, *sum + TAU * chord / length)));
    Ok((rows, sums.collect()))
}

/// A coordinate of the contour over the sum of its chords, without noise; the normals of the result are accurate enough.
fn smoothed(
    angles: &[f64],
    values: impl Iterator<Item = f64>,
    noise: Option<Option<f64>>,
) -> Result<MotionLaw, Refusal> {
    let mut points = Points { angles: angles.to_vec(), lifts: values.collect() };
    points.angles.push(TAU);
    points.lifts.push(points.lifts[0]);
    let refuse = |message: String| Refusal::at(None, message, "check the unit of the points and `noise`");
    if let Some(sigma) = noise {
        match smooth(points.clone(), sigma, Outliers::DropOfCurve, &[]) {
            Ok(smooth) => points = smooth.points,
            Err(SmoothingError::NoNoise) => {}
            Err(_) => return Err(refuse("this noise leaves nothing of the contour".to_owned())),
        }
    }
    Table::new(points).map(MotionLaw::Table).map_err(|fault| refuse(told(&fault)))
}

impl Traced {
    /// The distances of the points from the contour of the follower of `plan` with this law: their root mean square and the
    /// largest (m).
    pub fn misfit(&self, plan: &Plan, law: &MotionLaw, contour: &[Point]) -> [f64; 2] {
        let (cam, side) = (plan.with(law.clone(), self.start), plan.cut.sides()[0]);
        let off = self.rows.iter().zip(&self.points.angles).filter_map(|(row, phi)| {
            let at = cam.at(*phi).ok()?;
            Some((*row, ((contour[*row] - side.point(&cam, &at)) * (I * at.tangent).conj()).re.abs()))
        });
        // A corner between points has no point of its own; it is listed with a neighbour.
        let mut nearest: BTreeMap<usize, f64> = BTreeMap::new();
        off.for_each(|(row, off)| {
            nearest.entry(row).and_modify(|least| *least = least.min(off)).or_insert(off);
        });
        let (sum, largest) =
            nearest.values().fold((0.0, 0.0), |(sum, largest): (f64, f64), off| (sum + off * off, largest.max(*off)));
        [(sum / nearest.len() as f64).sqrt(), largest]
    }

    /// The law through the points; None if they are no table.
    pub fn law(&self) -> Option<MotionLaw> {
        let (points, bends) = (self.points.clone(), self.bends.clone());
        let table = if bends.is_empty() { Table::new(points) } else { Table::bent(points, bends) };
        table.ok().map(MotionLaw::Table)
    }

    /// With corners at the jumps of U″.
    fn cornered(mut self) -> Self {
        let corners = corners(&self.points);
        if !corners.is_empty()
            && let Some(cornered) = Corners::new(&self.points, &corners)
        {
            self.rows = cornered.rows.iter().map(|row| self.rows[*row]).collect();
            (self.points, self.bends) = (cornered.points, cornered.bends);
        }
        self
    }
}

/// Third differences across a jump of U″ are this many times those on both sides of it.
const JUMP: f64 = 6.0;

/// A jump below this part of the stroke per square of the points' distance is ignored: the spline across it is accurate to
/// 1e-7.
const SMALL: f64 = 5e-6;

/// The angles at which U″ jumps, with the jumps: there the polynomials of degree 4 through the points on both sides touch.
fn corners(points: &Points) -> Vec<(f64, f64)> {
    let n = points.angles.len();
    let angle = |i: usize| points.angles[i % n] + TAU * (i / n) as f64;
    // The Taylor coefficients up to order 2 about φ of the polynomial through these points, and the highest divided difference.
    let polynomial = |first: usize, count: usize, phi: f64| {
        let mut d: Vec<f64> = (first..first + count).map(|i| points.lifts[i % n]).collect();
        for k in 1..count {
            (k..count).rev().for_each(|j| d[j] = (d[j] - d[j - 1]) / (angle(first + j) - angle(first + j - k)));
        }
        let newton = |[a, b, c]: [f64; 3], j: usize| {
            let x = phi - angle(first + j);
            [a * x + d[j], b * x + a, c * x + b]
        };
        ((0..count).rev().fold([0.0; 3], newton), d[count - 1])
    };
    let stroke = [f64::max, f64::min].map(|of| points.lifts.iter().copied().reduce(of).unwrap_or(0.0));
    let stroke = stroke[0] - stroke[1];
    let third: Vec<f64> = (0..n).map(|i| polynomial(i, 4, angle(i)).1.abs()).collect();
    let beside = |i: usize| {
        [3, 4, 5, 6].into_iter().flat_map(move |k| [i + k, i + n - k]).map(|j| third[j % n]).fold(0.0, f64::max)
    };
    let high: Vec<bool> = (0..n).map(|i| third[i] > JUMP * beside(i)).collect();
    let mut list = Vec::new();
    for first in (n..2 * n).filter(|i| high[i % n] && !high[(i - 1) % n]) {
        let last = (first..first + n).take_while(|i| high[i % n]).last().unwrap_or(first);
        let ends = [angle(first + 1), angle(last + 2)];
        // A jump near a point affects one of three differences little; the point may be on either side.
        let near = usize::from(last < first + 2);
        let between = |phi: f64| {
            let [left, right] = [first - 2 - near, last + 1 + near].map(|first| polynomial(first, 5, phi).0);
            [0, 1, 2].map(|k| right[k] - left[k])
        };
        let mut at = 0.5 * (ends[0] + ends[1]);
        for _ in 0..8 {
            let [_, slope, bend] = between(at);
            at = (at - 0.5 * slope / bend).clamp(ends[0], ends[1]);
        }
        let nearest = (first..=last + 3).min_by(|a, b| (angle(*a) - at).abs().total_cmp(&(angle(*b) - at).abs()));
        let width = (ends[1] - ends[0]) / (last + 1 - first) as f64;
        // A corner this close to a point is in the point.
        let near = nearest.filter(|&i| (angle(i) - at).abs() < 0.02 * width);
        at = near.map_or(at, angle);
        let [apart, _, bend] = between(at);
        if apart.abs() < 0.1 * bend.abs() * width * width && bend.abs() * width * width > SMALL * stroke {
            let first = points.angles[0];
            list.push((near.map_or(first + (at - first).rem_euclid(TAU), |i| points.angles[i % n]), 2.0 * bend));
        }
    }
    list
}
