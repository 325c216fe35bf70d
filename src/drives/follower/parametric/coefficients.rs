//! The periodic coefficients of m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ): their values, their harmonics and their variation.

use super::crank::{Dip, ParallelCrank, SAME_ANGLE};
use crate::motion::Fourier;
use crate::numerics::divisor::greatest_common_divisor;
use crate::numerics::work::HARMONIC;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// c(φ).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Stiffness {
    /// A finite Fourier series.
    Series(Fourier),
    /// A sum of dips, as of a parallel crank.
    Dips(Vec<Dip>),
}

/// m, b, c and f over the drive angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coefficients {
    /// m(φ) (kg·m² or kg).
    pub m: Fourier,
    /// b(φ) (N·m·s/rad or N·s/m).
    pub b: Fourier,
    /// c(φ) (N·m/rad or N/m).
    pub c: Stiffness,
    /// f(φ) (N·m or N).
    pub f: Fourier,
}

/// Coefficients with their first three derivatives by φ at an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// m, m′, m″, m‴.
    pub m: [f64; 4],
    /// b, b′, b″, b‴.
    pub b: [f64; 4],
    /// c, c′, c″, c‴.
    pub c: [f64; 4],
    /// f, f′, f″, f‴.
    pub f: [f64; 4],
}

impl Stiffness {
    /// The stiffness of a parallel-crank drive.
    pub fn of_crank(crank: &ParallelCrank) -> Self {
        Stiffness::Dips(crank.dips().collect())
    }

    /// c, c′, c″, c‴ at `phi` (rad).
    pub fn at(&self, phi: f64) -> [f64; 4] {
        match self {
            Stiffness::Series(series) => at(series, phi),
            Stiffness::Dips(dips) => dips.iter().fold([0.0; 4], |sum, dip| {
                let part = dip.at(phi);
                std::array::from_fn(|n| sum[n] + part[n])
            }),
        }
    }

    /// Whether c may depend on φ, whatever the values of its parameters.
    pub fn varies(&self) -> bool {
        match self {
            Stiffness::Series(series) => 0 < series.order(),
            Stiffness::Dips(_) => true,
        }
    }

    /// The harmonics of c up to `order`.
    pub fn harmonics(&self, order: usize) -> Fourier {
        let mut series = Fourier::new(vec![0.0; order + 1], Vec::new());
        match self {
            Stiffness::Series(own) => {
                for k in 0..=order.min(own.order()) {
                    (series.a[k], series.b[k]) = (own.a[k], own.b[k]);
                }
            }
            Stiffness::Dips(dips) => dips.iter().for_each(|dip| dip.add_harmonics(&mut series)),
        }
        series
    }

    /// The mean over a turn.
    pub fn mean(&self) -> f64 {
        self.harmonics(0).a[0]
    }

    /// The greatest common divisor of the orders of the harmonics; 0 if c is constant.
    fn symmetry(&self) -> usize {
        match self {
            Stiffness::Series(series) => symmetry(series),
            Stiffness::Dips(dips) => match dips[..] {
                [dip] if dip.swing == 0.0 => 0,
                // Two dips of one shape a quarter of a turn apart.
                [first, second] if ((second.centre - first.centre).abs() - 0.5 * PI).abs() <= SAME_ANGLE => 4,
                _ => 2,
            },
        }
    }
}

impl Coefficients {
    /// All coefficients at `phi` (rad).
    pub fn at(&self, phi: f64) -> Values {
        Values { m: at(&self.m, phi), b: at(&self.b, phi), c: self.c.at(phi), f: at(&self.f, phi) }
    }

    /// Cost of an evaluation (nominal µs), see [`crate::numerics::work`]; a dip costs as much as ten harmonics.
    pub fn cost(&self) -> f64 {
        let stiffness = match &self.c {
            Stiffness::Series(series) => series.order(),
            Stiffness::Dips(dips) => 10 * dips.len(),
        };
        HARMONIC * (stiffness + [&self.m, &self.b, &self.f].map(Fourier::order).iter().sum::<usize>()) as f64
    }

