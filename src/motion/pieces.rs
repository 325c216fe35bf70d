//! Analytic pieces of the turn, from which cycles and motion plans are made.

use super::turn::{back, near, reduce, segment};
use super::{StandardLaw, TransferFunctions};
use std::f64::consts::{PI, TAU};

/// Rounding error of an angle (rad); shorter pieces are dropped.
pub const ROUNDING: f64 = 1e-12;

/// The number of coefficients of a polynomial: degree 7 meets position, velocity, acceleration and jerk at both ends.
pub const COEFFICIENTS: usize = 8;

/// g(z) of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// g = 0.
    Straight,
    /// This analytic part of a standard law.
    Law(StandardLaw, usize),
    /// g = Σ cₖ zᵏ from z = −½ to ½: about the middle of a piece the coefficients are small, and so are the roundings.
    Polynomial([f64; COEFFICIENTS]),
    /// g = Σ aᵢ (1 − cos iπz), i = 1, 2, 3.
    Cosines([f64; 3]),
}

/// U(φ) = base + slope (φ − origin) + height (g(z) − level), z = (φ − origin)/width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// The angle at which z = 0 (rad).
    pub origin: f64,
    /// The angle over which z runs from 0 to 1 (rad); negative if it runs backwards.
    pub width: f64,
    /// U (m) at the origin or, if `level` is 1, at the end.
    pub base: f64,
    /// g there, 0 or 1.
    pub level: f64,
    /// U′ at the origin (m/rad), where g′ = 0.
    pub slope: f64,
    /// The factor of g (m).
    pub height: f64,
    /// g.
    pub shape: Shape,
}

impl Form {
    /// U = Σ cₖ zᵏ, z = (φ − `from`)/`width` from 0 to 1.
    pub fn polynomial(from: f64, width: f64, c: &[f64; COEFFICIENTS]) -> Self {
        let shape = Shape::Polynomial(shifted(c, 0.5));
        Form { origin: from + 0.5 * width, width, base: 0.0, level: 0.0, slope: 0.0, height: 1.0, shape }
    }

    /// U = `base` + `slope` (φ − `origin`).
    pub fn straight(origin: f64, base: f64, slope: f64) -> Self {
        Form { origin, width: 1.0, base, level: 0.0, slope, height: 0.0, shape: Shape::Straight }
    }
}

/// A form on its part of the turn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    form: Form,
    /// The middle of the piece (rad), within half a turn of 0 like most angles.
    middle: f64,
    /// φ − origin at both ends (rad).
    reach: [f64; 2],
}

/// The pieces around the turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Pieces {
    breakpoints: Vec<f64>,
    pieces: Vec<Piece>,
}

impl Pieces {
    /// A follower at rest.
    pub fn at_rest(level: f64) -> Self {
        Pieces::new(vec![([0.0, TAU], Form::straight(0.0, if level.is_finite() { level } else { 0.0 }, 0.0))])
    }

