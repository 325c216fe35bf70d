//! The motion from rest on a Fourier law at constant speed in double-double, written independently of the drive.

use crate::motion::Fourier;
use crate::numerics::double_double::{Double, two_product};
use std::f64::consts::TAU;

type Complex = [Double; 2];

fn product([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

/// e^(x + iy): the series after halving, then squared as often.
fn exponential(x: Double, y: Double) -> Complex {
    if x.hi < -100.0 {
        return [Double::default(); 2];
    }
    let turns = (y.hi / TAU).round();
    let rest = y - two_product(turns, TAU) - two_product(turns, 2.4492935982947064e-16);
    let halvings = (0..).find(|n| (x.hi.abs() + rest.hi.abs()) * 0.5f64.powi(*n) < 0.02).unwrap();
    let scale = Double::from(0.5f64.powi(halvings));
    let z = [x * scale, rest * scale];
    // 0.02¹⁶/16! is below 1e-40.
    let mut sum = [Double::from(1.0), Double::default()];
    for n in (1..=16).rev() {
        let [re, im] = product(z, sum);
        let n = Double::from(f64::from(n));
        sum = [Double::from(1.0) + re.divide(n), im.divide(n)];
    }
    (0..halvings).fold(sum, |e, _| product(e, e))
}

/// q of q̈ + b q̇ + c q = −ẍ from rest at t = 0, where φ = `phi`.
pub struct Truth<'a> {
    pub series: &'a Fourier,
    pub b: f64,
    pub c: f64,
    pub phi: f64,
    pub w: f64,
}

impl Truth<'_> {
    /// q (m) at `time` (s).
    pub fn at(&self, time: f64) -> f64 {
        let (driven, _) = self.driven(time);
        let ([q, v], delta) = (self.start(), Double::from(0.5 * self.b));
        let (t, difference) = (Double::from(time), Double::from(self.c) - delta * delta);
        let rate = v + delta * q;
        let free = if difference.hi > 0.0 {
            let frequency = difference.sqrt();
            let [c, s] = exponential(-(delta * t), frequency * t);
            q * c + rate.divide(frequency) * s
        } else {
            let split = (-difference).sqrt();
            let [slow, fast] =
                [split - delta, -(split + delta)].map(|lambda| exponential(lambda * t, Double::default())[0]);
            let odd = rate.divide(split);
            Double::from(0.5) * ((q + odd) * slow + (q - odd) * fast)
        };
        (driven + free).hi
    }

    /// The difference of the start from the driven motion.
    fn start(&self) -> [Double; 2] {
        let (q, v) = self.driven(0.0);
        [-q, -v]
    }

    /// The periodic motion and its rate.
    fn driven(&self, time: f64) -> (Double, Double) {
        let turn = exponential(Double::default(), Double::from(self.phi) + two_product(self.w, time));
        let (mut z, mut q, mut v) = (turn, Double::default(), Double::default());
        for k in 1..=self.series.order() {
            let nu = two_product(k as f64, self.w);
            let (r, s) = (Double::from(self.c) - nu * nu, Double::from(self.b) * nu);
            let (a, b) = (nu * nu * Double::from(self.series.a[k]), nu * nu * Double::from(self.series.b[k]));
            let determinant = r * r + s * s;
            let (even, odd) = ((r * a - s * b).divide(determinant), (r * b + s * a).divide(determinant));
            q = q + even * z[0] + odd * z[1];
            v = v + nu * (odd * z[0] - even * z[1]);
            z = product(z, turn);
        }
        (q, v)
    }
}
