//! The conditions that a task makes: equations of the exact points, sums of squares, and what holds at every angle.

use super::exact::{Solutions, dot};
use super::family::Family;
use super::feasibility::KEPT;
use super::sampling::{ANGLES, within};
use super::{Bound, Infeasible, Objective, Point, Polynomial, Range, Task, grid};
use camdrive::numerics::double_double::Double;
use camdrive::numerics::gauss::Gauss;
use std::f64::consts::{PI, TAU};

/// Points per shortest wave of the basis at which the discrete objectives S2 and S4 look by default.
const POINTS_PER_WAVE: f64 = 12.0;

impl Task {
    /// The magnitude of U in the task, in units of which the equations are solved.
    pub(super) fn scale(&self) -> f64 {
        let of_range = |r: &Range| {
            let size = |order: usize| {
                let p = r.prescribed[order].as_ref()?;
                Some(grid(r.from, r.to, 16).map(|phi| p.at(phi - r.from).abs()).fold(0.0, f64::max))
            };
            (0..3).filter_map(size).fold(0.0, f64::max)
        };
        let ranges = self.ranges.iter().map(of_range);
        let points = self.points.iter().map(|p| p.value.abs());
        let bounds = self.bounds.iter().flat_map(|b| [b.min.abs(), b.max.abs()]).filter(|v| v.is_finite());
        let scale = ranges.chain(points).chain(bounds).fold(0.0, f64::max);
        if scale > 0.0 { scale } else { 1.0 }
    }

    /// What fulfils the exact conditions, checked for contradictions.
    pub(super) fn equalities(&self, scale: f64) -> Result<Solutions, Infeasible> {
        let rows: Vec<Vec<Double>> = self.points.iter().map(|p| self.basis.row(p.phi, p.order, None)).collect();
        let values: Vec<Double> =
            self.points.iter().map(|p| Double::from(p.value).divide(Double::from(scale))).collect();
        // The rows of U⁽ⁿ⁾ are of the size Kⁿ, and the rounding of an angle leaves them uncertain by this part of it.
        let highest = self.basis.order().max(1) as f64;
        let unknown = highest * ANGLES;
        let size = |i: usize| highest.powi(self.points[i].order as i32);
        // A row that vanishes is a condition that the symmetry fulfils by itself, or that nothing can fulfil.
        let vanishes = |i: usize| rows[i].iter().all(|value| value.hi.abs() <= unknown * size(i));
        let unit =
            |i: usize| if vanishes(i) { Double::default() } else { Double::from(1.0).divide(Double::from(size(i))) };
        let alike: Vec<Vec<Double>> =
            (0..rows.len()).map(|i| rows[i].iter().map(|value| *value * unit(i)).collect()).collect();
        let right: Vec<Double> = (0..rows.len()).map(|i| values[i] * unit(i)).collect();
        let solutions = Solutions::new(&alike, &right, self.basis.size(), unknown);
        let miss = |i: usize| (dot(&rows[i], &solutions.particular) - values[i]).hi.abs();
        let relative = |i: usize| miss(i) / size(i);
        let worst = (0..rows.len()).max_by(|i, j| relative(*i).total_cmp(&relative(*j)));
        match worst {
            // Some thousand roundings of the angles and values; a contradiction is of the size of the task.
            Some(i) if relative(i) > 1e-12 => Err(Infeasible::Point { index: i, by: miss(i) * scale }),
            _ => self.points_outside(scale).map_or(Ok(solutions), Err),
        }
    }

    /// The point that is furthest beyond a bound of the same derivative, if one is.
    fn points_outside(&self, scale: f64) -> Option<Infeasible> {
        let beyond = |point: &Point, bound: &Bound| {
            let phi = within(bound.from, bound.to, point.phi).filter(|_| bound.order == point.order)?;
            let value = point.value - bound.around.at(phi - bound.from);
            Some((value - bound.max).max(bound.min - value)).filter(|by| *by > KEPT * scale)
        };
        let pairs = self.points.iter().enumerate().flat_map(|(i, point)| {
            let of = move |(j, bound)| Some((i, j, beyond(point, bound)?));
            self.bounds.iter().enumerate().filter_map(of)
        });
        let furthest = pairs.max_by(|a, b| a.2.total_cmp(&b.2));
        furthest.map(|(point, bound, by)| Infeasible::Outside { point, bound, by })
    }