    /// Pieces from forms, each from one angle to another (rad); they cover the turn once, wherever it begins.
    pub fn new(forms: Vec<([f64; 2], Form)>) -> Self {
        let mut starts = Vec::new();
        for ([from, to], form) in forms {
            if to - from > ROUNDING {
                let (middle, reach) = (0.5 * (from + to), [from - form.origin, to - form.origin]);
                let turns = (middle / TAU).round();
                let form = Form { origin: back(form.origin, turns), ..form };
                starts.push((reduce(from), Piece { form, middle: back(middle, turns), reach }));
            }
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (breakpoints, pieces) = starts.into_iter().unzip();
        Pieces { breakpoints, pieces }
    }

    /// The starts of the pieces (rad), ascending in [0, 2π).
    pub fn breakpoints(&self) -> &[f64] {
        &self.breakpoints
    }

    /// The piece that holds `phi`; see [`super::MotionLaw::segment`].
    pub fn segment(&self, phi: f64, forward: bool) -> usize {
        segment(&self.breakpoints, phi, forward)
    }

    fn piece(&self, segment: usize) -> &Piece {
        &self.pieces[segment.min(self.pieces.len() - 1)]
    }

    /// U … U⁗ of piece `segment` at `phi`, continued analytically outside of it.
    pub fn at_in(&self, segment: usize, phi: f64) -> TransferFunctions {
        let Piece { form: Form { origin, width, base, level, slope, height, shape }, middle, .. } =
            *self.piece(segment);
        let angle = near(phi, middle) - origin;
        let g = match shape {
            Shape::Straight => return TransferFunctions([base + slope * angle, slope, 0.0, 0.0, 0.0]),
            Shape::Law(law, part) => law.at_in(part, angle / width),
            Shape::Polynomial(c) => std::array::from_fn(|order| polynomial(&c, order, angle / width)),
            Shape::Cosines(a) => std::array::from_fn(|order| cosines(&a, order, angle / width)),
        };
        let r = 1.0 / width;
        let s1 = height * r;
        let s2 = s1 * r;
        let s3 = s2 * r;
        TransferFunctions([
            base + slope * angle + height * (g[0] - level),
            slope + s1 * g[1],
            s2 * g[2],
            s3 * g[3],
            s3 * r * g[4],
        ])
    }

    /// The Taylor coefficients of piece `segment` about `phi`; see [`super::MotionLaw::expand`].
    pub fn expand(&self, segment: usize, phi: f64, step: f64, coefficients: &mut [f64]) {
        let Piece { form: Form { origin, width, base, level, slope, height, shape }, middle, .. } =
            *self.piece(segment);
        let angle = near(phi, middle) - origin;
        let mut taylor = |derivative: &dyn Fn(usize, f64) -> f64| {
            let mut factor = 1.0;
            for (n, coefficient) in coefficients.iter_mut().enumerate() {
                *coefficient = factor * derivative(n, angle / width);
                factor *= step / width / (n + 1) as f64;
            }
        };
        match shape {
            Shape::Straight => coefficients.fill(0.0),
            Shape::Law(law, part) => law.expand(part, angle / width, step / width, coefficients),
            Shape::Polynomial(c) => taylor(&|order, z| polynomial(&c, order, z)),
            Shape::Cosines(a) => taylor(&|order, z| cosines(&a, order, z)),
        }
        coefficients[0] -= level;
        for c in &mut *coefficients {
            *c *= height;
        }
        coefficients[0] += base + slope * angle;
        coefficients[1] += slope * step;
    }

    /// An upper bound of |U⁽ᵒʳᵈᵉʳ⁾| in piece `segment`, order ≤ 4.
    pub fn bound_in(&self, segment: usize, order: usize) -> f64 {
        let Piece { form: Form { width, base, level, slope, height, shape, .. }, reach, .. } = *self.piece(segment);
        let straight = |part: f64| match order {
            0 => base + slope * part - height * level,
            1 => slope,
            _ => 0.0,
        };
        let scaled = |g: f64| height * g / width.powi(order as i32);
        // g and g′ of a standard law are not negative, its higher derivatives have either sign.
        let [least, greatest] = match shape {
            Shape::Straight => [0.0, 0.0],
            Shape::Law(law, _) => [if order < 2 { 0.0 } else { -law.peak(order) }, law.peak(order)],
            Shape::Polynomial(c) => range(&c, order),
            Shape::Cosines(a) => {
                let each = |least: f64| {
                    (1..)
                        .zip(a)
                        .map(|(i, a)| a * (f64::from(i) * PI).powi(order as i32))
                        .map(move |a| if order == 0 { 2.0 * (least * a).max(0.0) } else { a.abs() })
                };
                [-each(-1.0).sum::<f64>(), each(1.0).sum()]
            }
        };
        let ends = reach.map(straight);
        ends.into_iter().flat_map(|end| [end + scaled(least), end + scaled(greatest)]).fold(0.0, |m, u| m.max(u.abs()))
    }

    /// The harmonic order that resolves piece `segment`.
    pub fn resolution_in(&self, segment: usize) -> f64 {
        let Form { width, shape, .. } = self.piece(segment).form;
        match shape {
            Shape::Straight => 1.0,
            Shape::Law(law, _) => law.frequency() / width.abs(),
            // Like the polynomials among the standard laws.
            Shape::Polynomial(_) => PI / width.abs(),
            Shape::Cosines(_) => 3.0 * PI / width.abs(),
        }
    }
}

/// g⁽ᵒʳᵈᵉʳ⁾(z) of g = Σ cₖ zᵏ.
fn polynomial(c: &[f64; COEFFICIENTS], order: usize, z: f64) -> f64 {
    (order..COEFFICIENTS).rev().fold(0.0, |sum, k| sum * z + falling(k, order) * c[k])
}

/// g⁽ᵒʳᵈᵉʳ⁾(z) of g = Σ aᵢ (1 − cos iπz).
fn cosines(a: &[f64; 3], order: usize, z: f64) -> f64 {
    let term = |(i, a): (i32, &f64)| {
        let (sin, cos) = (f64::from(i) * PI * z).sin_cos();
        match order {
            0 => a * (1.0 - cos),
            n => -a * (f64::from(i) * PI).powi(n as i32) * [cos, -sin, -cos, sin][n % 4],
        }
    };
    (1..).zip(a).map(term).sum()
}

/// The coefficients of g(z + `shift`).
fn shifted(c: &[f64; COEFFICIENTS], shift: f64) -> [f64; COEFFICIENTS] {
    std::array::from_fn(|n| polynomial(c, n, shift) / falling(n, n))
}

/// k (k − 1) … (k − n + 1).
fn falling(k: usize, n: usize) -> f64 {
    (k - n + 1..=k).map(|i| i as f64).product()
}

/// Bounds of g⁽ᵒʳᵈᵉʳ⁾ on [−½, ½] by its coefficients bₘ = Σ C(m, k)/C(n, k) cₖ in Bernstein's form.
fn range(c: &[f64; COEFFICIENTS], order: usize) -> [f64; 2] {
    let c = shifted(c, -0.5);
    let n = COEFFICIENTS - 1 - order;
    let bernstein = (0..=n).map(|m| {
        let term = |k: usize| falling(m, k) / falling(n, k) * falling(k + order, order) * c[k + order];
        (0..=m).map(term).sum::<f64>()
    });
    bernstein.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], b| [least.min(b), greatest.max(b)])
}
