//! An output between two communication points: the quintic polynomial with its values and first two derivatives at both.
//!
//! For f with six continuous derivatives the largest error over a step h is h⁶ max |f⁽⁶⁾| / 46080 (P. J. Davis, *Interpolation and
//! Approximation*, Dover 1975, section 3.5, theorem 3.5.1: six conditions, three at each end).

/// The value of an output with its first two derivatives by time.
pub type Jet = [f64; 3];

/// The polynomial in Bernstein's form: its control values over [0, 1] of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece(pub [f64; 6]);

/// Nodes and weights of Gauss's rule of six points over [0, 1]: exact to degree 11, so for the square of a piece.
pub const GAUSS: [[f64; 2]; 6] = [
    [0.033765242898423986, 0.08566224618958517],
    [0.16939530676686774, 0.18038078652406930],
    [0.38069040695840155, 0.23395696728634552],
    [0.61930959304159845, 0.23395696728634552],
    [0.83060469323313226, 0.18038078652406930],
    [0.96623475710157601, 0.08566224618958517],
];

impl Piece {
    /// The piece over a step of this length (s), from the data at its ends.
    pub fn new([f, df, ddf]: Jet, [g, dg, ddg]: Jet, step: f64) -> Self {
        let (slope, bend) = (step / 5.0, step * step / 20.0);
        let near = |f: f64, slope: f64, bend: f64| [f, f + slope, f + 2.0 * slope + bend];
        let [a, b, c] = near(f, slope * df, bend * ddf);
        let [d, e, g] = near(g, -slope * dg, bend * ddg);
        Piece([a, b, c, g, e, d])
    }

    /// The same value throughout.
    pub fn constant(value: f64) -> Self {
        Piece([value; 6])
    }

    /// The straight line between two values.
    pub fn line(from: f64, to: f64) -> Self {
        Piece([0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|z| from + z * (to - from)))
    }

    /// The value at z in [0, 1].
    pub fn at(&self, z: f64) -> f64 {
        let mut values = self.0;
        for last in (1..6).rev() {
            for i in 0..last {
                values[i] += z * (values[i + 1] - values[i]);
            }
        }
        values[0]
    }

    /// The derivative by z at z in [0, 1].
    pub fn slope(&self, z: f64) -> f64 {
        let mut values: [f64; 5] = std::array::from_fn(|i| 5.0 * (self.0[i + 1] - self.0[i]));
        for last in (1..5).rev() {
            for i in 0..last {
                values[i] += z * (values[i + 1] - values[i]);
            }
        }
        values[0]
    }

    /// The parts before and after z in [0, 1], each over [0, 1] (de Casteljau).
    pub fn split(&self, z: f64) -> [Piece; 2] {
        let (mut values, mut low, mut high) = (self.0, [0.0; 6], [0.0; 6]);
        for last in (0..6).rev() {
            low[5 - last] = values[0];
            high[last] = values[last];
            for i in 0..last {
                values[i] += z * (values[i + 1] - values[i]);
            }
        }
        [Piece(low), Piece(high)]
    }

    /// The larger error of the polynomials over the parts before and after z, at which f has this value and this derivative by
    /// z.
    ///
    /// The error of this one is z³ (1 − z)³ (α + β (z − ½)). Over a part, the first factor is at most 1/64 of the sixth power
    /// of the part, and the second one, the sixth derivative up to a constant, is α + 7β (z − ½) in its middle.
    pub fn error_of_parts(&self, z: f64, [value, slope]: [f64; 2]) -> f64 {
        let (miss, bent, room) = (self.at(z) - value, self.slope(z) - slope, z - z * z);
        let sum = miss / room.powi(3);
        let beta = (bent - 3.0 * room * room * (1.0 - 2.0 * z) * sum) / room.powi(3);
        let over =
            |middle: f64, part: f64| (sum + beta * (7.0 * (middle - 0.5) - (z - 0.5))).abs() * part.powi(6) / 64.0;
        over(0.5 * z, z).max(over(0.5 + 0.5 * z, 1.0 - z))
    }

