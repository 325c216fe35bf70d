//! Kaltofen's closed formulas for a cubic U, undamped and with e = 0: the reference of the tests. τ = ω t, a² = μ/(μ+1).
//! The equation numbers are those of the source; signs and orders of derivatives are corrected where its print is wrong.

/// The passage through the clearance.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// Mass ratio m1/m2; 0 and ∞ stand for the limits.
    pub mu: f64,
    /// Dynamic clearance K = −s/(U‴η³), (16).
    pub k: f64,
    /// ω times the time of passage.
    pub tau1: f64,
}

/// What follows the impact in the cubic model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sequel {
    /// Contact lasts.
    Lasting,
    /// F_K pulls right after the impact.
    Immediate,
    /// F_K changes its sign within the first period.
    Elastic,
}

impl Passage {
    /// Solves (15): g = τ³ − 6K + 6/(μ+1) [τ − a sin(τ/a)], which grows monotonically.
    pub fn new(mu: f64, k: f64) -> Self {
        let g = |tau: f64| {
            let (a, share) = Self::constants(mu);
            let sine = if mu == 0.0 { 0.0 } else { a * (tau / a).sin() };
            tau.powi(3) - 6.0 * k + 6.0 * share * (tau - sine)
        };
        let (mut low, mut high) = (0.0, (6.0 * k).cbrt() * (1.0 + 1e-15));
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if g(middle) < 0.0 { low = middle } else { high = middle }
        }
        Passage { mu, k, tau1: 0.5 * (low + high) }
    }

    /// a and 1/(μ+1).
    fn constants(mu: f64) -> (f64, f64) {
        if mu.is_infinite() { (1.0, 0.0) } else { ((mu / (mu + 1.0)).sqrt(), 1.0 / (mu + 1.0)) }
    }

    /// (18): Z, the velocity jump of m1 is I = U‴η²Ω Z.
    pub fn jump(&self) -> f64 {
        let (a, share) = Self::constants(self.mu);
        0.5 * self.tau1 * self.tau1 + share * (1.0 - (self.tau1 / a).cos())
    }

    /// (20): q₂ = −U‴η³ · first, q̇₂ = −U‴η²Ω · second, just before the impact.
    pub fn spring(&self) -> [f64; 2] {
        let (a, _) = Self::constants(self.mu);
        [a * (self.tau1 / a).sin(), (self.tau1 / a).cos()]
    }

    /// (22), (23): A and B.
    pub fn amplitudes(&self) -> [f64; 2] {
        let (a, share) = Self::constants(self.mu);
        let theta = self.tau1 / a;
        [0.5 * self.tau1 * self.tau1 - self.mu * share * (1.0 - theta.cos()), a * theta.sin() - self.tau1]
    }

    /// (21): q₂*/s at τ* after the impact.
    pub fn elongation(&self, tau: f64) -> f64 {
        let [a, b] = self.amplitudes();
        (tau + self.tau1 + a * tau.sin() + b * tau.cos()) / self.k
    }

    /// (26): f; F_K = −c s f/K after the impact, so that f > 0 presses.
    pub fn pressing(&self, tau: f64) -> f64 {
        let [a, b] = self.amplitudes();
        (self.mu + 1.0) * (self.tau1 + tau) + a * tau.sin() + b * tau.cos()
    }

    /// What follows: only the sign right after the impact and the minimum over one period count.
    pub fn sequel(&self) -> Sequel {
        if self.pressing(0.0) < 0.0 {
            return Sequel::Immediate;
        }
        // f′ = μ + 1 + A cos τ − B sin τ = μ + 1 + R cos(τ + δ): the minimum has cos(τ + δ) = −(μ+1)/R, sin > … 0.
        let [a, b] = self.amplitudes();
        let (size, delta) = (a.hypot(b), b.atan2(a));
        if size <= self.mu + 1.0 {
            return Sequel::Lasting;
        }
        let tau = (-((-(self.mu + 1.0) / size).acos()) - delta).rem_euclid(std::f64::consts::TAU);
        if self.pressing(tau) < 0.0 { Sequel::Elastic } else { Sequel::Lasting }
    }
}

