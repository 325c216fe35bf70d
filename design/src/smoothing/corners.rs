//! The spline through points with jumps of U″ at known angles.
//!
//! If U″ jumps by J, the spline is that of U − J b(φ) plus J b, with b periodic and b″ = ½ − φ/2π after the jump. The
//! difference is smooth, so this spline does not overshoot.

use super::Jump;
use camdrive::motion::table::{Bend, Points};
use camdrive::motion::{MotionLaw, Table};
use std::f64::consts::TAU;

/// Rows on each side of a jump that confirm it.
const ROWS: i64 = 4;

/// A jump is certain if the largest error of these rows, each from the spline without it and every second one, is this many
/// times less with the jump than the third of the errors without it: exact rows have more than 200, and short ramps of smooth
/// laws at most 1.
const FACTOR: f64 = 3.0;

/// A jump this close to a row, as a part of a gap, is in the row: this changes U″ by less than this part of the jump.
const IN_ROW: f64 = 5e-3;

/// Points with additional ones at jumps of U″.
#[derive(Clone, Debug, PartialEq)]
pub struct Corners {
    /// The points.
    pub points: Points,
    /// U′ and U″ of the points.
    pub bends: Vec<Bend>,
    /// The original point of each, or the point before which it is inserted.
    pub rows: Vec<usize>,
}

/// b, b′, b″ after a corner; in the corner the values after it.
fn unit(phi: f64, at: f64) -> [f64; 3] {
    let x = (phi - at).rem_euclid(TAU) / TAU;
    [TAU * TAU * x * (x / 4.0 - x * x / 6.0 - 1.0 / 12.0), TAU * (0.5 * x * (1.0 - x) - 1.0 / 12.0), 0.5 - x]
}

fn sum(corners: &[(f64, f64)], phi: f64, order: usize) -> f64 {
    corners.iter().map(|(at, jump)| jump * unit(phi, *at)[order]).sum()
}

/// The law without its jumps; None if the points are no table.
fn rest(mut points: Points, corners: &[(f64, f64)]) -> Option<MotionLaw> {
    points.angles.iter().zip(&mut points.lifts).for_each(|(phi, lift)| *lift -= sum(corners, *phi, 0));
    Table::new(points).map(MotionLaw::Table).ok()
}

impl Corners {
    /// Points whose U″ jumps at angles within a turn of the first one by these amounts; None if they are no table.
    pub fn new(points: &Points, corners: &[(f64, f64)]) -> Option<Self> {
        let rest = rest(points.clone(), corners)?;
        let (mut points, mut rows) = (points.clone(), (0..points.angles.len()).collect::<Vec<_>>());
        for &(at, _) in corners {
            let i = points.angles.partition_point(|phi| *phi < at);
            if points.angles.get(i) != Some(&at) {
                points.angles.insert(i, at);
                points.lifts.insert(i, rest.at(at).0[0] + sum(corners, at, 0));
                rows.insert(i, rows[i.min(rows.len() - 1)]);
            }
        }
        let bend = |phi: &f64| {
            let ([_, slope, bend, ..], jump) = (rest.at(*phi).0, corners.iter().find(|(at, _)| at == phi));
            let behind = bend + sum(corners, *phi, 2);
            Bend { slope: slope + sum(corners, *phi, 1), before: behind - jump.map_or(0.0, |(_, jump)| *jump), behind }
        };
        let bends = points.angles.iter().map(bend).collect();
        Some(Corners { points, bends, rows })
    }
}

/// The jumps of U″ among these that the rows on both sides confirm; those close to a row are moved into it.
pub fn certain(points: &Points, jumps: &[Jump]) -> Vec<Jump> {
    let Ok(points) = points.clone().open() else { return Vec::new() };
    let n = points.angles.len();
    let angle = |i: i64| points.angles[i.rem_euclid(n as i64) as usize] + TAU * i.div_euclid(n as i64) as f64;
    let next = |at: f64| points.angles.partition_point(|phi| *phi < at) as i64;
    let in_row = |mut jump: Jump| {
        let i = next(jump.angle);
        let near = |i: &i64| (angle(*i) - jump.angle).abs() <= IN_ROW * (angle(i + 1) - angle(i - 1)) / 2.0;
        jump.angle = [i - 1, i].into_iter().find(near).map_or(jump.angle, |i| angle(i.rem_euclid(n as i64)));
        jump
    };
    let jumps: Vec<Jump> = jumps.iter().filter(|jump| jump.order == 2).copied().map(in_row).collect();
    let corners: Vec<(f64, f64)> = jumps.iter().map(|jump| (jump.angle, jump.by)).collect();
    let beside = |jump: &Jump| {
        let i = next(jump.angle);
        (i - ROWS..i + ROWS).map(|row| row.rem_euclid(n as i64) as usize)
    };
    // The errors of the rows next to jumps from the spline without every second one of them.
    let errors = |corners: &[(f64, f64)]| {
        let mut errors = vec![f64::NAN; n];
        for parity in [0, 1] {
            let mut kept = vec![true; n];
            jumps.iter().flat_map(beside).filter(|row| row % 2 == parity).for_each(|row| kept[row] = false);
            let rows = || (0..n).filter(|row| kept[*row]);
            let mut others = Points {
                angles: rows().map(|row| points.angles[row]).collect(),
                lifts: rows().map(|row| points.lifts[row]).collect(),
            };
            others.angles.push(others.angles[0] + TAU);
            others.lifts.push(others.lifts[0]);
            let rest = rest(others, corners)?;
            for row in (0..n).filter(|row| !kept[*row]) {
                let phi = points.angles[row];
                errors[row] = (rest.at(phi).0[0] + sum(corners, phi, 0) - points.lifts[row]).abs();
            }
        }
        Some(errors)
    };
    let Some((with, without)) = errors(&corners).zip(errors(&[])) else { return Vec::new() };
    let confirmed = |jump: &Jump| {
        let [mut with, mut without] =
            [&with, &without].map(|errors| beside(jump).map(|row| errors[row]).collect::<Vec<f64>>());
        [&mut with, &mut without].into_iter().for_each(|errors| errors.sort_by(|a, b| b.total_cmp(a)));
        without[2] >= FACTOR * with[0]
    };
    jumps.iter().filter(|jump| confirmed(jump)).copied().collect()
}