    /// The conditions of the least-squares objectives, weighted, and their right-hand sides. For the other objectives
    /// they give the start; that of the peak of acceleration is the least mean square of the acceleration.
    pub(super) fn samples(&self, scale: f64) -> (Vec<Vec<Double>>, Vec<Double>) {
        let turn = Range { from: 0.0, to: TAU, prescribed: [None, None, Some(Polynomial::default())], weight: 1.0 };
        let (ranges, weights) = match self.objective {
            Objective::PeakAcceleration => (std::slice::from_ref(&turn), [0.0, 1.0]),
            _ => (&self.ranges[..], self.weights),
        };
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        for range in ranges {
            let nodes = match self.objective {
                Objective::DiscreteLeastSquares { points } | Objective::DiscreteChebyshev { points } => {
                    let points = self.points_in(range, points);
                    grid(range.from, range.to, points).map(|phi| (phi, 1.0)).collect()
                }
                _ => gauss_nodes(range.from, range.to, self.basis.order()),
            };
            for (order, target) in range.prescribed.iter().enumerate() {
                let Some(target) = target else { continue };
                let weight = if order == 0 { 1.0 } else { weights[order - 1] };
                for &(phi, share) in nodes.iter().filter(|_| weight > 0.0) {
                    let root = Double::from((range.weight * weight * share).sqrt());
                    let value = target.exactly_at(Double::from(phi) - Double::from(range.from));
                    rows.push(self.basis.row(phi, order, None).into_iter().map(|v| v * root).collect());
                    values.push(value.divide(Double::from(scale)) * root);
                }
            }
        }
        (rows, values)
    }

    fn points_in(&self, range: &Range, points: usize) -> usize {
        let default = POINTS_PER_WAVE * self.basis.order() as f64 * (range.to - range.from) / TAU;
        // A range much shorter than a wave still has to tell the functions apart.
        if points > 0 { points } else { (default.ceil() as usize).max(2 * self.basis.size()) }
    }

    /// The weight of e₁ or e₂ in the maxima.
    fn weight(&self, order: usize) -> f64 {
        if order == 0 { 1.0 } else { self.weights[order - 1] }
    }

    /// What the profile is optimised under, with the level of the objective.
    pub(super) fn families(&self, scale: f64) -> Vec<Family> {
        let mut families = Vec::new();
        for (index, bound) in self.bounds.iter().enumerate() {
            for (sign, limit) in [(1.0, bound.max), (-1.0, -bound.min)] {
                if limit.is_finite() {
                    let mut family = Family::new(bound.from, bound.to);
                    family.set(bound.order, sign, &bound.around, scale);
                    family.limit = limit / scale;
                    family.bound = Some(index);
                    families.push(family);
                }
            }
        }
        match self.objective {
            Objective::LeastSquares
            | Objective::DiscreteLeastSquares { .. }
            | Objective::PeakTorque
            | Objective::ShaftTorque(_) => {}
            Objective::PeakAcceleration => {
                for sign in [1.0, -1.0] {
                    let mut family = Family::new(0.0, TAU);
                    family.set(2, sign, &Polynomial::default(), scale);
                    family.level = 1.0;
                    families.push(family);
                }
            }
            Objective::Chebyshev | Objective::DiscreteChebyshev { .. } => {
                for range in &self.ranges {
                    for (order, target) in range.prescribed.iter().enumerate() {
                        let Some(target) = target.as_ref().filter(|_| self.weight(order) != 0.0) else { continue };
                        for sign in [1.0, -1.0] {
                            let mut family = Family::new(range.from, range.to);
                            family.set(order, sign * self.weight(order) * range.weight, target, scale);
                            family.level = 1.0;
                            if let Objective::DiscreteChebyshev { points } = self.objective {
                                family.points = Some(self.points_in(range, points));
                            }
                            families.push(family);
                        }
                    }
                }
            }
            Objective::ChebyshevSum => {
                for range in &self.ranges {
                    // A sum with a derivative of no weight would be there twice.
                    let counts = |&n: &usize| range.prescribed[n].is_some() && self.weight(n) != 0.0;
                    let orders: Vec<usize> = (0..3).filter(counts).collect();
                    // |e₀| + w₁|e₁| + w₂|e₂| is the largest of the sums with all combinations of signs.
                    for signs in 0..1_u32 << orders.len() {
                        let mut family = Family::new(range.from, range.to);
                        for (i, &order) in orders.iter().enumerate() {
                            let sign = if signs >> i & 1 == 0 { 1.0 } else { -1.0 };
                            let target = range.prescribed[order].as_ref().expect("filtered");
                            family.set(order, sign * self.weight(order) * range.weight, target, scale);
                        }
                        family.level = 1.0;
                        families.push(family);
                    }
                }
            }
        }
        families
    }
}

/// Angles and weights of a quadrature over [from, to] that is exact to rounding for products of two waves of
/// harmonic ≤ `order`.
fn gauss_nodes(from: f64, to: f64, order: usize) -> Vec<(f64, f64)> {
    // Sixteen nodes on a panel of length h are exact for cos 2Kφ to (K h/2)³²/32! < 1e-19 where K h ≤ π.
    let panels = ((to - from) * order.max(1) as f64 / PI).ceil().max(1.0);
    let length = (to - from) / panels;
    let rule = Gauss::with(16).nodes::<16>(length);
    (0..panels as usize).flat_map(|i| rule.map(|[s, weight]| (from + i as f64 * length + s, weight))).collect()
}
