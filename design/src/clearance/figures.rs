//! The diagrams of a report.

use super::ClearanceAnalysis;
use super::borders::borders;
use super::passage::{Clearance, VibrationPoint};
use crate::formulas::passage::Masses;
use crate::plot::{Axis, Diagram, Rule, Series, Shade};
use crate::text::number;

/// The abscissa of passages.
const K: &str = "Dynamic clearance K = s/(|U‴|η³) [1]";
/// The mass ratios of the source's diagram of passage times.
const MASS_RATIOS: [f64; 7] = [0.0, 0.1, 0.3, 1.0, 3.0, 10.0, f64::INFINITY];
/// Points of a smooth curve over some decades.
const POINTS: usize = 200;
/// Laws and passages that a reader can distinguish in a diagram.
const MOST_LAWS: usize = 6;
const MOST_PASSAGES: usize = 3;

/// μ and K between which the map is drawn: the source's, extended to the passages.
pub fn extent(report: &ClearanceAnalysis) -> ([f64; 2], [f64; 2]) {
    let (mut mu, mut k) = ([0.01, 10.0], [0.1, 1000.0]);
    let widen = |ends: &mut [f64; 2], value: f64| *ends = [ends[0].min(0.5 * value), ends[1].max(2.0 * value)];
    widen(&mut mu, report.machine.mu);
    for value in report.laws.iter().flat_map(|study| &study.passages).filter_map(|passage| passage.k) {
        widen(&mut k, value);
    }
    (mu, k)
}

/// (K, τ₁) for the mass ratios of the source's diagram and its K, extended to the passages.
pub fn passage_times(report: &ClearanceAnalysis) -> Vec<(String, Vec<[f64; 2]>)> {
    let k = report.laws.iter().flat_map(|study| &study.passages).filter_map(|passage| passage.k);
    let [low, high] = k.fold([0.1, 50.0], |[low, high]: [f64; 2], k| [low.min(0.5 * k), high.max(2.0 * k)]);
    let curve = |mu: f64| {
        let masses = Masses::new(mu);
        let k = |i: usize| low * (high / low).powf(i as f64 / POINTS as f64);
        (0..=POINTS).map(|i| [k(i), masses.passage_time(k(i))]).collect::<Vec<[f64; 2]>>()
    };
    let name = |mu: f64| if mu.is_infinite() { "∞".to_owned() } else { mu.to_string() };
    MASS_RATIOS.iter().map(|mu| (name(*mu), curve(*mu))).collect()
}

/// The passages of a law with K, for at most as many laws as a reader can distinguish.
fn by_law<'a>(
    report: &'a ClearanceAnalysis,
    point: impl Fn(&Clearance) -> Option<[f64; 2]> + 'a,
) -> impl Iterator<Item = Series> + 'a {
    let laws = report.laws.iter().take(MOST_LAWS);
    laws.map(move |study| Series::dots(format!("passages of {}", study.law), study.passages.iter().filter_map(&point)))
}

/// τ₁ over K for several μ, with the passages of the laws.
pub fn passage_time(report: &ClearanceAnalysis) -> Diagram {
    let curves = passage_times(report).into_iter();
    let mut series: Vec<Series> = curves.map(|(mu, points)| Series::line(format!("μ = {mu}"), points)).collect();
    series.extend(by_law(report, |passage| Some([passage.k?, passage.model.or(passage.formula)?.tau])).map(|series| {
        // The curves follow the formulas.
        Series { name: format!("{}, model", series.name), ..series }
    }));
    let axes = [Axis::logarithmic(K), Axis::linear("Time of passage τ₁ = ω t₁ [1]")];
    Diagram::new(format!("Time of passage of {}", report.scene), axes, series, Vec::new())
}

