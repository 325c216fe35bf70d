//! The diagrams of a synthesis.

use super::laws::symmetric_dwells;
use super::shaft_study::Shafted;
use super::study::Study;
use crate::plot::{Axis, Diagram, Rule, Series, Shade};
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// Points of a curve over the turn.
const POINTS: usize = 721;

/// Deviations below this part of the unit are rounding and not drawn.
const LEAST: f64 = 1e-13;

/// The standard laws that are drawn next to a profile.
const DRAWN: [&str; 2] = ["inclined_sine", "modified_sine"];

/// The names of U, U′, U″ and of the files.
const ORDERS: [(&str, &str, &str); 3] =
    [("position", "Position U", ""), ("velocity", "U′", "/rad"), ("acceleration", "U″", "/rad²")];

fn deg(phi: f64) -> f64 {
    phi.to_degrees()
}

impl Study {
    /// All diagrams with the endings of their file names.
    pub fn figures(&self) -> Vec<(String, Diagram)> {
        let mut figures: Vec<(String, Diagram)> =
            (0..3).map(|order| (ORDERS[order].0.to_owned(), self.motion_diagram(order))).collect();
        figures.push(("torque".to_owned(), self.torque_diagram()));
        if !self.assignment.task.ranges.is_empty() {
            figures.push(("deviation".to_owned(), self.deviation_diagram()));
        }
        figures.push(("harmonics".to_owned(), self.harmonics_diagram()));
        if self.elastic.is_some() {
            figures.push(("speed".to_owned(), self.speed_diagram()));
        }
        if let Some(shaft) = &self.shaft {
            figures.push(("shaft_speed".to_owned(), self.shaft_speed_diagram(shaft)));
            figures.push(("shaft_torque".to_owned(), self.shaft_torque_diagram(shaft)));
        }
        if !self.widths.is_empty() {
            figures.push(("dwell_width".to_owned(), self.widths_diagram()));
        }
        figures
    }

    /// The profile and some standard laws.
    fn drawn(&self) -> impl Iterator<Item = (&str, &Fourier)> {
        let rivals = self.rivals.iter().enumerate();
        rivals.filter(|(i, r)| *i == 0 || DRAWN.contains(&r.name.as_str())).map(|(_, r)| (r.name.as_str(), &r.series))
    }

    fn over_the_turn(&self, name: &str, value: impl Fn(f64) -> f64) -> Series {
        let angle = |i: usize| TAU * i as f64 / (POINTS - 1) as f64;
        Series::line(name, (0..POINTS).map(|i| [deg(angle(i)), value(angle(i))]))
    }

    /// U, U′ or U″ over the turn.
    fn motion_diagram(&self, order: usize) -> Diagram {
        let (_, name, per) = ORDERS[order];
        let curves = self.drawn().map(|(name, s)| self.over_the_turn(name, |phi| s.at(phi).0[order]));
        let mut series: Vec<Series> = curves.collect();
        let task = &self.assignment.task;
        let fitted = task.ranges.iter().filter(|range| range.from == range.to);
        let fitted = fitted.filter_map(|range| Some([range.from, range.prescribed[order].as_ref()?.at(0.0)]));
        let exact = task.points.iter().filter(|point| point.order == order).map(|point| [point.phi, point.value]);
        let own = fitted.chain(exact).map(|[phi, u]| [deg(phi.rem_euclid(TAU)), u]);
        let own: Vec<[f64; 2]> = own.collect();
        if !own.is_empty() {
            series.push(Series::dots("points", own));
        }
        let [low, high] = self.peaks[order..=order].iter().map(|p| p.value.abs()).fold([0.0, 0.0], |_, p| [-p, p]);
        let band = |from: f64, to: f64| {
            let (from, to) = (deg(from), deg(to));
            let (low, high) = (2.0 * low, 2.0 * high);
            Rule::Area(vec![[from, low], [to, low], [to, high], [from, high]], Shade::Pale)
        };
        let rules = task.ranges.iter().filter(|r| r.prescribed[order].is_some()).flat_map(|r| {
            // A range that reaches over the turn's end is seen at both.
            [-TAU, 0.0, TAU].map(|turn| band(r.from + turn, r.to + turn))
        });
        let axes = [Axis::angular("Angle φ [°]"), Axis::linear(&format!("{name} [m{per}]"))];
        Diagram::new(format!("{name} of {} over the turn", self.assignment.name), axes, series, rules.collect())
    }

