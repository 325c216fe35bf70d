//! The diagrams of a report: the two stability maps, the amplification over the speed, θ* of a parallel crank.

use super::StabilityAnalysis;
use super::map::Region;
use super::printed::{Crank, CrankPoint, Curve};
use super::response::Resonance;
use crate::plot::{Axis, Diagram, Rule, Series, Shade};
use crate::report::terminal::shown;
use crate::report::unit;
use crate::text::number;

/// rad/s → rpm.
const RPM: f64 = 60.0 / std::f64::consts::TAU;

/// A word takes this part of the width of a diagram, and this part of its height; a number half of the width.
const WORD: [f64; 2] = [0.1, 0.05];

/// A letter takes this part of the width, and so does the gap between a word and a border.
const LETTER: f64 = 0.016;

/// The name of the speeds of the options or the scene.
const SCENE: &str = "speed examined";

/// The borders by formulas.
const APPROXIMATE: &str = "by formulas (9), (13)";

/// The abscissa of all three: Ω in rpm, between the ends of the report.
fn speed_axis(report: &StabilityAnalysis) -> Axis {
    let rpm = report.oscillator.natural_frequency * RPM;
    let [low, high] = report.ranges[0];
    Axis::logarithmic("Speed [rpm]").between(low * rpm, high * rpm)
}

/// True if a word at this place, in parts of width and height, keeps this distance from the written words; it is then added to
/// them.
fn is_free(written: &mut Vec<[f64; 2]>, place: [f64; 2], [wide, high]: [f64; 2]) -> bool {
    let free = written.iter().all(|other| (other[0] - place[0]).abs() >= wide || (other[1] - place[1]).abs() >= high);
    written.extend(free.then_some(place));
    free
}

/// Elements of a map.
struct Map<'a> {
    report: &'a StabilityAnalysis,
    rules: Vec<Rule>,
    /// True if orders are written to the right of their places, rather than about them.
    beside: bool,
    /// The places of the orders written so far, in parts of width and height.
    words: Vec<[f64; 2]>,
}

impl<'a> Map<'a> {
    /// A map with a horizontal line.
    fn new(report: &'a StabilityAnalysis, line: f64, name: &str, beside: bool) -> Self {
        let rules = vec![Rule::Horizontal(line, String::new()), Rule::Key(None, name.to_owned())];
        Map { report, rules, beside, words: Vec::new() }
    }

    /// The lower and the upper border of a tongue, by rising height.
    fn borders(&self, region: &Region) -> [Vec<[f64; 2]>; 2] {
        let rpm = self.report.oscillator.natural_frequency * RPM;
        let [_, high] = self.report.ranges[0];
        // Infinite speed lies beyond the right end.
        [1, 2].map(|end| region.lines.iter().map(|line| [line[end].min(2.0 * high) * rpm, line[0]]).collect())
    }

    /// The borders of the three terms, dashed.
    fn add_approximate(&mut self, regions: &[Region]) {
        for (i, border) in
            regions.iter().flat_map(|region| self.borders(region)).collect::<Vec<_>>().into_iter().enumerate()
        {
            let name = if i == 0 { APPROXIMATE } else { "" };
            self.rules.push(Rule::Dashed(border, name.to_owned()));
        }
    }

    /// The tongue as an area with its border; its order is written at `named`, η and height.
    fn add(&mut self, region: &Region, shade: Shade, named: Option<[f64; 2]>, top: f64) {
        let [mut outline, mut down] = self.borders(region);
        down.reverse();
        outline.extend(down);
        self.rules.push(Rule::Area(outline.clone(), shade));
        let mut border = outline;
        border.extend(border.first().copied());
        self.rules.push(Rule::Border(border, 1.0));
        if let Some(at) = named {
            self.name(region.j, at, top);
        }
    }

    /// Writes the order at this place if the place is free.
    fn name(&mut self, j: f64, [eta, height]: [f64; 2], top: f64) {
        let [low, high] = self.report.ranges[0];
        // The first word says what the numbers are.
        let (word, width) =
            if self.words.is_empty() { (format!("j = {j}"), WORD[0]) } else { (j.to_string(), 0.5 * WORD[0]) };
        let aside = if self.beside { LETTER * (0.5 * word.chars().count() as f64 + 1.0) } else { 0.0 };
        let eta = eta * (high / low).powf(aside);
        let place = [(eta / low).ln() / (high / low).ln(), height / top];
        if (0.0..1.0).contains(&place[0]) && is_free(&mut self.words, place, [width, WORD[1]]) {
            let rpm = self.report.oscillator.natural_frequency * RPM;
            self.rules.push(Rule::Word([eta * rpm, height], word));
        }
    }
}

