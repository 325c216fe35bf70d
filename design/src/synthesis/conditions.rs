//! The conditions that a task makes: equations of the exact points, sums of squares, and what holds at every angle.

use super::exact::{Solutions, dot};
use super::family::{Family, Term};
use super::feasibility::KEPT;
use super::sampling::{ANGLES, within};
use super::{Bound, Curve, ExactPoint, Infeasible, Objective, Range, Task};
use camdrive::numerics::double_double::Double;
use camdrive::numerics::gauss::Gauss;
use std::f64::consts::{PI, TAU};

/// Rows and right-hand sides of a sum of squares |A x − b|².
pub type Squares = (Vec<Vec<Double>>, Vec<Double>);

/// The conditions of a task.
#[derive(Clone, Copy)]
pub struct Conditions<'a> {
    /// The task.
    pub task: &'a Task,
    /// Its magnitude, in units of which the equations are solved.
    pub scale: f64,
}

impl<'a> Conditions<'a> {
    /// Those of this task.
    pub fn new(task: &'a Task) -> Self {
        Conditions { task, scale: task.scale() }
    }

    /// All x that fulfil the exact conditions, checked for contradictions.
    pub fn equalities(&self) -> Result<Solutions, Infeasible> {
        let rows: Vec<Vec<Double>> =
            self.task.points.iter().map(|p| self.task.basis.row(p.law, p.phi, p.order, None)).collect();
        let values: Vec<Double> =
            self.task.points.iter().map(|p| Double::from(p.value).divide(Double::from(self.scale))).collect();
        // The rows of U⁽ⁿ⁾ are of the size Kⁿ, and the rounding of an angle leaves them uncertain by this part of it.
        let highest = self.task.basis.order().max(1) as f64;
        let unknown = highest * ANGLES;
        let size = |i: usize| highest.powi(self.task.points[i].order as i32);
        // A row that vanishes is a condition that the symmetry fulfils by itself, or that nothing can fulfil.
        let vanishes = |i: usize| rows[i].iter().all(|value| value.hi.abs() <= unknown * size(i));
        let unit =
            |i: usize| if vanishes(i) { Double::default() } else { Double::from(1.0).divide(Double::from(size(i))) };
        let alike: Vec<Vec<Double>> =
            (0..rows.len()).map(|i| rows[i].iter().map(|value| *value * unit(i)).collect()).collect();
        let right: Vec<Double> = (0..rows.len()).map(|i| values[i] * unit(i)).collect();
        let solutions = Solutions::new(&alike, &right, self.task.basis.size(), unknown);
        let miss = |i: usize| (dot(&rows[i], &solutions.particular) - values[i]).hi.abs();
        let relative = |i: usize| miss(i) / size(i);
        let worst = (0..rows.len()).max_by(|i, j| relative(*i).total_cmp(&relative(*j)));
        match worst {
            // Some thousand roundings of the angles and values; a contradiction is of the size of the task.
            Some(i) if relative(i) > 1e-12 => Err(Infeasible::Point { index: i, by: miss(i) * self.scale }),
            _ => self.points_outside().map_or(Ok(solutions), Err),
        }
    }

    /// The point that is furthest beyond a bound of the same derivative, if one is.
    fn points_outside(&self) -> Option<Infeasible> {
        let beyond = |point: &ExactPoint, bound: &Bound| {
            let same = bound.order == point.order && bound.of == [(point.law, 1.0)];
            let phi = within(bound.from, bound.to, point.phi).filter(|_| same)?;
            let value = point.value - bound.around.at(phi - bound.from);
            Some((value - bound.max).max(bound.min - value)).filter(|by| *by > KEPT * self.scale)
        };
        let pairs = self.task.points.iter().enumerate().flat_map(|(i, point)| {
            let of = move |(j, bound)| Some((i, j, beyond(point, bound)?));
            self.task.bounds.iter().enumerate().filter_map(of)
        });
        let furthest = pairs.max_by(|a, b| a.2.total_cmp(&b.2));
        furthest.map(|(point, bound, by)| Infeasible::Outside { point, bound, by })
    }

    /// The conditions of the least-squares objectives, weighted, and their right-hand sides. For the other objectives
    /// they give the start; for the peak of acceleration it is the least mean square of the acceleration.
    pub fn samples(&self) -> Squares {
        match self.task.objective {
            Objective::PeakAcceleration | Objective::MeanSquareAcceleration => self.accelerations(),
            _ => self.errors(),
        }
    }