    /// U′U″, the kinetostatic torque over m Ω².
    fn torque_diagram(&self) -> Diagram {
        let torque = |s: &Fourier, phi: f64| {
            let [_, first, second, ..] = s.at(phi).0;
            first * second
        };
        let title = format!("Kinetostatic torque of {} over the turn", self.assignment.name);
        let curves = self.drawn().map(|(name, s)| self.over_the_turn(name, |phi| torque(s, phi)));
        Diagram::new(
            title,
            [Axis::angular("Angle φ [°]"), Axis::linear("U′U″ [m²/rad³]")],
            curves.collect(),
            Vec::new(),
        )
    }

    /// U − Ũ in the ranges.
    fn deviation_diagram(&self) -> Diagram {
        let (mut series, mut rules) = (Vec::new(), Vec::new());
        for (i, range) in self.assignment.task.ranges.iter().enumerate() {
            let Some(target) = range.prescribed[0].as_ref() else { continue };
            let angles: Vec<f64> =
                (0..=240).map(|j| range.from + (range.to - range.from) * f64::from(j) / 240.0).collect();
            let deviation = |phi: f64, u: f64| u - target.at(phi - range.from);
            let name = self.assignment.names.ranges.get(i).cloned().unwrap_or_else(|| format!("range {}", i + 1));
            let name = if self.elastic.is_some() { format!("{name}, at rest") } else { name };
            // From 0 on: the part before it stands at the end of the turn, after a gap in the line.
            let mut points: Vec<[f64; 2]> = Vec::new();
            for phi in &angles {
                let folded = deg(phi.rem_euclid(TAU));
                let goes_back = points.last().is_some_and(|last| folded < last[0]);
                points.extend(goes_back.then_some([f64::NAN; 2]));
                points.push([folded, deviation(*phi, self.cam.at(*phi).0[0])]);
            }
            series.push(Series::line(name, points));
            // Over the speeds the output fills a band.
            if let Some(behind) = self.elastic.as_ref().filter(|behind| !behind.outputs.is_empty()) {
                let side = |side: usize, turn: f64| {
                    angles.iter().map(move |phi| [deg(phi + turn), deviation(*phi, behind.envelope(*phi)[side])])
                };
                let around = |turn: f64| side(0, turn).chain(side(1, turn).rev()).collect();
                rules.extend([-TAU, 0.0, TAU].map(|turn| Rule::Area(around(turn), Shade::Pale)));
            }
        }
        if let Some(behind) = self.elastic.as_ref().filter(|_| !rules.is_empty()) {
            let [slowest, fastest] = behind.looked_at;
            rules.push(Rule::Key(Some(Shade::Pale), format!("output, η from {slowest:.4} to {fastest:.4}")));
        }
        let what = if self.elastic.is_some() { "y" } else { "U" };
        let label = format!("Deviation {what} − Ũ [m]");
        let title = format!("Deviation of {} from what is prescribed", self.assignment.name);
        let axes = [Axis::angular("Angle φ [°]").between(0.0, 360.0), Axis::linear(&label)];
        Diagram::new(title, axes, series, rules)
    }

    /// The amplitudes of the harmonics.
    fn harmonics_diagram(&self) -> Diagram {
        // The profile last, on top of the others.
        let series = self.rivals.iter().cycle().skip(1).take(self.rivals.len()).map(|rival| {
            let size = |k: usize| (rival.series.a[k].powi(2) + rival.series.b[k].powi(2)).sqrt();
            let last = rival.series.order().min(30);
            Series::dots(
                &rival.name,
                (1..=last).map(|k| [k as f64, size(k)]).filter(|p| p[1] > 1e-9 * self.assignment.unit),
            )
        });
        let title = format!("Harmonics of {} and of the standard laws", self.assignment.name);
        let axes = [Axis::linear("Harmonic k [1]"), Axis::logarithmic("Amplitude √(a² + b²) [m]")];
        Diagram::new(title, axes, series.collect(), Vec::new())
    }

