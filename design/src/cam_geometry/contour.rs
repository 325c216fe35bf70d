//! Contours as polygons, as fine as a chord error demands.

use super::{Cam, CamPosition, Follower, Point, Standstill};
use camdrive::drives::Fault;
use serde::Serialize;
use std::f64::consts::TAU;

/// The side of the path of the roller's centre on which a contour lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Towards the cam's centre: a disc cam.
    Inner,
    /// Away from it: the outer flank of a groove.
    Outer,
    /// The path of the roller's centre itself.
    Path,
}

/// A closed polygon; the last point is not repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The side of this contour.
    pub side: Side,
    /// Its points with the angle φ at which each is in contact.
    pub points: Vec<(f64, Point)>,
}

/// The angles at which a cam is calculated: the same for the path of the roller's centre and all contours.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The cam at each angle, ascending from φ = 0.
    pub at: Vec<CamPosition>,
    /// The largest distance of a curve from its chords (m), at three places between neighbours.
    pub chord_error: f64,
}

/// The turn is divided at least this often, and so often for the shortest wave of the law, so that the three places between
/// neighbours miss no bump.
const LEAST: [f64; 2] = [180.0, 8.0];

/// An interval is halved at most this often: 1e-9 of a turn.
const HALVINGS: usize = 22;

/// The most points of a contour; programs for the workshop take some ten thousand.
const MOST_POINTS: usize = 200_000;

impl Side {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Side::Inner => "inner contour",
            Side::Outer => "outer contour",
            Side::Path => "path of the roller's centre",
        }
    }

    /// +1 if the contour lies to the left of the path. A cam that turns counter-clockwise (σ = 1) sees the roller run around it
    /// clockwise, and its centre to the right.
    pub fn sign(self, sense: f64) -> f64 {
        match self {
            Side::Inner => -sense,
            Side::Outer => sense,
            Side::Path => 0.0,
        }
    }

    /// The point of this contour.
    pub fn point(self, cam: &Cam, at: &CamPosition) -> Point {
        at.centre + Point::new(0.0, self.sign(cam.sense) * cam.roller) * at.tangent
    }

    /// 1 − (±ϱ) κ: if it is positive, the contour moves along with the path; otherwise it is undercut.
    pub fn growth(self, cam: &Cam, at: &CamPosition) -> f64 {
        1.0 - self.sign(cam.sense) * cam.roller * at.curvature
    }

    /// The radius of a cylinder that touches a plane as closely as the roller or face touches the contour; negative at an
    /// undercut.
    pub fn closeness(self, cam: &Cam, at: &CamPosition) -> f64 {
        match cam.follower {
            Follower::Flat { .. } => -cam.sense / self.curvature(cam, at),
            _ => cam.roller * self.growth(cam, at),
        }
    }

    /// The signed curvature of the contour (1/m), positive to the left in the sense of its path.
    pub fn curvature(self, cam: &Cam, at: &CamPosition) -> f64 {
        at.curvature / self.growth(cam, at)
    }
}

/// The pieces of the turn from 0 to 2π on which the law is smooth: first angle, last angle, segment.
pub fn pieces(cam: &Cam) -> Vec<(f64, f64, usize)> {
    let borders = cam.law.breakpoints();
    let Some((first, last)) = borders.first().zip(borders.last()) else { return vec![(0.0, TAU, 0)] };
    let around = borders.len() - 1;
    let before = (*first > 0.0).then_some((0.0, *first, around));
    let within = (0..around).map(|i| (borders[i], borders[i + 1], i));
    before.into_iter().chain(within).chain([(*last, TAU, around)]).collect()
}

/// The reason why there is no mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoMesh {
    /// The contour has no direction.
    Standstill(Standstill),
    /// The chord error demands too many points.
    TooFine,
}

impl From<Standstill> for NoMesh {
    fn from(standstill: Standstill) -> Self {
        NoMesh::Standstill(standstill)
    }
}

impl From<NoMesh> for Fault {
    fn from(reason: NoMesh) -> Self {
        match reason {
            NoMesh::Standstill(standstill) => standstill.into(),
            NoMesh::TooFine => Fault::new(format!(
                "this chord error needs more than {MOST_POINTS} points for a contour; choose a larger one"
            )),
        }
    }
}

/// The curves of a cam to divide.
struct Curves<'a> {
    cam: &'a Cam,
    sides: &'a [Side],
    segment: usize,
    tolerance: f64,
}

impl Mesh {
    /// The angles at which chords stay within `tolerance` (m) of the path of the roller's centre and of the contours on these
    /// sides.
    ///
    /// # Errors
    /// A roller's centre that stands still on the cam, and a chord error that needs too many points.
    pub fn new(cam: &Cam, sides: &[Side], tolerance: f64) -> Result<Mesh, NoMesh> {
        let mut mesh = Mesh { at: Vec::new(), chord_error: 0.0 };
        let sides: Vec<Side> = sides.iter().copied().chain([Side::Path]).collect();
        for (from, to, segment) in pieces(cam) {
            let curves = Curves { cam, sides: &sides, segment, tolerance };
            let waves = f64::max(LEAST[0], LEAST[1] * cam.law.resolution_in(segment));
            let n = ((waves * (to - from) / TAU).ceil() as usize).max(2);
            let mut before = cam.at_in(segment, from)?;
            for i in 1..=n {
                let next = cam.at_in(segment, from + (to - from) * i as f64 / n as f64)?;
                mesh.push(before)?;
                mesh.refine(&curves, before, next, HALVINGS)?;
                before = next;
            }
        }
        Ok(mesh)
    }

    fn push(&mut self, at: CamPosition) -> Result<(), NoMesh> {
        self.at.push(at);
        if self.at.len() > MOST_POINTS { Err(NoMesh::TooFine) } else { Ok(()) }
    }

    /// Puts angles between two of them until all chords are near enough.
    fn refine(
        &mut self,
        curves: &Curves<'_>,
        from: CamPosition,
        to: CamPosition,
        halvings: usize,
    ) -> Result<(), NoMesh> {
        let between = |part: f64| curves.cam.at_in(curves.segment, from.phi + part * (to.phi - from.phi));
        let looks = [between(0.25)?, between(0.5)?, between(0.75)?];
        let mut error: f64 = 0.0;
        for side in curves.sides {
            let point = |at: &CamPosition| side.point(curves.cam, at);
            error = looks.iter().map(|at| distance(point(at), point(&from), point(&to))).fold(error, f64::max);
        }
        if error <= curves.tolerance || halvings == 0 {
            self.chord_error = self.chord_error.max(error);
            return Ok(());
        }
        self.refine(curves, from, looks[1], halvings - 1)?;
        self.push(looks[1])?;
        self.refine(curves, looks[1], to, halvings - 1)
    }

    /// The polygon on this side.
    pub fn outline(&self, cam: &Cam, side: Side) -> Outline {
        Outline { side, points: self.at.iter().map(|at| (at.phi, side.point(cam, at))).collect() }
    }
}

/// The distance of a point from the line between two others.
pub fn distance(point: Point, from: Point, to: Point) -> f64 {
    let chord = to - from;
    let length = chord.norm();
    if length == 0.0 {
        return (point - from).norm();
    }
    let along = ((chord.conj() * (point - from)).re / (length * length)).clamp(0.0, 1.0);
    (point - from - chord * along).norm()
}