    /// The angle (rad) at which m is smallest, and its value there.
    pub fn least_mass(&self) -> (f64, f64) {
        let order = self.m.order();
        if order == 0 {
            return (0.0, self.m.a[0]);
        }
        // 16 samples per shortest wave: between the neighbours of the least sample m has a single minimum.
        let count = 16 * order;
        let step = TAU / count as f64;
        let value = |phi: f64| self.m.at(phi).0[0];
        let least = (0..count).map(|i| i as f64 * step).min_by(|x, y| value(*x).total_cmp(&value(*y))).unwrap_or(0.0);
        let (mut low, mut high) = (least - step, least + step);
        // Bisection for the zero of m′ down to the spacing of the angles.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.m.at(middle).0[1] < 0.0 { low = middle } else { high = middle }
        }
        let phi = 0.5 * (low + high);
        if value(phi) < value(least) { (phi.rem_euclid(TAU), value(phi)) } else { (least, value(least)) }
    }

    /// The highest harmonic of the finite series.
    pub fn order(&self) -> usize {
        let c = if let Stiffness::Series(series) = &self.c { highest(series) } else { 0 };
        [&self.m, &self.b, &self.f].into_iter().map(highest).fold(c, usize::max)
    }

    /// The part of a turn after which the coefficients repeat, as its denominator: the greatest common divisor of the orders of all
    /// harmonics; 1 without harmonics.
    pub fn symmetry(&self) -> usize {
        let own = [&self.m, &self.b, &self.f].into_iter().map(symmetry);
        own.fold(self.c.symmetry(), greatest_common_divisor).max(1)
    }

    /// An angle (rad) over which b/m, c/m and f/m from `phi` on follow a polynomial: two radians of the highest
    /// harmonic, and half of the way to the nearest complex zero of m or pole of c, so that a cell of this length keeps
    /// three times its half-length away from them.
    pub fn reach(&self, phi: f64) -> f64 {
        let waves = 2.0 / self.order().max(1) as f64;
        let to_pole = |dip: &Dip| {
            let along = (phi - dip.centre) / PI;
            let along = PI * (along - along.round());
            let width = dip.width();
            (along * along + width * width).sqrt()
        };
        let poles = match &self.c {
            Stiffness::Series(_) => f64::INFINITY,
            Stiffness::Dips(dips) => dips.iter().map(to_pole).fold(f64::INFINITY, f64::min),
        };
        (0.5 * poles.min(self.to_massless(phi))).min(waves)
    }

    /// A bound (rad) for the distance of `phi` from the nearest complex zero of m: the zero of m + m′ x − ½ M x², with M a bound of
    /// |m″| within a radian of the highest harmonic off the real axis.
    fn to_massless(&self, phi: f64) -> f64 {
        if self.m.order() == 0 {
            return f64::INFINITY;
        }
        let [m, slope, ..] = self.m.at(phi).0;
        // cosh 1 = 1.55.
        let curvature = 1.55 * self.m.bound(2);
        let (m, slope) = (m.max(0.0), slope.abs());
        if curvature > 0.0 { 2.0 * m / (slope + (slope * slope + 2.0 * curvature * m).sqrt()) } else { f64::INFINITY }
    }

    /// The smallest angle that [`Coefficients::reach`] returns over the turn (rad), up to a factor of two.
    pub fn least_reach(&self) -> f64 {
        let dips = if let Stiffness::Dips(dips) = &self.c { &dips[..] } else { &[] };
        let places = dips.iter().map(|dip| dip.centre).chain([self.least_mass().0]);
        places.map(|phi| self.reach(phi)).fold(f64::INFINITY, f64::min)
    }

    /// A frequency (rad/s) that no vibration exceeds: √(max |c| / min m).
    pub fn highest_frequency(&self) -> f64 {
        let largest = match &self.c {
            Stiffness::Series(series) => series.bound(0),
            Stiffness::Dips(dips) => dips.iter().map(|dip| dip.stiffness).sum(),
        };
        (largest / self.least_mass().1).sqrt()
    }
}