/// The scene itself as points of a map at this height.
fn own_points(report: &StabilityAnalysis, height: f64) -> Vec<Series> {
    let points: Vec<[f64; 2]> = report.speeds.iter().map(|at| [at.speed * RPM, height]).collect();
    if points.is_empty() {
        return Vec::new();
    }
    vec![Series::dots(SCENE, points)]
}

/// Unstable speeds over the damping ratio.
pub fn over_damping(report: &StabilityAnalysis) -> Diagram {
    let (top, theta) = (report.ranges[1][1], report.oscillator.damping_ratio);
    let mut map = Map::new(report, theta, "damping of the scene", false);
    map.rules.push(Rule::Key(Some(Shade::Dark), "unstable".to_owned()));
    // The large tongues first, so that they get their order written if only one fits.
    let mut regions: Vec<&Region> = report.over_damping.iter().collect();
    regions.sort_by(|a, b| height(b).total_cmp(&height(a)));
    let [low, high] = report.ranges[0];
    for region in regions {
        let beside = report.approximate_over_damping.iter().filter(|other| other.j == region.j).map(height);
        let summit = region.lines.last().map(|[height, left, right]| {
            let height = beside.fold(*height, f64::max);
            [(left.max(low) * right.min(high)).sqrt(), height.min(top * (1.0 - 1.5 * WORD[1]))]
        });
        map.add(region, Shade::Dark, summit, top);
    }
    map.add_approximate(&report.approximate_over_damping);
    let title = format!("Unstable speeds of {} over the damping ratio", report.scene);
    let axes = [speed_axis(report), Axis::linear("Damping ratio θ [1]").between(0.0, top)];
    Diagram::new(title, axes, own_points(report, theta), map.rules)
}

fn height(region: &Region) -> f64 {
    region.lines.last().map_or(0.0, |line| line[0])
}

/// Unstable speeds over the modulation: without damping, and at the scene's.
pub fn over_modulation(report: &StabilityAnalysis) -> Diagram {
    let top = report.ranges[2][1];
    let mut map = Map::new(report, 1.0, "modulation of the scene", true);
    let theta = number(report.oscillator.damping_ratio);
    map.rules.push(Rule::Key(Some(Shade::Dark), format!("unstable at θ = {theta}")));
    map.rules.push(Rule::Key(Some(Shade::Pale), "unstable if θ = 0".to_owned()));
    let undamped = |region: &&Region| region.theta == Some(0.0);
    for region in report.over_modulation.iter().filter(undamped) {
        // To the right of the foot of the tongue, whichever way it leans.
        let foot = 0.01 * top;
        let borders = region.lines.iter().take_while(|[height, ..]| *height < foot + WORD[1] * top);
        let right = borders.map(|[.., right]| *right).reduce(f64::max);
        let stands = region.lines.first().is_some_and(|[height, ..]| *height < foot);
        map.add(region, Shade::Pale, right.filter(|_| stands).map(|right| [right, foot]), top);
    }
    for region in report.over_modulation.iter().filter(|region| !undamped(region)) {
        map.add(region, Shade::Dark, None, top);
    }
    let title = format!(
        "Unstable speeds of {} over the modulation: pale without damping, dark at the damping ratio {theta}",
        report.scene
    );
    let y = Axis::linear("Modulation of the coefficients, scene = 1 [1]").between(0.0, top);
    Diagram::new(title, [speed_axis(report), y], own_points(report, 1.0), map.rules)
}

/// The largest amplification that is drawn: at the borders of an instability it is infinite.
const LARGEST_AMPLIFICATION: f64 = 100.0;

