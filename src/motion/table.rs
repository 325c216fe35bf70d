//! A table of angles and lifts as the periodic quintic spline through its points.
//!
//! The quintic spline has the least ∫U‴² dφ of all periodic functions through the points, the least jerk of a cam. It is the lowest
//! odd degree whose third derivative is continuous (an even degree has no periodic interpolant for every number of points); the
//! fourth is continuous too, and the fifth jumps at the points. The error of U⁽ⁿ⁾ is O(h⁶⁻ⁿ) for a smooth law sampled at distance
//! h.
//!
//! If U′ and U″ of the points are known too, each piece is the quintic through them, and U″ may jump at a point.
//!
//! Source: C. de Boor, *A Practical Guide to Splines*, rev. ed., Springer 2001, chapters V and XIII.

use super::TransferFunctions;
pub use super::points::{Bend, CLOSING, LEAST_DISTANCE, LEAST_POINTS, MOST_POINTS, Points, TableError};
use super::spline::Spline;
pub use super::spline::within;
use super::turn::segment;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A table as the periodic quintic spline through its points, times a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TableData", into = "TableData")]
pub struct Table {
    spline: Arc<Spline>,
    /// Factor of the lift (1).
    pub scale: f64,
}

/// The serialised form of a [`Table`].
#[derive(Clone, Debug, Serialize, Deserialize)]
struct TableData {
    angles: Vec<f64>,
    lifts: Vec<f64>,
    /// Empty if the derivatives follow from the points.
    #[serde(default)]
    bends: Vec<Bend>,
    scale: f64,
}

impl TryFrom<TableData> for Table {
    type Error = TableError;
    fn try_from(data: TableData) -> Result<Self, TableError> {
        let mut points = Points { angles: data.angles, lifts: data.lifts };
        // The points of a table cover the turn, however far the first one is from the last one.
        if let (Some(angle), Some(lift)) = (points.angles.first().copied(), points.lifts.first().copied()) {
            points.angles.push(angle + TAU);
            points.lifts.push(lift);
        }
        let table = if data.bends.is_empty() { Table::new(points) } else { Table::bent(points, data.bends) }?;
        Ok(Table { scale: data.scale, ..table })
    }
}

impl From<Table> for TableData {
    fn from(table: Table) -> Self {
        let Points { angles, lifts } = table.spline.points.clone();
        TableData { angles, lifts, bends: table.spline.bends.clone(), scale: table.scale }
    }
}

impl Table {
    /// The spline through `points`, scale 1.
    pub fn new(points: Points) -> Result<Self, TableError> {
        Ok(Table { spline: Arc::new(Spline::new(points.open()?, Vec::new())), scale: 1.0 })
    }

    /// The pieces of degree 5 through `points` with these derivatives, one for each point; a closing point's may be left out. Scale
    /// 1.
    pub fn bent(points: Points, mut bends: Vec<Bend>) -> Result<Self, TableError> {
        let points = points.open()?;
        bends.truncate(points.angles.len());
        if bends.len() != points.angles.len() {
            return Err(TableError::Lengths { angles: points.angles.len(), lifts: bends.len() });
        }
        let beyond = |bend: &Bend| [bend.slope, bend.before, bend.behind].iter().any(|d| !d.is_finite());
        if let Some(index) = bends.iter().position(beyond) {
            return Err(TableError::OutOfRange { index, value: f64::NAN });
        }
        Ok(Table { spline: Arc::new(Spline::new(points, bends)), scale: 1.0 })
    }

    /// The spline through `points` that rests, U′ = U″ = 0, at the points with these indices; between two of them with the same
    /// lift it is constant. Scale 1.
    pub fn resting(points: Points, at_rest: &[usize]) -> Result<Self, TableError> {
        let points = points.open()?;
        let bends = Spline::resting(&points, at_rest);
        Ok(Table { spline: Arc::new(Spline::new(points, bends)), scale: 1.0 })
    }

    /// The points, without a closing one and without `scale`.
    pub fn points(&self) -> &Points {
        &self.spline.points
    }

    /// U′ and U″ of the points if they are given, without `scale`; empty if they are interpolated.
    pub fn bends(&self) -> &[Bend] {
        &self.spline.bends
    }

    /// Whether U′ and U″ of the points are given instead of interpolated.
    pub fn is_bent(&self) -> bool {
        !self.spline.bends.is_empty()
    }

    /// The angles of the points (rad), ascending in [0, 2π).
    pub fn breakpoints(&self) -> &[f64] {
        &self.spline.knots
    }

    /// The piece that holds `phi`; see [`super::MotionLaw::segment`].
    pub fn segment(&self, phi: f64, forward: bool) -> usize {
        segment(&self.spline.knots, phi, forward)
    }

    /// U … U⁗ of piece `segment` at `phi`, continued as the same polynomial outside of it.
    pub fn at_in(&self, segment: usize, phi: f64) -> TransferFunctions {
        TransferFunctions(self.spline.piece(segment).at(phi).map(|u| self.scale * u))
    }

    /// The Taylor coefficients of piece `segment` about `phi`; see [`super::MotionLaw::expand`].
    pub fn expand(&self, segment: usize, phi: f64, step: f64, coefficients: &mut [f64]) {
        coefficients.fill(0.0);
        coefficients[..5].copy_from_slice(&self.at_in(segment, phi).0);
        coefficients[5] = self.scale * self.spline.piece(segment).fifth();
        let mut factor = 1.0;
        for (n, c) in coefficients[..6].iter_mut().enumerate().skip(1) {
            factor *= step / n as f64;
            *c *= factor;
        }
    }

    /// 1 over the least distance of neighbouring points (1/rad).
    pub fn finest(&self) -> f64 {
        self.spline.finest()
    }

    /// An upper bound of |U⁽ᵒʳᵈᵉʳ⁾| in piece `segment`.
    pub fn bound_in(&self, segment: usize, order: usize) -> f64 {
        self.scale.abs() * self.spline.piece(segment).bound(order)
    }

    /// An upper bound of |U⁽ᵒʳᵈᵉʳ⁾| over the turn.
    pub fn bound(&self, order: usize) -> f64 {
        self.scale.abs() * self.spline.bounds[order]
    }
}

#[cfg(test)]
mod tests;