    /// The mean value.
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / 6.0
    }

    /// The mean of the square: products of Bernstein's polynomials have binomial means.
    pub fn mean_square(&self) -> f64 {
        const CHOOSE: [f64; 6] = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
        const CHOOSE_OF_TEN: [f64; 11] = [1.0, 10.0, 45.0, 120.0, 210.0, 252.0, 210.0, 120.0, 45.0, 10.0, 1.0];
        let mut square = [0.0; 11];
        for (i, f) in self.0.iter().enumerate() {
            for (j, g) in self.0.iter().enumerate() {
                square[i + j] += CHOOSE[i] * f * CHOOSE[j] * g;
            }
        }
        square.iter().zip(CHOOSE_OF_TEN).map(|(sum, choose)| sum / choose).sum::<f64>() / 11.0
    }

    /// The mean of f(z, value) by Gauss's rule.
    pub fn mean_of(&self, f: impl Fn(f64, f64) -> f64) -> f64 {
        GAUSS.iter().map(|[z, weight]| weight * f(*z, self.at(*z))).sum()
    }

    /// The greatest value of sign · f above `least`, or `least`: control values bound the polynomial, and parts whose bound is
    /// not above the found value are left out.
    pub fn above(&self, sign: f64, least: f64) -> f64 {
        let bound = self.0.iter().fold(f64::NEG_INFINITY, |bound, value| bound.max(sign * value));
        let least = least.max(sign * self.0[0]).max(sign * self.0[5]);
        // The rest is within the rounding of the control values. A comparison with NaN is false.
        if !(bound > least + 4.0 * f64::EPSILON * bound.abs()) {
            return least;
        }
        let [low, high] = self.split(0.5);
        high.above(sign, low.above(sign, least))
    }

    /// The place in (0, 1] at which f − `level` changes sign upwards or downwards, if it does once; by bisection on the
    /// polynomial.
    pub fn crossing(&self, level: f64) -> Option<f64> {
        let sign = |value: f64| (value - level).signum();
        let (start, end) = (self.0[0] - level, self.0[5] - level);
        if start * end > 0.0 || start == 0.0 {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        // Halved until the ends are neighbouring numbers.
        for _ in 0..f64::MANTISSA_DIGITS + 2 {
            let middle = 0.5 * (low + high);
            if sign(self.at(middle)) == sign(self.0[0]) { low = middle } else { high = middle }
        }
        Some(high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// t⁵ − 2 t³ + t − 0.25 between two places, with its antiderivative.
    fn jet(t: f64) -> Jet {
        [t.powi(5) - 2.0 * t.powi(3) + t - 0.25, 5.0 * t.powi(4) - 6.0 * t * t + 1.0, 20.0 * t.powi(3) - 12.0 * t]
    }

    #[test]
    fn a_quintic_is_itself() {
        let (from, step) = (-1.25, 2.75);
        let piece = Piece::new(jet(from), jet(from + step), step);
        for i in 0..=40 {
            let z = f64::from(i) / 40.0;
            assert!((piece.at(z) - jet(from + step * z)[0]).abs() < 1e-14, "{z}");
            let [low, high] = piece.split(0.3);
            assert!((piece.slope(z) - step * jet(from + step * z)[1]).abs() < 1e-13, "{z}");
            let part = if z < 0.3 { low.at(z / 0.3) } else { high.at((z - 0.3) / 0.7) };
            assert!((part - piece.at(z)).abs() < 1e-14, "{z}");
        }
        let whole = |t: f64| t.powi(6) / 6.0 - 0.5 * t.powi(4) + 0.5 * t * t - 0.25 * t;
        assert!((piece.mean() - (whole(from + step) - whole(from)) / step).abs() < 1e-14);
        // Its square, of degree ten, against a fine trapezoidal rule with Richardson's step.
        let square = |n: usize| {
            let f = |i: usize| jet(from + step * i as f64 / n as f64)[0].powi(2);
            ((1..n).map(f).sum::<f64>() + 0.5 * (f(0) + f(n))) / n as f64
        };
        let exact = (4.0 * square(20_000) - square(10_000)) / 3.0;
        assert!((piece.mean_of(|_, f| f * f) - exact).abs() < 1e-12);
        assert!((piece.mean_square() - exact).abs() < 1e-12);
    }

    #[test]
    fn extremes_lie_between_the_points() {
        let (from, step) = (-1.25, 2.75);
        let piece = Piece::new(jet(from), jet(from + step), step);
        // Zeros of the slope: t² = (6 ± √16)/10.
        let inner = jet(0.2_f64.sqrt())[0];
        let ends = [jet(from)[0], jet(from + step)[0]];
        assert_eq!(piece.above(1.0, f64::NEG_INFINITY), ends[1]);
        assert_eq!(piece.above(-1.0, f64::NEG_INFINITY), -ends[0]);
        let [low, _] = piece.split((0.9 - from) / step);
        let greatest = low.above(1.0, f64::NEG_INFINITY);
        assert!((greatest - inner).abs() < 1e-14 && low.above(1.0, 5.0) == 5.0, "{greatest} {inner}");
        assert_eq!(Piece::constant(3.0).above(-1.0, f64::NEG_INFINITY), -3.0);
        assert!(!Piece::constant(f64::NAN).above(1.0, f64::NEG_INFINITY).is_finite());
    }

    #[test]
    fn the_error_is_of_sixth_order() {
        let sine = |t: f64| [t.cos(), -t.sin(), -t.cos()];
        let error = |step: f64| {
            let piece = Piece::new(sine(-0.5 * step), sine(0.5 * step), step);
            (0..=100)
                .map(|i| f64::from(i) / 100.0)
                .fold(0.0, |most: f64, z| most.max((piece.at(z) - (step * (z - 0.5)).cos()).abs()))
        };
        let ratio = error(0.8) / error(0.4);
        assert!((50.0..80.0).contains(&ratio), "{ratio}");
        assert!(error(0.4) < 0.4_f64.powi(6) / 46080.0);
    }

    #[test]
    fn the_error_of_parts_is_that_of_their_polynomials() {
        let sine = |t: f64| [t.cos(), -t.sin(), -t.cos()];
        for z in [0.1, 0.3, 0.5, 0.8] {
            let (from, step) = (0.4, 0.6);
            let middle = sine(from + z * step);
            let told = Piece::new(sine(from), sine(from + step), step).error_of_parts(z, [middle[0], step * middle[1]]);
            let error = |from: f64, step: f64| {
                let piece = Piece::new(sine(from), sine(from + step), step);
                let errors = (0..=100).map(|i| f64::from(i) / 100.0).map(|z| piece.at(z) - (from + step * z).cos());
                errors.fold(0.0, |most: f64, error| most.max(error.abs()))
            };
            let found = error(from, z * step).max(error(from + z * step, (1.0 - z) * step));
            assert!((told / found - 1.0).abs() < 0.1, "{z}: {told} {found}");
        }
    }

    #[test]
    fn a_level_is_crossed_once() {
        let line = Piece::new([1.0, 2.0, 0.0], [5.0, 2.0, 0.0], 2.0);
        assert!((line.crossing(2.0).unwrap() - 0.25).abs() < 1e-15);
        assert!(line.crossing(5.0).is_some_and(|z| (z - 1.0).abs() < 1e-14));
        assert_eq!((line.crossing(1.0), line.crossing(6.0)), (None, None));
    }
}