    /// Σ wⱼ ∫ Uⱼ″² dφ over the turn.
    pub fn accelerations(&self) -> Squares {
        let still = || [None, None, Some(Curve::default())];
        let turn =
            |(law, weight): (usize, &f64)| Range { law, from: 0.0, to: TAU, prescribed: still(), weight: *weight };
        let turns: Vec<Range> = self.task.laws.iter().enumerate().map(turn).collect();
        self.squares(&turns, [0.0, 1.0])
    }

    /// Σ ∫ (e₀² + w₁ e₁² + w₂ e₂²) dφ over the ranges of the task.
    pub fn errors(&self) -> Squares {
        self.squares(&self.task.ranges, self.task.weights)
    }

    /// The same over these ranges.
    fn squares(&self, ranges: &[Range], weights: [f64; 2]) -> Squares {
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        for range in ranges {
            for (order, target) in range.prescribed.iter().enumerate() {
                let Some(target) = target else { continue };
                let weight = if order == 0 { 1.0 } else { weights[order - 1] };
                let nodes = match range.from == range.to {
                    true => vec![(range.from, 1.0)],
                    false => gauss_nodes(range.from, range.to, self.task.basis.order().max(target.order())),
                };
                for &(phi, share) in nodes.iter().filter(|_| weight > 0.0) {
                    let root = Double::from((range.weight * weight * share).sqrt());
                    let value = target.exactly_at(Double::from(phi) - Double::from(range.from));
                    rows.push(self.task.basis.row(range.law, phi, order, None).into_iter().map(|v| v * root).collect());
                    values.push(value.divide(Double::from(self.scale)) * root);
                }
            }
        }
        (rows, values)
    }

    /// The weight of e₁ or e₂ in the maxima.
    fn weight(&self, order: usize) -> f64 {
        if order == 0 { 1.0 } else { self.task.weights[order - 1] }
    }

    /// Conditions under which the profile is optimised, with the level of the objective.
    pub fn families(&self) -> Vec<Family> {
        let mut families = Vec::new();
        for (index, bound) in self.task.bounds.iter().enumerate() {
            families.extend(bound.sides(self.scale).map(|side| side.of_bound(index)));
        }
        match self.task.objective {
            Objective::LeastSquares
            | Objective::MeanSquareAcceleration
            | Objective::PeakTorque
            | Objective::ShaftTorque(_) => return families,
            Objective::PeakAcceleration => families.extend(self.peaks()),
            _ => {}
        }
        let ranges = self.task.ranges.iter().filter(|_| self.task.objective != Objective::PeakAcceleration);
        for range in ranges {
            // A sum with a derivative of no weight would be there twice.
            let counts = |&n: &usize| range.prescribed[n].is_some() && self.weight(n) != 0.0;
            let orders: Vec<usize> = (0..3).filter(counts).collect();
            // Each error by itself, or their sum |e₀| + w₁|e₁| + w₂|e₂|: the largest one with all combinations of signs.
            let together = if self.task.objective == Objective::ChebyshevSum { 3 } else { 1 };
            for orders in orders.chunks(together) {
                for signs in 0..1_u32 << orders.len() {
                    let mut family = Family::new(range.from, range.to);
                    for (i, &order) in orders.iter().enumerate() {
                        let sign = if signs >> i & 1 == 0 { 1.0 } else { -1.0 };
                        let target = range.prescribed[order].as_ref().expect("filtered");
                        let factor = sign * self.weight(order) * range.weight;
                        family.add(Term { law: range.law, order, factor }, target, self.scale);
                    }
                    family.level = 1.0;
                    families.push(family);
                }
            }
        }
        families
    }

    /// |Uⱼ″| ≤ tⱼ, Σ wⱼ tⱼ ≤ t: the tⱼ of all laws but the last are numbers of the program next to the coefficients, since
    /// the law with the smaller peak would be open if only the larger one counted.
    fn peaks(&self) -> Vec<Family> {
        let last = self.task.laws.len() - 1;
        let of = |law: usize, sign: f64| {
            let mut family = Family::new(0.0, TAU);
            if law < last {
                family.terms.push(Term { law, order: 2, factor: sign });
                family.terms.push(Term { law: last + 1 + law, order: 0, factor: -1.0 });
                return family;
            }
            family.terms.push(Term { law, order: 2, factor: sign * self.task.laws[law] });
            let peak = |j: usize| Term { law: last + 1 + j, order: 0, factor: self.task.laws[j] };
            family.terms.extend((0..last).map(peak));
            family.level = 1.0;
            family
        };
        (0..=last).flat_map(|law| [1.0, -1.0].map(|sign| of(law, sign))).collect()
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
