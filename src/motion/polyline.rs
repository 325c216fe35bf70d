//! Points joined by straight lines or by monotone curves, with steps: a force, a torque, an inertia over the turn.
//!
//! Between neighbouring points U is linear, or a cubic that does not leave their range. The slope of a cubic at a point is the
//! weighted harmonic mean of the slopes of the lines on both sides, and zero if these differ in sign (PCHIP). Two points at one
//! angle are a step, and so is a closing point, one turn after the first, with another value. Next to a step a cubic has the slope
//! of its line. Every point is a breakpoint: U′ of lines, U″ of cubics and U of a step jump there.
//!
//! Source: F. N. Fritsch, J. Butland, A method for constructing local monotone piecewise cubic interpolants, SIAM J. Sci. Stat.
//! Comput. 5 (1984), 300–304.

use super::pieces::{Form, Pieces};
use super::points::{CLOSING, Points, TableError};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The points with the lines between them, times a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Data", into = "Data")]
pub struct Polyline {
    points: Points,
    scale: f64,
    monotone: bool,
    pub(super) pieces: Pieces,
}

/// The serialised form of a [`Polyline`].
#[derive(Serialize, Deserialize)]
struct Data {
    points: Points,
    scale: f64,
    monotone: bool,
}

impl TryFrom<Data> for Polyline {
    type Error = TableError;
    fn try_from(data: Data) -> Result<Self, TableError> {
        let mut polyline = Polyline::through(data.points, data.monotone)?;
        polyline.set_scale(data.scale);
        Ok(polyline)
    }
}

impl From<Polyline> for Data {
    fn from(Polyline { points, scale, monotone, .. }: Polyline) -> Self {
        Data { points, scale, monotone }
    }
}

impl Polyline {
    /// The lines through `points`, at least two of them, scale 1.
    pub fn new(points: Points) -> Result<Self, TableError> {
        Polyline::through(points, false)
    }

    /// The monotone curves through `points`, at least two of them, scale 1.
    pub fn monotone(points: Points) -> Result<Self, TableError> {
        Polyline::through(points, true)
    }

    fn through(points: Points, monotone: bool) -> Result<Self, TableError> {
        points.check(true)?;
        let mut polyline = Polyline { points, scale: 1.0, monotone, pieces: Pieces::at_rest(0.0) };
        polyline.set_scale(1.0);
        Ok(polyline)
    }

    /// Whether cubics join the points instead of lines.
    pub fn is_monotone(&self) -> bool {
        self.monotone
    }

    /// The least value of the points; no piece falls below it.
    pub fn least(&self) -> f64 {
        self.points.lifts.iter().map(|lift| self.scale * lift).fold(f64::INFINITY, f64::min)
    }

    /// The points as given, without `scale`.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// The factor of the values (1).
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// 1 over the least distance of neighbouring points (1/rad), steps not counted.
    pub(super) fn finest(&self) -> f64 {
        let widths = self.points.angles.windows(2).map(|pair| pair[1] - pair[0]);
        widths.filter(|width| *width > 0.0).fold(0.0, |finest, width| f64::max(finest, 1.0 / width))
    }

    /// Changes the factor.
    pub fn set_scale(&mut self, scale: f64) {
        let Points { angles, lifts } = &self.points;
        let (end, last) = (angles[0] + TAU, angles[angles.len() - 1]);
        // A closing point may be off by the printed digits of angles.
        let place = |angle: f64| if angle == last && end - last <= CLOSING { end } else { angle };
        let mut ends: Vec<_> = angles.iter().zip(lifts).map(|(&angle, &value)| [place(angle), scale * value]).collect();
        ends.push([end, scale * lifts[0]]);
        let lines: Vec<[[f64; 2]; 2]> =
            ends.windows(2).map(|ends| [ends[0], ends[1]]).filter(|[from, to]| to[0] > from[0]).collect();
        let n = lines.len();
        let form = |(i, &[[from, low], [to, high]]): (usize, &[[f64; 2]; 2])| {
            let width = to - from;
            let form = if self.monotone {
                let [start, stop] =
                    [slope(&lines[(i + n - 1) % n], &lines[i], 1), slope(&lines[i], &lines[(i + 1) % n], 0)];
                let (rise, start, stop) = (high - low, width * start, width * stop);
                let c = [low, start, 3.0 * rise - 2.0 * start - stop, start + stop - 2.0 * rise, 0.0, 0.0, 0.0, 0.0];
                Form::polynomial(from, width, &c)
            } else {
                Form::straight(from, low, (high - low) / width)
            };
            // The angles within half a turn of the middle of a piece belong to it: a whole turn would leave its ends to roundings.
            let middle = if width > PI { 0.5 * (from + to) } else { to };
            [([from, middle], form), ([middle, to], form)].into_iter().filter(|([from, to], _)| to > from)
        };
        let pieces = Pieces::new(lines.iter().enumerate().flat_map(form).collect());
        (self.scale, self.pieces) = (scale, pieces);
    }
}