fn at(series: &Fourier, phi: f64) -> [f64; 4] {
    // Constant coefficients cost no sine.
    if series.order() == 0 {
        return [series.a[0], 0.0, 0.0, 0.0];
    }
    let [u0, u1, u2, u3, _] = series.at(phi).0;
    [u0, u1, u2, u3]
}

/// The orders of the harmonics that are not zero.
fn orders(series: &Fourier) -> impl DoubleEndedIterator<Item = usize> {
    (1..=series.order()).filter(|&k| series.a[k] != 0.0 || series.b[k] != 0.0)
}

fn highest(series: &Fourier) -> usize {
    orders(series).next_back().unwrap_or(0)
}

/// The greatest common divisor of the orders of the harmonics; 0 without any.
pub(super) fn symmetry(series: &Fourier) -> usize {
    orders(series).fold(0, greatest_common_divisor)
}

#[cfg(test)]
mod tests {
    use super::super::crank::SecondCrank;
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const LOCOMOTIVE: ParallelCrank =
        ParallelCrank { c_t1: 3.0e6, c_t2: 6.0e6, c_ab: 5e7, r: 0.3, second: SecondCrank::None };

    fn constant(value: f64) -> Fourier {
        Fourier::new(vec![value], Vec::new())
    }

    /// The crank with σ = `sigma` and c₁₂ = 1.
    fn crank(sigma: f64, second: SecondCrank) -> ParallelCrank {
        ParallelCrank { c_t1: 2.0, c_t2: 2.0, c_ab: 1.0 / sigma, r: 1.0, second }
    }

    #[test]
    fn springs_in_series() {
        for phi in [0.1, 1.0, FRAC_PI_2, 3.0, 6.0] {
            let rod = LOCOMOTIVE.c_ab * (LOCOMOTIVE.r * f64::sin(phi)).powi(2);
            let series = 1.0 / (1.0 / LOCOMOTIVE.c_t1 + 1.0 / LOCOMOTIVE.c_t2 + 1.0 / rod);
            let c = Stiffness::of_crank(&LOCOMOTIVE).at(phi)[0];
            assert!((c / series - 1.0).abs() < 1e-14, "{phi}: {c} {series}");
        }
        assert_eq!(Stiffness::of_crank(&LOCOMOTIVE).at(0.0)[0], 0.0);
    }

    #[test]
    fn a_second_crank_on_the_same_shafts_acts_beside_the_first() {
        for angle in [0.0, 0.4, FRAC_PI_2, 2.0, PI, -1.2] {
            let second = SecondCrank::SharedShafts(angle);
            let c = Stiffness::of_crank(&crank(0.3, second));
            for phi in [0.0, 0.3, 1.7, 4.0] {
                let s = f64::sin(phi).powi(2) + (phi + angle).sin().powi(2);
                let expected = s / (0.3 + s);
                assert!((c.at(phi)[0] - expected).abs() < 1e-15, "{angle} {phi}: {} {expected}", c.at(phi)[0]);
            }
            assert_eq!(c.symmetry() == 0, angle == FRAC_PI_2);
        }
        // With shafts of its own, a quarter of a turn ahead, it leaves the harmonics 4, 8 …
        let own = Stiffness::of_crank(&crank(0.3, SecondCrank::OwnShafts(FRAC_PI_2)));
        let series = own.harmonics(8);
        assert!(series.a[2].abs() < 1e-16 && series.a[6].abs() < 1e-16 && own.symmetry() == 4);
        let single = Stiffness::of_crank(&crank(0.3, SecondCrank::None)).harmonics(8);
        for k in [0, 4, 8] {
            assert!((series.a[k] - 2.0 * single.a[k]).abs() < 1e-15);
        }
    }