/// The amplification of the load over the speed, without the unstable speeds.
pub fn amplification(report: &StabilityAnalysis) -> Diagram {
    let w0 = report.oscillator.natural_frequency;
    let [low, high] = report.ranges[0];
    let value = |s: &super::PeriodicMotion| s.amplification.filter(|_| s.stable);
    let drawn: Vec<f64> = report.amplification.iter().filter_map(value).collect();
    let top = 1.3 * drawn.iter().copied().fold(2.0, f64::max).min(LARGEST_AMPLIFICATION);
    let bottom = 0.8 * drawn.iter().copied().fold(1.0, f64::min).max(1e-3);
    let mut rules: Vec<Rule> = Vec::new();
    rules.push(Rule::Key(Some(Shade::Dark), "unstable".to_owned()));
    let unstable: Vec<[f64; 2]> = report.orders.iter().filter_map(|order| order.damped).collect();
    for ends in &unstable {
        let [from, to] = [ends[0].max(low) * w0 * RPM, ends[1].min(high) * w0 * RPM];
        if from < to {
            rules.push(Rule::Area(vec![[from, bottom], [to, bottom], [to, top], [from, top]], Shade::Dark));
        }
    }
    // Names that come first have room: the nearest and the highest.
    let mut resonances: Vec<&Resonance> = report.resonances.iter().collect();
    let rank = |r: &Resonance| report.distance([r.speed; 2]) / r.amplification.unwrap_or(f64::INFINITY).sqrt();
    resonances.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    let name = |(i, k): (usize, usize)| if i == 0 { format!("k = {k}") } else { k.to_string() };
    rules.extend(resonances.iter().enumerate().map(|(i, r)| Rule::Vertical(r.speed * RPM, name((i, r.k)))));
    // One line for each stretch of stable speeds.
    let stretches = report.amplification.chunk_by(|a, b| {
        let between = |ends: &[f64; 2]| a.eta < ends[1] && ends[0] < b.eta;
        value(a).is_some() && value(b).is_some() && !unstable.iter().any(between)
    });
    for stretch in stretches {
        let point = |s: &super::PeriodicMotion| Some([w0 * s.eta * RPM, value(s)?]);
        rules.push(Rule::Border(stretch.iter().filter_map(point).collect(), 2.0));
    }
    let own = report.transients.iter().flatten().filter_map(|t| Some([t.speed * RPM, value(&t.steady)?]));
    let own: Vec<[f64; 2]> = own.collect();
    let own = if own.is_empty() { Vec::new() } else { vec![Series::dots(SCENE, own)] };
    let y = Axis::logarithmic("Amplification R = max |M| / max |M₀| [1]").between(bottom, top);
    let title = format!("Largest load of {} over its kinetostatic value", report.scene);
    Diagram::new(title, [speed_axis(report), y], own, rules)
}

/// Speeds whose loads a reader can distinguish in a diagram.
const MOST_SPEEDS: usize = 3;

/// The load of the elastic member over the turn and the kinetostatic one, M₀ = f + Ω² f₂; for an elastic shaft −m U′U″Ω².
pub fn load(report: &StabilityAnalysis) -> Diagram {
    let unit = report.units[1].replace('.', "·");
    let (name, sign) = if report.units[1] == "N" { ("Force", "F") } else { ("Torque", "M") };
    let mut series = Vec::new();
    for (at, course) in report.speeds.iter().zip(&report.courses).take(MOST_SPEEDS) {
        let speed = shown(at.speed, &unit::RPM);
        let line = |name: &str, of: usize| {
            let points = course.iter().map(|point| [point[0].to_degrees(), point[of]]);
            Series::line(format!("{name}, {speed}"), points)
        };
        series.extend(at.stable.then(|| line(sign, 1)));
        series.push(line("kinetostatic", 2));
    }
    let axes = [Axis::angular("Angle φ [°]").between(0.0, 360.0), Axis::linear(&format!("{name} {sign} [{unit}]"))];
    let title = format!("{name} on the elastic member of {}, steady and kinetostatic", report.scene);
    Diagram::new(title, axes, series, Vec::new())
}

/// θ* of a parallel crank over σ: exact, and dashed by the formula of the source.
pub fn crank(report: &StabilityAnalysis, crank: &Crank) -> Diagram {
    let theta = report.oscillator.damping_ratio;
    let course =
        |curve: &Curve, of: fn(&CrankPoint) -> f64| curve.points.iter().map(|p| [p.sigma, of(p)]).collect::<Vec<_>>();
    let mut rules = vec![Rule::Key(None, "damping of the scene".to_owned()), Rule::Horizontal(theta, String::new())];
    rules.extend(crank.curves.iter().enumerate().map(|(i, curve)| {
        Rule::Dashed(course(curve, |p| p.bounds.printed), if i == 0 { "by formula (7)" } else { "" }.to_owned())
    }));
    let all = || crank.curves.iter().flat_map(|curve| &curve.points);
    let top = 1.1 * all().map(|p| p.bounds.printed.max(p.exact.unwrap_or(0.0))).fold(theta, f64::max);
    for curve in &crank.curves {
        let exact = course(curve, |p| p.exact.unwrap_or(f64::NAN));
        // Below the curve, away from the formula's.
        let [sigma, height] = exact[exact.len() * 3 / 4];
        rules.push(Rule::Word([sigma, height - 1.2 * WORD[1] * top], format!("j = {}", curve.j)));
        rules.push(Rule::Border(exact, 2.0));
    }
    let [low, high] = all().fold([crank.sigma; 2], |[low, high], p| [low.min(p.sigma), high.max(p.sigma)]);
    let axes = [
        Axis::logarithmic("σ = c₁₂/(c_AB R²) [1]").between(low, high),
        Axis::linear("Critical damping ratio θ* [1]").between(0.0, top),
    ];
    let series = vec![Series::dots("scene", [[crank.sigma, theta]])];
    let title =
        format!("Damping beyond which the instabilities of {} vanish: solid exact, dashed by (7)", report.scene);
    Diagram::new(title, axes, series, rules)
}