/// The areas of K and μ in which further impacts follow, with the passages of the laws.
pub fn multiple_impacts(report: &ClearanceAnalysis) -> Diagram {
    let (mu, k) = extent(report);
    let seen = |[x, y]: &[f64; 2]| (k[0]..=k[1]).contains(x) && (mu[0]..=mu[1]).contains(y);
    // The areas go beyond the ends of the axes.
    let beyond = [0.1 * mu[0], 10.0 * mu[1]];
    let (mut rules, mut lines) = (Vec::new(), [Vec::new(), Vec::new()]);
    for border in borders(beyond, 10.0 * k[1]) {
        let mut outline: Vec<[f64; 2]> = border.points.iter().map(|p| [p.k, p.mu]).collect();
        // A point off the diagram ends a line.
        let line = outline.iter().map(|p| if seen(p) { *p } else { [f64::NAN; 2] }).chain([[f64::NAN; 2]]);
        lines[usize::from(border.band.is_some())].extend(line);
        let shade = if border.band.is_some() { Shade::Dark } else { Shade::Pale };
        if border.band.is_none() {
            let far = outline.iter().fold(100.0 * k[1], |far, p| f64::max(far, p[0]));
            outline.extend([[far, beyond[1]], [far, beyond[0]]]);
        }
        rules.push(Rule::Area(outline, shade));
    }
    let [elastic, immediate] = lines;
    let mut series = vec![
        Series::line("contact opens again beyond", elastic),
        Series::line("contact opens at once within", immediate),
    ];
    let ratio = report.machine.mu;
    let differs = |passage: &Clearance| {
        let by = passage.formula.zip(passage.model);
        by.is_some_and(|(formula, model)| formula.sequel != model.sequel)
    };
    let passages = report.laws.iter().take(MOST_LAWS).flat_map(|study| &study.passages).filter(|p| differs(p));
    let points: Vec<[f64; 2]> = passages.filter_map(|passage| Some([passage.k?, ratio])).collect();
    if !points.is_empty() {
        series.push(Series::dots("the model differs", points));
    }
    series.extend(by_law(report, move |passage| Some([passage.k?, ratio])));
    let y = Axis::logarithmic("Mass ratio μ = m1/m2 [1]").between(mu[0], mu[1]);
    let axes = [Axis::logarithmic(K).between(k[0], k[1]), y];
    Diagram::new(format!("Multiple impacts of {}", report.scene), axes, series, rules)
}

/// The passages with the hardest impacts of the scene's law, by formula and model.
fn after_impact(report: &ClearanceAnalysis, value: impl Fn(&VibrationPoint) -> [Option<f64>; 2]) -> Vec<Series> {
    let Some(study) = report.laws.first() else { return Vec::new() };
    let impulse = |p: &Clearance| p.model.or(p.formula).map_or(0.0, |figures| figures.impulse);
    let mut hardest: Vec<&Clearance> = study.passages.iter().filter(|p| !p.course.is_empty()).collect();
    hardest.sort_by(|a, b| impulse(b).total_cmp(&impulse(a)));
    let mut series = Vec::new();
    for passage in hardest.into_iter().take(MOST_PASSAGES) {
        let release = passage.model.or(passage.formula).map_or(0.0, |figures| figures.release);
        for (i, by) in ["formula", "model"].into_iter().enumerate() {
            let points: Vec<[f64; 2]> =
                passage.course.iter().filter_map(|point| Some([point.tau, value(point)[i]?])).collect();
            if !points.is_empty() {
                series.push(Series::line(format!("{}° {by}", number(release.to_degrees())), points));
            }
        }
    }
    series
}

/// Motion over the natural period after an impact.
fn over_time(title: String, label: &str, series: Vec<Series>) -> Diagram {
    let axes = [Axis::linear("Time after the impact τ* = ω t* [1]"), Axis::linear(label)];
    Diagram::new(title, axes, series, Vec::new())
}

/// The deformation over the natural period after the impact.
pub fn deformation(report: &ClearanceAnalysis) -> Diagram {
    let title = format!("Deformation after the impacts of {}", report.scene);
    over_time(title, "Deformation q/s, positive as at the impact [1]", after_impact(report, |point| point.q))
}

/// The contact force over the natural period after the impact.
pub fn force(report: &ClearanceAnalysis) -> Diagram {
    let title = format!("Contact force after the impacts of {}", report.scene);
    over_time(title, "Contact force/(c s), pressing positive [1]", after_impact(report, |point| point.force))
}

/// U″ of the laws over the turn, with the passages of the first one.
pub fn acceleration(report: &ClearanceAnalysis) -> Diagram {
    let laws = report.laws.iter().take(MOST_LAWS);
    let curve = laws.map(|study| Series::line(&study.law, study.course.iter().map(|[phi, u]| [phi.to_degrees(), *u])));
    let mut series: Vec<Series> = curve.collect();
    let crossings = report.laws.iter().take(1).flat_map(|study| &study.passages).filter_map(|p| p.crossing);
    series.push(Series::dots("passages of the scene", crossings.map(|crossing| [crossing.phi.to_degrees(), 0.0])));
    let axes = [Axis::angular("Angle φ [°]"), Axis::linear("U″ [m/rad²]")];
    Diagram::new(format!("Acceleration of {}", report.scene), axes, series, Vec::new())
}
