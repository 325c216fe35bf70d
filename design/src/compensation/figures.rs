//! Courses and spectra of the rounds as diagrams: φ̇(t), the tools' accelerations, their distances.
//!
//! The acceleration of a motion y(ψ) = Σ aₘ cos mψ + bₘ sin mψ, ψ = Ωt, has the amplitudes m²Ω²√(aₘ² + bₘ²), with the own Ω =
//! 2π/T of each round; the prescribed motion is compared at the same Ω. The courses are sums of these series: they overshoot a
//! jump of a cycle's acceleration by a tenth.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", tables 1 and 2, equation (5).

use super::iteration::Round;
use super::report::Compensation;
use super::spectral::{POINTS, phase};
use crate::plot::{Axis, Diagram, Rule, Series};
use crate::report::unit::RPM;
use camdrive::motion::Fourier;

/// The least harmonic shown, relative to the largest one, also for higher ones: HS profiles have none, and cycles have no end.
const LEAST: f64 = 1e-4;
const HIGHEST: usize = 40;

impl Compensation {
    /// The machines with their names in legends.
    fn shown(&self) -> impl Iterator<Item = (String, &Round)> {
        self.machines().map(|(name, round)| match name.as_str() {
            "round 0" => ("cams for uniform speed".to_owned(), round),
            "finished" => ("compensated cams".to_owned(), round),
            _ => (name, round),
        })
    }

    /// All diagrams by the names of their files.
    pub fn diagrams(&self) -> Vec<(String, Diagram)> {
        let of_tool = |(j, number): (usize, &usize)| {
            let names = [format!("tool{number}"), format!("tool{number}.spectrum")];
            names.into_iter().zip([self.acceleration_diagram(j), self.spectrum_diagram(j)])
        };
        let distance = self.distance_diagram().map(|diagram| ("distance".to_owned(), diagram));
        let tools = self.numbers.iter().enumerate().flat_map(of_tool);
        std::iter::once(("speed".to_owned(), self.speed_diagram())).chain(tools).chain(distance).collect()
    }

    /// The first and the last machine: courses of the others lie in between.
    fn at_the_ends(&self) -> impl Iterator<Item = (String, &Round)> {
        self.shown().filter(|(name, _)| !name.starts_with("round"))
    }

    /// φ̇(t) of the first and the last machine.
    fn speed_diagram(&self) -> Diagram {
        let curves =
            self.at_the_ends().map(|(name, round)| (name, over_period(|psi| RPM.factor * round.speeds.at(psi).0[0])));
        let series = curves.map(|(name, points)| Series::line(name, points)).collect();
        let title = format!("Speed of {} over a period", self.scene);
        Diagram::new(title, [period_axis(), Axis::linear("Speed [rpm]")], series, Vec::new())
    }

    /// The acceleration of tool `j` over time: prescribed, first and last.
    fn acceleration_diagram(&self, j: usize) -> Diagram {
        let curve = |name: String, series: &Fourier, round: &Round| {
            let omega = round.mean_speed();
            Series::line(name, over_period(|psi| omega * omega * series.at(psi).0[2]))
        };
        let wanted = curve("as prescribed".to_owned(), &self.wanted[j], &self.finished);
        let shown = self.at_the_ends().map(|(name, round)| curve(name, &round.motions[j], round));
        let title = format!("Acceleration of tool {} of {} over a period", self.numbers[j], self.scene);
        let axes = [period_axis(), Axis::linear(self.acceleration(j))];
        Diagram::new(title, axes, std::iter::once(wanted).chain(shown).collect(), Vec::new())
    }

    /// The harmonics of the acceleration of tool `j`.
    fn spectrum_diagram(&self, j: usize) -> Diagram {
        let all = |series: &Fourier, round: &Round| -> Vec<f64> {
            (1..=series.order().min(HIGHEST)).map(|m| round.harmonic(series, m)).collect()
        };
        let wanted = ("as prescribed".to_owned(), all(&self.wanted[j], &self.finished));
        let shown = self.shown().map(|(name, round)| (name, all(&round.motions[j], round)));
        let spectra: Vec<(String, Vec<f64>)> = std::iter::once(wanted).chain(shown).collect();
        let least = LEAST * spectra.iter().flat_map(|(_, spectrum)| spectrum).fold(0.0, |most, a| a.max(most));
        let series = |(i, (name, spectrum)): (usize, (String, Vec<f64>))| {
            let harmonics = spectrum.into_iter().zip(1_u16..).map(|(a, m)| [f64::from(m), a]);
            // The prescribed harmonics as a line, so that harmonics that meet them do not hide them.
            Series { joined: i == 0, ..Series::dots(name, harmonics.filter(|[_, a]| *a >= least)) }
        };
        let series = spectra.into_iter().enumerate().map(series).collect();
        let title = format!("Spectrum of the acceleration of tool {} of {}", self.numbers[j], self.scene);
        let axes = [Axis::linear("Harmonic [1]"), Axis::logarithmic(self.acceleration(j))];
        Diagram::new(title, axes, series, Vec::new())
    }

    /// The distances of tools that keep clear, with cams for uniform speed and at last; None without such a condition.
    fn distance_diagram(&self) -> Option<Diagram> {
        let (mut series, mut rules) = (Vec::new(), Vec::new());
        for (name, clearance) in self.restrictions.clearances() {
            for (machine, round) in self.shown() {
                let motions = clearance.laws.map(|j| round.motions[j].clone());
                let points = over_period(|psi| clearance.apart(&motions, psi));
                series.push(Series::line(format!("{name}, {machine}"), points));
            }
            rules.push(Rule::Horizontal(clearance.distance, "asked for".to_owned()));
        }
        let title = format!("Distances of the tools of {} over a period", self.scene);
        let axes = [period_axis(), Axis::linear("Distance [m]")];
        (!series.is_empty()).then(|| Diagram::new(title, axes, series, rules))
    }

    /// Label of an axis with the acceleration of tool `j`.
    fn acceleration(&self, j: usize) -> &'static str {
        if self.turning[j] { "Angular acceleration of the tool [rad/s²]" } else { "Acceleration of the tool [m/s²]" }
    }
}

/// A function of ψ at equal steps, over ψ in degrees.
fn over_period(f: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    (0..=POINTS).map(phase).map(|psi| [psi.to_degrees(), f(psi)]).collect()
}

fn period_axis() -> Axis {
    Axis::angular("Angle at uniform speed, ψ = 2πt/T [°]").between(0.0, 360.0)
}