    /// The deviation behind the elastic output member over the speed.
    fn speed_diagram(&self) -> Diagram {
        let (mut series, mut rules) = (Vec::new(), Vec::new());
        let seen = LEAST * self.assignment.unit..0.3 * self.assignment.unit;
        if let (Some(behind), Some(given)) = (&self.elastic, &self.assignment.elasticity) {
            let drawn = |(i, name): (usize, &str)| i == 0 || DRAWN.contains(&name) || name == "polynomial_4567";
            let curves = self.rivals.iter().zip(&behind.curves).enumerate();
            for (_, (rival, curve)) in curves.filter(|(i, (rival, _))| drawn((*i, &rival.name))) {
                let points = curve.iter().map(|[eta, d]| [*eta, *d]).filter(|p| seen.contains(&p[1]));
                // Without damping laws that resonate at every speed have no curve.
                series.extend((!curve.is_empty()).then(|| Series::line(&rival.name, points)));
            }
            rules.extend(given.tolerance.map(|t| Rule::Horizontal(t, "tolerance".to_owned())));
            rules.extend(behind.reached.map(|eta| Rule::Vertical(eta, "reached".to_owned())));
            rules.extend(given.fastest.map(|w| Rule::Vertical(w / given.w0, "asked for".to_owned())));
        }
        let label = "Largest deviation |y − Ũ| [m]";
        let axes = [Axis::linear("Speed over natural frequency η [1]"), Axis::logarithmic(label)];
        Diagram::new(format!("Deviation of {} over the speed", self.assignment.name), axes, series, rules)
    }

    /// The largest shaft torque over m Ω² over the speed.
    fn shaft_speed_diagram(&self, shaft: &Shafted) -> Diagram {
        let point = |w: f64, torque: f64| [w * 60.0 / TAU, torque / (shaft.goal.shaft.m * w * w)];
        let laws = self.rivals.iter().zip(&shaft.laws);
        let curve = laws.map(|(rival, law)| Series::line(&rival.name, law.points.iter().map(|p| point(p[0], p[1]))));
        let mut curves: Vec<Series> = curve.collect();
        let nonlinear = shaft.nonlinear.iter().filter_map(|at| Some(point(at.w, *at.torque.as_ref().ok()?)));
        curves.push(Series::dots("harmonic synthesis, nonlinear", nonlinear));
        let title = format!("Torque in the elastic shaft of {} over the speed", self.assignment.name);
        Diagram::new(title, [Axis::linear("Speed [rpm]"), Axis::linear("max |M| / (m Ω²) [m²]")], curves, Vec::new())
    }

    /// The shaft torque over the turn at the fastest speed, and the kinetostatic one of the profile.
    fn shaft_torque_diagram(&self, shaft: &Shafted) -> Diagram {
        let drawn = |(i, name): (usize, &str)| i == 0 || DRAWN.contains(&name);
        let laws = self.rivals.iter().zip(&shaft.torques).enumerate();
        let mut series: Vec<Series> = laws
            .filter(|(i, (rival, _))| drawn((*i, &rival.name)))
            .filter_map(|(_, (rival, torque))| Some((rival, torque.as_ref()?)))
            .map(|(rival, torque)| self.over_the_turn(&rival.name, |phi| torque.at(phi).0[0]))
            .collect();
        let inertia = shaft.goal.shaft.m * shaft.goal.fastest.powi(2);
        series.push(self.over_the_turn("kinetostatic, harmonic synthesis", |phi| {
            let [_, first, second, ..] = self.cam.at(phi).0;
            -inertia * first * second
        }));
        let title = format!("Torque in the elastic shaft of {} at the fastest speed", self.assignment.name);
        Diagram::new(title, [Axis::angular("Angle φ [°]"), Axis::linear("Torque M [N·m]")], series, Vec::new())
    }

    /// Bild 4.24.
    fn widths_diagram(&self) -> Diagram {
        let mut series: Vec<Series> = Vec::new();
        for (column, words) in [(1, "Chebyshev"), (2, "least squares")] {
            series.extend(self.widths.iter().map(|curve| {
                let points = curve.points.iter().map(|p| [deg(p[0]), p[column]]).filter(|p| p[1] > LEAST);
                Series::line(format!("K = {}, {words}", curve.order), points)
            }));
        }
        let mut rules = Vec::new();
        if let Some((half, _)) = symmetric_dwells(&self.assignment.task) {
            rules.push(Rule::Vertical(2.0 * deg(half), "this task".to_owned()));
        }
        let axes = [Axis::angular("Dwell width 2Δφ [°]"), Axis::logarithmic("Largest deviation over stroke [1]")];
        Diagram::new("Dwell error of symmetric dwells over their width, after K harmonics", axes, series, rules)
    }
}
