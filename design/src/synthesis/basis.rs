//! The functions that a profile is made of.

use super::exact::sin_cos;
use crate::work;
use camdrive::motion::Fourier;
use camdrive::numerics::double_double::Double;

/// Symmetry of the profile that the user knows beforehand; each one halves the unknowns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Symmetry {
    /// U(−φ) = U(φ): cosines only.
    pub even: bool,
    /// U(φ + π) − a₀ = −(U(φ) − a₀): odd harmonics only.
    pub half_wave: bool,
}

/// An elastic output member: y moves, not the x of the cam.
///
/// Y_k/X_k = (1 + 2iδν)/(1 − ν² + 2iδν), ν = kη, η = Ω/ω₀. Source: Dresig, Vulfson, *Dynamik der Mechanismen*,
/// section 4.6.2, equation (4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// δ (1).
    pub damping: f64,
    /// η (1).
    pub eta: f64,
}

impl Response {
    /// Real and imaginary part of Y_k/X_k; infinite at an undamped resonance.
    pub fn gain(&self, k: usize) -> [f64; 2] {
        let nu = k as f64 * self.eta;
        // 1 − ν² as a product keeps its digits near the resonance.
        let (re, im) = ((1.0 - nu) * (1.0 + nu), 2.0 * self.damping * nu);
        let size = re * re + im * im;
        [(re + im * im) / size, -im * nu * nu / size]
    }
}

/// One function of a law: cos kφ or sin kφ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Wave {
    law: usize,
    k: usize,
    sine: bool,
}

/// 1, cos kφ, sin kφ up to a highest harmonic, as far as the symmetry admits them; of one law or of several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Basis {
    waves: Vec<Wave>,
}

impl Basis {
    /// The functions up to harmonic `order`.
    pub fn new(order: usize, symmetry: Symmetry) -> Self {
        let admitted = (0..=order).filter(|k| *k == 0 || !symmetry.half_wave || k % 2 == 1);
        let of = |k: usize| {
            let sines = if k == 0 || symmetry.even { 0 } else { 1 };
            (0..=sines).map(move |s| Wave { law: 0, k, sine: s == 1 })
        };
        Basis { waves: admitted.flat_map(of).collect() }
    }

    /// The functions of several laws, each with its own.
    pub fn joined(laws: &[Basis]) -> Self {
        let of = |(law, basis): (usize, &Basis)| basis.waves.clone().into_iter().map(move |w| Wave { law, ..w });
        Basis { waves: laws.iter().enumerate().flat_map(of).collect() }
    }

    /// The functions of one law alone.
    pub fn of(&self, law: usize) -> Self {
        let waves = self.waves.iter().filter(|w| w.law == law);
        Basis { waves: waves.map(|w| Wave { law: 0, ..*w }).collect() }
    }

    /// Adds another law, which stands still: a number.
    pub fn with_number(mut self, law: usize) -> Self {
        self.waves.push(Wave { law, k: 0, sine: false });
        self
    }

    /// The functions up to harmonic `order`.
    pub fn up_to(&self, order: usize) -> Self {
        Basis { waves: self.waves.iter().copied().filter(|w| w.k <= order).collect() }
    }

    /// The number of functions.
    pub fn size(&self) -> usize {
        self.waves.len()
    }

    /// The highest harmonic.
    pub fn order(&self) -> usize {
        self.waves.iter().map(|w| w.k).max().unwrap_or(0)
    }

    /// The harmonics k > 0, ascending.
    pub fn harmonics(&self) -> impl Iterator<Item = usize> {
        (1..=self.order()).filter(|k| self.waves.iter().any(|w| w.k == *k))
    }

    /// True if there are only cosines.
    pub fn is_even(&self) -> bool {
        self.waves.iter().all(|w| !w.sine)
    }

    /// The functions without harmonic `k`.
    pub fn without(&self, k: usize) -> Self {
        Basis { waves: self.waves.iter().copied().filter(|w| w.k != k).collect() }
    }

    /// The n-th derivatives of all functions of a law at `phi`, or of what an elastic output member makes of them; zero of
    /// the other laws.
    pub fn row(&self, law: usize, phi: f64, n: usize, response: Option<Response>) -> Vec<Double> {
        // Sine and cosine take thirty terms, an order four products, a function two or three.
        work::draw(work::PRECISE * (30 + 4 * self.order() + 3 * self.size()) as f64);
        // cos kφ and sin kφ for all k by addition of angles.
        let [s1, c1] = sin_cos(phi);
        let mut angles = vec![[Double::default(), Double::from(1.0)]];
        for k in 0..self.order() {
            let [s, c] = angles[k];
            angles.push([s * c1 + c * s1, c * c1 - s * s1]);
        }
        let value = |wave: &Wave| {
            if wave.law != law {
                return Double::default();
            }
            let [sin, cos] = angles[wave.k];
            // Each derivative turns the wave by a quarter.
            let turned = |quarters: usize| [cos, -sin, -cos, sin][quarters % 4];
            let quarters = n + if wave.sine { 3 } else { 0 };
            let size = (0..n).fold(Double::from(1.0), |size, _| size * Double::from(wave.k as f64));
            let wave = match response {
                None => turned(quarters),
                Some(response) => {
                    let [re, im] = response.gain(wave.k).map(Double::from);
                    re * turned(quarters) + im * turned(quarters + 1)
                }
            };
            size * wave
        };
        self.waves.iter().map(value).collect()
    }

    /// The series of a law with these coefficients, times `scale`.
    pub fn series(&self, law: usize, x: &[Double], scale: f64) -> Fourier {
        let own = || self.waves.iter().zip(x).filter(|(wave, _)| wave.law == law);
        let order = own().map(|(wave, _)| wave.k).max().unwrap_or(0);
        let mut series = Fourier::new(vec![0.0; order + 1], Vec::new());
        for (wave, &x) in own() {
            let list = if wave.sine { &mut series.b } else { &mut series.a };
            list[wave.k] = (x * Double::from(scale)).hi;
        }
        series
    }

    /// Each function as a series.
    pub fn units(&self) -> impl Iterator<Item = Fourier> {
        (0..self.size()).map(|i| {
            let mut x = vec![0.0; self.size()];
            x[i] = 1.0;
            self.series_of(&x)
        })
    }

    /// The series with these coefficients.
    pub fn series_of(&self, x: &[f64]) -> Fourier {
        let x: Vec<Double> = x.iter().map(|x| Double::from(*x)).collect();
        self.series(0, &x, 1.0)
    }

    /// The coefficients of a series in units of `scale`, without the ones that the symmetry excludes.
    pub fn coefficients(&self, series: &Fourier, scale: f64) -> Vec<Double> {
        let of = |wave: &Wave| {
            let list = if wave.sine { &series.b } else { &series.a };
            Double::from(list.get(wave.k).copied().unwrap_or(0.0)).divide(Double::from(scale))
        };
        self.waves.iter().map(of).collect()
    }
}