/// U′ at the point between two neighbouring lines; next to a step the slope of line `own` of the two.
fn slope(before: &[[f64; 2]; 2], behind: &[[f64; 2]; 2], own: usize) -> f64 {
    let lines = [before, behind];
    let widths = lines.map(|[from, to]| to[0] - from[0]);
    let [first, second] = [0, 1].map(|i| (lines[i][1][1] - lines[i][0][1]) / widths[i]);
    if before[1][1] != behind[0][1] {
        return [first, second][own];
    }
    if first * second <= 0.0 {
        return 0.0;
    }
    let weights = [widths[0] + 2.0 * widths[1], 2.0 * widths[0] + widths[1]];
    (weights[0] + weights[1]) / (weights[0] / first + weights[1] / second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::MotionLaw;

    fn law(angles: &[f64], values: &[f64]) -> Result<Polyline, TableError> {
        Polyline::new(Points { angles: angles.to_vec(), lifts: values.to_vec() })
    }

    /// A press: nothing up to 330°, then a step and a ramp, a plateau, and a ramp back.
    fn press() -> Polyline {
        let angles = [0.0_f64, 330.0, 330.0, 345.0, 356.0, 360.0].map(f64::to_radians);
        law(&angles, &[0.0, 0.0, -2e4, -9e4, -9e4, 0.0]).unwrap()
    }

    #[test]
    fn lines_join_the_points_and_a_step_has_a_value_on_either_side() {
        let law = MotionLaw::Polyline(press());
        let step = 330.0_f64.to_radians();
        // The long line is cut in two.
        assert_eq!(law.breakpoints().len(), 5);
        let at = |deg: f64| law.at(deg.to_radians()).0;
        let slope = 7e4 / 15.0_f64.to_radians();
        for (deg, u, u1) in [
            (10.0, 0.0, 0.0),
            (-30.0 + 1e-9, -2e4, -slope),
            (337.5, -5.5e4, -slope),
            (350.0, -9e4, 0.0),
            (358.0, -4.5e4, 9e4 / 4.0_f64.to_radians()),
        ] {
            let found = at(deg);
            assert!((found[0] - u).abs() < 1e-5 && (found[1] - u1).abs() < 1e-7, "{deg}: {found:?}");
            assert_eq!(found[2..], [0.0; 3]);
        }
        for turns in [-1.0, 0.0] {
            let [before, behind] = [false, true]
                .map(|forward| law.at_in(law.segment(step + turns * TAU, forward), step + turns * TAU).0[0]);
            assert!(before == 0.0 && (behind + 2e4).abs() < 1e-9);
        }
        let bounds = [9e4, 9e4 / 4.0_f64.to_radians(), 0.0, 0.0, 0.0];
        (0..5).for_each(|n| assert!((law.bound(n) / bounds[n] - 1.0).abs() < 1e-9 || law.bound(n) == bounds[n]));
        let mut c = [1.0; 6];
        law.expand(law.segment(5.9, true), 5.9, 0.1, &mut c);
        assert!((c[0] - law.at(5.9).0[0]).abs() < 1e-10 && (c[1] + 0.1 * slope).abs() < 1e-8 && c[2..] == [0.0; 4]);
        // By trapezoids: no work between 0° and 330°.
        let work: f64 = (0..36000).map(|i| at(0.01 * (f64::from(i) + 0.5))[0] * 0.01_f64.to_radians()).sum();
        let exact = -(5.5e4 * 15.0 + 9e4 * 11.0 + 4.5e4 * 4.0_f64) * 1.0_f64.to_radians();
        assert!((work / exact - 1.0).abs() < 1e-12, "{work} {exact}");
    }

    #[test]
    fn monotone_curves_are_those_of_fritsch_and_butland_and_never_leave_the_range_of_their_points() {
        // Slopes of scipy.interpolate.PchipInterpolator at the inner points of x = 0, 1, 1.5, 3, 4, y = 0, 2, 2.5, 8, 8.
        let points =
            |values: [f64; 5]| law_of(&[0.5, 1.5, 2.0, 3.5, 4.5, 0.5 + TAU], &[&values[..], &[values[0]]].concat());
        let curve = MotionLaw::Polyline(points([0.0, 2.0, 2.5, 8.0, 8.0]));
        for (phi, slope) in [(1.5, 9.0 / 7.0), (2.0, 1.434_782_608_695_652), (3.5, 0.0), (4.5, 0.0), (0.5, 0.0)] {
            for forward in [false, true] {
                let [_, found, ..] = curve.at_in(curve.segment(phi, forward), phi).0;
                assert!((found - slope).abs() < 1e-13, "{phi}: {found}");
            }
        }
        // The least lift of the curve is the lift of its least point.
        for k in 0..2000 {
            let (phi, knots) = (0.5 + TAU * f64::from(k) / 2000.0, [0.5, 1.5, 2.0, 3.5, 4.5, 0.5 + TAU]);
            let i = knots.partition_point(|knot| *knot <= phi).clamp(1, 5);
            let ends: [f64; 6] = [0.0, 2.0, 2.5, 8.0, 8.0, 0.0];
            let (low, high) = (ends[i - 1].min(ends[i]), ends[i - 1].max(ends[i]));
            let [u, ..] = curve.at(phi).0;
            assert!(u >= low - 1e-13 && u <= high + 1e-13, "{phi}: {u}");
        }
        // Next to a step the curve has the slope of its line, and it is that line if another step follows.
        let press = Polyline::monotone(press().points).unwrap();
        let stepped = MotionLaw::Polyline(press);
        let step = 330.0_f64.to_radians();
        let behind = stepped.at_in(stepped.segment(step, true), step).0;
        assert!((behind[0] + 2e4).abs() < 1e-8 && (behind[1] + 7e4 / 15.0_f64.to_radians()).abs() < 1e-6);
        assert_eq!(stepped.at_in(stepped.segment(step, false), step).0[..2], [0.0, 0.0]);
        let saw =
            MotionLaw::Polyline(Polyline::monotone(Points { angles: vec![0.0, TAU], lifts: vec![0.0, 3.0] }).unwrap());
        assert!((saw.at(1.0).0[0] - 3.0 / TAU).abs() < 1e-15);
    }

    fn law_of(angles: &[f64], values: &[f64]) -> Polyline {
        Polyline::monotone(Points { angles: angles.to_vec(), lifts: values.to_vec() }).unwrap()
    }

    #[test]
    fn the_turn_closes_by_a_line_or_by_a_step_wherever_the_points_begin() {
        // Without a closing point a line leads around the turn.
        let open = MotionLaw::Polyline(law(&[1.0, 3.0, 5.0], &[2.0, -2.0, 0.0]).unwrap());
        let back = 2.0 / (TAU - 4.0);
        assert!(
            (open.at(5.5).0[0] - 0.5 * back).abs() < 1e-15 && (open.at(0.5).0[0] - (2.0 - 0.5 * back)).abs() < 1e-14
        );
        // A saw, given from 90° to 450°: it steps from 3 to 1 at 90°.
        let quarter = 0.25 * TAU;
        for end in [quarter + TAU, quarter + TAU - 1e-5, quarter + TAU + 1e-5] {
            let saw = MotionLaw::Polyline(law(&[quarter, end], &[1.0, 3.0]).unwrap());
            assert_eq!((saw.breakpoints().len(), saw.at(quarter).0[0]), (2, 1.0));
            let before = saw.at_in(saw.segment(quarter, false), quarter + TAU - 1e-9).0[0];
            assert!((saw.at(quarter + 0.5 * TAU).0[0] - 2.0).abs() < 1e-14 && (before - 3.0).abs() < 1e-9);
        }
        // Both sides of the step at the first angle may stand at either end.
        let same = [
            law(&[0.0, 3.0, TAU], &[1.0, 2.0, 5.0]),
            law(&[0.0, 3.0, TAU, TAU], &[1.0, 2.0, 5.0, 1.0]),
            law(&[0.0, 0.0, 3.0, TAU], &[5.0, 1.0, 2.0, 5.0]),
        ]
        .map(|law| MotionLaw::Polyline(law.unwrap()));
        for phi in [0.0, 1.0, 4.0, 6.2] {
            assert_eq!([0, 1, 2].map(|i: usize| same[i].at(phi)), [same[0].at(phi); 3]);
        }
    }

    #[test]
    fn points_that_can_be_read_two_ways_are_refused() {
        use TableError::*;
        assert!(matches!(law(&[0.0], &[1.0]), Err(TooFew { points: 1 })));
        assert!(matches!(law(&[0.0, 0.0], &[1.0, 2.0]), Err(TooFew { points: 1 })));
        assert!(matches!(law(&[0.0, 2.0, 2.0, 2.0, 4.0], &[1.0; 5]), Err(NotAscending { index: 3, .. })));
        assert!(matches!(law(&[0.0, 2.0, 2.0 + 1e-7, 4.0], &[1.0; 4]), Err(NotAscending { index: 2, .. })));
        assert!(matches!(law(&[0.0, 2.0, 1.0, 4.0], &[1.0; 4]), Err(NotAscending { index: 2, .. })));
        assert!(matches!(law(&[0.0, 3.0, 7.0], &[1.0; 3]), Err(TooLong { index: 2, .. })));
        assert!(matches!(law(&[0.0, 1.0, 2.0], &[1.0; 3]), Err(NotClosed { index: 2, .. })));
        assert!(matches!(law(&[0.0, 3.0], &[1.0, 2e12]), Err(OutOfRange { index: 1, .. })));
        assert!(matches!(law(&[0.0, 3.0], &[1.0, f64::NAN]), Err(OutOfRange { index: 1, .. })));
        // Three values at the first angle.
        assert!(matches!(law(&[0.0, 3.0, TAU, TAU], &[1.0, 2.0, 3.0, 4.0]), Err(NotPeriodic { index: 3, .. })));
        assert!(matches!(law(&[0.0, 0.0, 3.0, TAU], &[1.0, 2.0, 3.0, 4.0]), Err(NotPeriodic { index: 3, .. })));
    }
}