    #[test]
    fn the_harmonics_of_the_crank_after_the_closed_form() {
        // r_2n = c_2n/c_0 = −(1 − ζ) ζⁿ⁻¹ with the ζ of the tables for σ = 0.01, 0.1, 1, 10.
        for (sigma, zeta) in [(0.01, 0.8190), (0.1, 0.5367), (1.0, 0.1716), (10.0, 0.0238)] {
            let c = Stiffness::of_crank(&crank(sigma, SecondCrank::None));
            let series = c.harmonics(8);
            let decay = series.a[4] / series.a[2];
            assert!((decay - zeta).abs() < 5.1e-5, "{sigma}: {decay}");
            assert!((series.a[2] / series.a[0] + (1.0 - decay)).abs() < 1e-14);
            assert!((series.a[0] - (1.0 - f64::sqrt(sigma / (1.0 + sigma)))).abs() < 1e-15);
        }
        // The soft rod: c ≈ c_AB R² sin²φ, to the last digits.
        let series = Stiffness::of_crank(&crank(1e12, SecondCrank::None)).harmonics(2);
        assert!((series.a[0] * 2e12 - 1.0).abs() < 1e-11 && (series.a[2] * 2e12 + 1.0).abs() < 1e-11);
    }

    #[test]
    fn the_harmonics_sum_up_to_the_function() {
        for (sigma, second) in [
            (0.02, SecondCrank::None),
            (0.3, SecondCrank::OwnShafts(1.0)),
            (0.3, SecondCrank::SharedShafts(1.0)),
            (0.3, SecondCrank::SharedShafts(2.5)),
        ] {
            let c = Stiffness::of_crank(&crank(sigma, second));
            let Stiffness::Dips(dips) = &c else { panic!() };
            let order = dips.iter().map(|dip| 2 * (1e-16_f64.ln() / dip.decay().ln()).ceil() as usize).max().unwrap();
            let series = c.harmonics(order);
            for i in 0..50 {
                let phi = 0.13 * f64::from(i);
                let (value, sum) = (c.at(phi), series.at(phi).0);
                for n in 0..4 {
                    let error = (value[n] - sum[n]).abs();
                    assert!(error < 1e-14 * (order as f64).powi(n as i32), "{sigma} {second:?} {phi} {n}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn the_least_mass_is_found_between_the_samples() {
        let m = Fourier::new(vec![1.0, 0.3, 0.0, -0.2], vec![0.0, 0.1, 0.4]);
        let coefficients =
            Coefficients { m: m.clone(), b: constant(0.0), c: Stiffness::Series(constant(1.0)), f: constant(0.0) };
        let (phi, least) = coefficients.least_mass();
        assert!(m.at(phi).0[1].abs() < 1e-13 && m.at(phi).0[2] > 0.0);
        for i in 0..100_000 {
            assert!(m.at(TAU * f64::from(i) / 1e5).0[0] >= least);
        }
    }

    #[test]
    fn the_reach_keeps_away_from_poles_and_zeros() {
        let mut coefficients = Coefficients {
            m: constant(1.0),
            b: constant(0.0),
            c: Stiffness::of_crank(&crank(1e-8, SecondCrank::None)),
            f: constant(0.0),
        };
        // The poles lie at ±1e-4 i.
        for phi in [0.0, 1e-5, 0.1, 1.5, PI, 6.2] {
            let distance = f64::sqrt(f64::sin(phi).asin().powi(2) + 1e-8);
            assert!((coefficients.reach(phi) / (0.5 * distance) - 1.0).abs() < 1e-3, "{phi}");
        }
        coefficients.c = Stiffness::Series(constant(1.0));
        // The zeros of 1 + e cos φ lie at π ± i acosh(1/e).
        let e = 0.999;
        coefficients.m = Fourier::new(vec![1.0, e], Vec::new());
        let height = f64::acosh(1.0 / e);
        for phi in [0.0, 2.0, 3.0, PI, 4.0] {
            let distance = f64::sqrt((phi - PI).powi(2) + height * height);
            let reach = coefficients.reach(phi);
            assert!(reach <= 0.5 * distance && reach > distance.min(2.0) / 6.0, "{phi}: {reach} {distance}");
        }
    }
}