/// The K beyond which contact is interrupted elastically: a double zero of f, found by bisection in a range in which
/// the sequel changes once.
pub fn elastic_border(mu: f64, low: f64, high: f64) -> f64 {
    let (mut low, mut high) = (low, high);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if Passage::new(mu, middle).sequel() == Sequel::Elastic { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_passage_times() {
        let masses = [0.0, 0.1, 0.3, 1.0, 3.0, 10.0, f64::INFINITY];
        let table: [(f64, [f64; 7]); 9] = [
            (0.1, [0.099834161, 0.38890686, 0.52528676, 0.67447499, 0.76879501, 0.81795519, 0.84343267]),
            (0.5, [0.4814056, 0.70385935, 0.9270935, 1.1703067, 1.3226477, 1.4015222, 1.4422496]),
            (1.0, [0.8846222, 0.94600704, 1.205055, 1.4940521, 1.6752215, 1.7688423, 1.8171206]),
            (2.0, [1.4702785, 1.3982044, 1.6060926, 1.922338, 2.1275599, 2.2342929, 2.2894285]),
            (5.0, [2.4745519, 2.5802948, 2.5413644, 2.7323913, 2.9348808, 3.0477212, 3.1072325]),
            (10.0, [3.4072631, 3.4147604, 3.5711236, 3.6140128, 3.7598162, 3.8593969, 3.9148676]),
            (15.0, [4.0367362, 4.1023864, 4.165742, 4.2483949, 4.3487062, 4.4321249, 4.4814047]),
            (20.0, [4.5279318, 4.5767197, 4.6150979, 4.7421999, 4.8190819, 4.8889854, 4.9324241]),
            (50.0, [6.3957764, 6.4307079, 6.4781393, 6.5476237, 6.6292058, 6.6697065, 6.6943295]),
        ];
        for (k, row) in table {
            for (mu, printed) in masses.into_iter().zip(row) {
                let tau = Passage::new(mu, k).tau1;
                // Eight printed digits.
                let unit = 10f64.powi(printed.log10().floor() as i32 - 7);
                assert!((tau - printed).abs() < 0.51 * unit, "K = {k}, μ = {mu}: {tau} instead of {printed}");
            }
        }
    }

    #[test]
    fn the_map_of_repeated_impacts() {
        let map = [
            (3.008, ".........................................oooooooo"),
            (1.222, "...................................oooooooooooooo"),
            (0.496, "...............................oooooooooooooooooo"),
            (0.272, ".............................oooooooooooooooooooo"),
            (0.202, ".................ii.........ooooooooooooooooooooo"),
            (0.149, "...............iii..........ooooooooooooooooooooo"),
            (0.082, ".............iiii..........oooooooooooooooooooooo"),
            (0.045, "...........iiii....ii....i.oooooooooooooooooooooo"),
            (0.025, ".........iiii...ii...i...i.oioooooooooooooooooooo"),
            (0.010, ".......iii...ii..i..i.i..i.iooiooiooooooooooooooo"),
        ];
        for (mu, row) in map {
            let letters: String = (0..row.len())
                .map(|column| match Passage::new(mu, 10f64.powf(-1.0 + column as f64 / 12.0)).sequel() {
                    Sequel::Lasting => '.',
                    Sequel::Immediate => 'i',
                    Sequel::Elastic => 'o',
                })
                .collect();
            assert_eq!(letters, row, "μ = {mu}");
        }
    }

    #[test]
    fn the_borders_of_elastic_release() {
        // μ → 0: f = τ₁ + τ* + ½τ₁² sin τ* − τ₁ cos τ* has its double zero at K = (τ₁³ + 6τ₁)/6.
        let f_min = |tau1: f64| {
            let (a, b) = (0.5 * tau1 * tau1, -tau1);
            let size = f64::hypot(a, b);
            let tau = -(-1.0 / size).acos() - b.atan2(a);
            let tau = tau.rem_euclid(std::f64::consts::TAU);
            tau1 + tau + a * tau.sin() + b * tau.cos()
        };
        let (mut low, mut high) = (3.0, 5.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if f_min(middle) > 0.0 { low = middle } else { high = middle }
        }
        assert!((low - 4.05622684325).abs() < 1e-11, "{low}");
        assert!(((low.powi(3) + 6.0 * low) / 6.0 - 15.1790607982).abs() < 1e-10);
        for (mu, printed, digit) in [
            (0.05, 16.36, 0.01),
            (0.1, 17.99, 0.01),
            (0.2, 20.56, 0.01),
            (0.3, 24.41, 0.01),
            (0.5, 32.57, 0.01),
            (1.0, 57.52, 0.01),
            (2.0, 129.0, 1.0),
            (5.0, 644.0, 1.0),
            (10.0, 2954.0, 1.0),
        ] {
            let border = elastic_border(mu, 14.0, 5000.0);
            assert!((border - printed).abs() < 0.51 * digit, "μ = {mu}: {border} instead of {printed}");
        }
    }

    #[test]
    fn immediate_release_ends_at_a_mass_ratio_of_0_217() {
        // sin θ < −μθ needs μ < −cos θ*, tan θ* = θ*.
        let (mut low, mut high) = (4.4, 4.6);
        for _ in 0..100 {
            let middle: f64 = 0.5 * (low + high);
            if middle.tan() < middle { low = middle } else { high = middle }
        }
        assert!((-f64::cos(low) - 0.2172336282).abs() < 1e-10);
        let immediate =
            |mu: f64| (0..4000).any(|i| Passage::new(mu, 0.1 + 0.01 * f64::from(i)).sequel() == Sequel::Immediate);
        assert!(immediate(0.2171) && !immediate(0.2173));
    }

    #[test]
    fn the_vibration_after_the_impact_stays_below_the_clearance() {
        // (24): √(A² + B²)/K ≤ 1.
        for mu in [0.01, 0.1, 0.5, 2.0, 20.0] {
            for i in 0..60 {
                let k = 10f64.powf(-3.0 + 0.1 * f64::from(i));
                let [a, b] = Passage::new(mu, k).amplitudes();
                assert!(a.hypot(b) / k <= 1.0 + 1e-9, "μ = {mu}, K = {k}");
            }
        }
    }
}
