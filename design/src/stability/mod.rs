//! Kinetic stability: at which speeds the coefficients that vary over the turn make a drive vibrate by themselves, how much
//! damping prevents it, and how large the vibrations are.
//!
//! [`study`] treats any drive that is an oscillator with periodic coefficients ([`crate::oscillator`]). It finds the Floquet
//! multipliers at a speed; the boundaries of the instability of every order by Hill's eigenproblem ([`hill`] numbers them,
//! [`tongue`] makes them exact); the damping and the modulation at which each vanishes; the printed approximations
//! ([`printed`]); maps over speed and damping, speed and modulation ([`map`]); and the motion under load ([`response`]).
//! [`report`] and [`figures`] show the findings.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, sections 4.5 and 4.6.3.

pub mod figures;
pub mod hill;
pub mod map;
pub mod modulation;
mod orders;
pub mod printed;
pub mod report;
pub mod response;
pub mod system;
#[cfg(test)]
mod tests;
pub mod tongue;

use crate::formulas::instability::{Bounds, Harmonics};
use crate::oscillator::{self, PeriodicOscillator, Terms};
use crate::periodic_turn::{self, NEUTRAL};
use crate::report::Verdict;
use crate::report::terminal::shown;
use crate::report::unit::RPM;
use crate::resource::{Resource, Scene};
use crate::text::number;
use crate::{Progress, overview, parallel, search, work};
use camdrive::drives::Fault;
use map::{Instability, Modulation, Region};
use orders::{Tongues, tongues};
use response::{PeriodicMotion, Resonance, Transient};
use serde::Serialize;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};
use system::{System, Unfollowed};
use tongue::{Extent, multipliers, spectral_radius};

/// Options of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Speeds Ω (rad/s) at which stability and motion are examined; the scene's if empty. [`study_scene`] also takes the speeds
    /// of a drive that turns backwards.
    pub speeds: Vec<f64>,
    /// The speeds between which maps and amplification are drawn (rad/s), the slower one first.
    pub range: Option<[f64; 2]>,
    /// The number of orders to examine; by default as many as belong to the speeds, at least eight.
    pub orders: Option<usize>,
    /// The damping ratio θ instead of the scene's.
    pub damping: Option<f64>,
    /// The modulation at the upper edge of its map.
    pub modulation: Option<f64>,
    /// Without the maps.
    pub quick: bool,
}

/// Orders that are always examined.
const LEAST_ORDERS: usize = 8;
/// The highest order that is examined without a request: tongues of higher ones are narrow, and each takes some hundredths of a
/// second.
const USUAL_ORDERS: usize = 40;
/// The highest order that can be examined: Hill's matrices would need too many harmonics beyond it.
pub const MOST_ORDERS: usize = 120;
/// The upper edge of that map in multiples of the scene's modulation, and the greatest part of the way from there to the
/// modulation at which the inertia vanishes.
const USUAL_MODULATION: f64 = 1.5;
const GREATEST_MODULATION: f64 = 0.98;
/// At least so many orders are listed.
const FIRST_ORDERS: usize = 6;
/// Orders whose θ/θ* is above this one are summed up.
const SAFE: f64 = 100.0;
/// Speeds at which the amplification is evaluated before its peaks are searched.
const SPEEDS: usize = 240;
/// The motion next to an unstable speed is evaluated this part of the speed away: far above rounding, and within a line of a
/// diagram.
const BESIDE: f64 = 1e-4;
/// Harmonics of the load among which resonances are listed.
const RESONANCES: usize = 40;
/// Residual of |1 ∓ tr M + det M| away from any boundary: far above rounding.
const LOST: f64 = 1e-6;
/// The note on a drive that turns backwards.
const BACKWARDS: &str = "The drive turns backwards: all speeds are magnitudes in this sense.";
/// The definition of θ for a damping that is negative somewhere.
const ACTIVE: &str = "The damping is negative over a part of the turn. θ is the ratio of the constant damping with the \
     same decay over a turn, mean(b/m)/mean(1/m); its variation stays at every θ, also \"without damping\".";
/// Free motions that change in a turn by less than this part neither grow nor decay.
const BORDER: f64 = 1e-12;
/// Orders below this θ* are ignored: it is orders of magnitude below any machine's damping.
pub const NEGLIGIBLE: f64 = 1e-12;

/// The result of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StabilityAnalysis {
    /// The name of the scene.
    pub scene: String,
    /// The drive model.
    pub model: String,
    /// The difference between the equation and the scene's.
    pub note: Option<String>,
    /// The units of q and of the load.
    pub units: [&'static str; 2],
    /// The oscillator.
    pub oscillator: Oscillator,
    /// The eigenproblem of the orders.
    pub eigenproblem: Eigenproblem,
    /// Stability at each speed.
    pub speeds: Vec<AtSpeed>,
    /// The instabilities by order.
    pub orders: Vec<Order>,
    /// The motion of the nonlinear equation at each speed; none for a linear drive.
    #[serde(skip)]
    pub nonlinear: Vec<Nonlinear>,
    /// Starts from rest at each speed; None if the motion leaves the range of numbers.
    pub transients: Vec<Option<Transient>>,
    /// φ (rad), load M and kinetostatic load M₀ of the periodic motion over the turn at each speed; M is NaN if the drive is
    /// unstable.
    #[serde(skip)]
    pub courses: Vec<Vec<[f64; 3]>>,
    /// The periodic motion over the speed.
    pub amplification: Vec<PeriodicMotion>,
    /// The resonances of the load in the range of speeds of the amplification.
    pub resonances: Vec<Resonance>,
    /// The map over damping.
    pub over_damping: Vec<Region>,
    /// The map over modulation.
    pub over_modulation: Vec<Region>,
    /// The borders of the three terms in the map over damping.
    pub approximate_over_damping: Vec<Region>,
    /// The ranges of η, θ and μ that the maps show.
    pub ranges: [[f64; 2]; 3],
    /// θ* of a parallel crank over its stiffness.
    pub crank: Option<printed::Crank>,
}

/// The oscillator as numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Oscillator {
    /// ω₀ = √(c₀/m₀) (rad/s).
    pub natural_frequency: f64,
    /// θ = b₀/(2 m₀ ω₀).
    pub damping_ratio: f64,
    /// m₀, coherent SI.
    pub mean_inertia: f64,
    /// c₀, coherent SI.
    pub mean_stiffness: f64,
    /// The number of periods of the coefficients in a turn; 0 if they do not vary.
    pub periods_per_turn: usize,
}

/// The truncation of Hill's matrices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Eigenproblem {
    /// Harmonics on either side.
    pub harmonics: usize,
    /// The relative change of a boundary when their number was doubled; the exact boundaries do not depend on it.
    pub change: f64,
    /// The largest residual |1 ∓ tr M + det M| at an exact boundary, relative to the entries of M.
    pub residual: f64,
    /// True if a monodromy matrix could not be computed, so that some numbers are missing.
    pub incomplete: bool,
    /// True if the map over the modulation and ε/ε* lack the surroundings of a modulation at which the inertia vanishes.
    pub unnumbered: bool,
    /// The first order whose boundaries have not been found, if any; it and those above are left out.
    pub lost: Option<f64>,
}

/// Stability at a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AtSpeed {
    /// Ω (rad/s).
    pub speed: f64,
    /// η.
    pub eta: f64,
    /// The Floquet multipliers over a turn, real and imaginary parts.
    pub multipliers: [[f64; 2]; 2],
    /// The larger modulus.
    pub radius: f64,
    /// True if free motions decay.
    pub stable: bool,
    /// The damping ratio from which on this speed is stable; 0 if it is stable without damping.
    pub critical_damping: f64,
    /// The order to whose instability without damping the speed belongs.
    pub order: Option<f64>,
    /// The unstable speeds next to it below and above at the damping of the scene: j and Ω (rad/s).
    pub next: [Option<[f64; 2]>; 2],
    /// The motion of the nonlinear equation: "stable", "unstable", "none" if none was found; None for a linear drive.
    pub nonlinear: Option<&'static str>,
}

/// The instability of an order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Order {
    /// j, the vibrations in a turn.
    pub j: f64,
    /// η of the boundaries without damping; the upper one is infinite in an open tongue.
    pub undamped: [f64; 2],
    /// The kind of these speeds.
    pub extent: Extent,
    /// η of the boundaries at the damping of the scene.
    pub damped: Option<[f64; 2]>,
    /// θ*; None if no damping ratio suffices.
    pub critical_damping: Option<f64>,
    /// η at which the last unstable speed vanishes.
    pub critical_eta: Option<f64>,
    /// θ/θ*.
    pub safety: Option<f64>,
    /// ε/ε*: the scene's modulation over the modulation at which the order becomes unstable at the damping of the scene, above
    /// 1 if it is unstable. None without damping, if the order stays stable up to the modulation of the map, and if its θ/θ* is
    /// above a hundred.
    pub modulation_ratio: Option<f64>,
    /// The approximations of θ*.
    #[serde(flatten)]
    pub bounds: Bounds,
    /// η of the borders of the three terms at the damping of the scene.
    pub approximate: Option<[f64; 2]>,
}

/// Counts the steps of a stage, for [`Progress`].
struct Counter<'a> {
    tell: &'a (dyn Fn(Progress) + Sync),
    done: AtomicUsize,
    total: usize,
    stage: &'static str,
}

impl<'a> Counter<'a> {
    fn new(tell: &'a (dyn Fn(Progress) + Sync), stage: &'static str, total: usize) -> Self {
        tell(Progress { done: 0, total, stage });
        Counter { tell, done: AtomicUsize::new(0), total, stage }
    }

    fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.tell)(Progress { done, total: self.total.max(done), stage: self.stage });
    }
}

/// Studies the oscillator of a scene; with a parallel crank θ*(σ) as well.
///
/// # Errors
/// As [`study`], and for more work than a study may take.
pub fn study_scene(
    resource: &Resource,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<StabilityAnalysis, Fault> {
    let hint = "take fewer --orders or harmonics, or leave out the maps with --quick";
    work::within(work::BUDGET, hint, progress, |tell| studied(resource, options, tell))?
}

/// The factor by which free motions of a drive with periodic coefficients grow in a turn of its constant speed, by the linear
/// equation; None for other drives.
pub fn growth(scene: &Scene) -> Option<f64> {
    let oscillator = oscillator::of(scene).ok()?;
    let speed = oscillator.speed.filter(|w| *w != 0.0)?;
    let oscillator = if speed < 0.0 { mirrored(oscillator) } else { oscillator };
    let system = System::new(&oscillator).ok()?;
    let (eta, theta) = (speed.abs() / system.natural_frequency(), system.damping_ratio());
    system.followed(1.0 / (eta * eta), 2.0 * theta / eta).ok()?;
    Some(at_speed(&system, &[], &[], speed.abs(), theta).radius)
}

/// The motion of a nonlinear drive at a speed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Nonlinear {
    /// The factor by which a small disturbance grows in a turn; None without a periodic motion.
    pub radius: Option<f64>,
    /// max |q| and max |M| over the turn.
    pub peaks: [f64; 2],
    /// The judgement of `camdrive check` and `steady`.
    pub judged: Verdict,
}

impl Nonlinear {
    /// The motion of a scene at a speed (rad/s); None for a linear drive.
    fn of(resource: &Resource, speed: f64) -> Option<Self> {
        if !matches!(&resource.scene, Scene::ElasticShaft(shaft) if !shaft.linear) {
            return None;
        }
        let scene = periodic_turn::from_zero(&resource.scene, Some(speed)).ok()?;
        let overview = overview::of(&Resource { scene, ..resource.clone() });
        let turn = overview.turn.as_ref();
        let peak = |name: &str| turn.and_then(|turn| turn.output(name)).map_or(0.0, |of| of.peak().value.abs());
        let radius = turn.map(|turn| turn.growth.map_or(f64::NAN, f64::exp));
        Some(Nonlinear { radius, peaks: ["q", "tau"].map(peak), judged: overview.judgement() })
    }

    /// "stable", "unstable" or, where none was found, "none".
    fn kind(&self) -> &'static str {
        match self.radius {
            Some(radius) if radius.ln() >= NEUTRAL => "unstable",
            Some(_) => "stable",
            None => "none",
        }
    }
}

/// See [`study_scene`].
fn studied(
    resource: &Resource,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<StabilityAnalysis, Fault> {
    let mut oscillator = oscillator::of(&resource.scene)?;
    let own = oscillator.speed.filter(|_| options.speeds.is_empty());
    let turns: Vec<f64> = options.speeds.iter().chain(options.range.iter().flatten()).copied().chain(own).collect();
    let backwards = turns.iter().any(|w| *w < 0.0);
    if let Some(w) = turns.iter().find(|w| backwards && **w > 0.0) {
        return Err(Fault::new(format!(
            "the speed {} and others have opposite signs, with different boundaries",
            shown(*w, &RPM)
        ))
        .hint("examine them one after the other, the range with its sign"));
    }
    let options = &Options {
        speeds: options.speeds.iter().map(|w| w.abs()).collect(),
        range: options.range.map(|r| r.map(f64::abs)),
        ..options.clone()
    };
    if backwards {
        oscillator = mirrored(oscillator);
    }
    let mut report = study([&resource.name, resource.model()], &oscillator, options, progress)?;
    if backwards {
        report.note = Some([report.note.as_deref().unwrap_or_default(), BACKWARDS].join(" ").trim().to_owned());
        for course in &mut report.courses {
            course.iter_mut().for_each(|point| point[0] = TAU - point[0]);
            course.reverse();
        }
    }
    // Another damping is not the scene's.
    for at in report.speeds.iter_mut().filter(|_| options.damping.is_none()) {
        let found = Nonlinear::of(resource, if backwards { -at.speed } else { at.speed });
        at.nonlinear = found.as_ref().map(Nonlinear::kind);
        report.nonlinear.extend(found);
    }
    let counter = Counter::new(progress, "crank", printed::POINTS);
    let crank = if options.quick { None } else { printed::curves(&resource.scene, &|| counter.step()) };
    Ok(StabilityAnalysis { crank, ..report })
}

/// Studies the oscillator of the model `model` of the scene `scene`.
///
/// # Errors
/// Coefficients that make no oscillator, and options without meaning.
pub fn study(
    [scene, model]: [&str; 2],
    oscillator: &PeriodicOscillator,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<StabilityAnalysis, Fault> {
    let system = System::new(oscillator)?;
    let w0 = system.natural_frequency();
    let theta = options.damping.unwrap_or_else(|| system.damping_ratio());
    let own = oscillator.speed.filter(|w| *w > 0.0 && options.speeds.is_empty());
    let speeds: Vec<f64> = options.speeds.iter().copied().chain(own).collect();
    for speed in &speeds {
        let eta = speed / w0;
        let followed = system.followed(1.0 / (eta * eta), 2.0 * theta / eta);
        followed.map_err(|why| unfollowed(why, *speed, eta, theta))?;
    }
    let parts = system.parts;
    let slowest = options.range.iter().map(|range| &range[0]).chain(&speeds).fold(f64::INFINITY, |a, b| a.min(*b)) / w0;
    let wanted = (2.2 / (slowest * parts.max(1) as f64)).ceil().clamp(LEAST_ORDERS as f64, USUAL_ORDERS as f64);
    let orders = if parts == 0 { 0 } else { options.orders.unwrap_or(wanted as usize) };
    let counter = Counter::new(progress, "orders", orders);
    let Tongues { start, known, lost } = tongues(&system, orders, options.orders.is_none().then_some(theta), &counter);

    let classical = system.printed();
    let ranges = ranges(&system, &known, options, &speeds, theta);
    let mut orders: Vec<Order> = known.iter().map(|known| order(&system, known, theta, &classical)).collect();
    let critical = critical_modulations(&system, &orders, theta, ranges[2][1], progress);
    for (order, critical) in orders.iter_mut().zip(&critical) {
        order.modulation_ratio = critical.map(|critical| 1.0 / critical);
    }
    let mut report = StabilityAnalysis {
        scene: scene.to_owned(),
        model: model.to_owned(),
        note: match system.active {
            true => Some([oscillator.note.as_deref().unwrap_or_default(), ACTIVE].join(" ").trim().to_owned()),
            false => oscillator.note.clone(),
        },
        units: [oscillator.coordinate.unit, oscillator.load.unit],
        oscillator: Oscillator {
            natural_frequency: w0,
            damping_ratio: theta,
            mean_inertia: system.mean.m,
            mean_stiffness: system.mean.c,
            periods_per_turn: parts,
        },
        eigenproblem: Eigenproblem {
            harmonics: start.harmonics,
            change: start.change(),
            residual: known.iter().map(|(tongue, _)| tongue.residual).fold(0.0, f64::max),
            incomplete: false,
            unnumbered: false,
            lost,
        },
        speeds: speeds.iter().map(|speed| at_speed(&system, &known, &orders, *speed, theta)).collect(),
        orders,
        ranges,
        ..StabilityAnalysis::default()
    };
    if !options.quick && !known.is_empty() {
        let counter = Counter::new(progress, "map", known.len());
        report.over_damping = map::over_damping(&system, &known, ranges[1][1], &|| counter.step());
        let plan = Modulation { critical: &critical, top: ranges[2][1], theta };
        let counter = Counter::new(progress, "modulation", 80);
        report.over_modulation = map::over_modulation(&system, &plan, &|| counter.step());
        let twice: Vec<usize> = known.iter().map(|(tongue, _)| tongue.n * parts.max(1)).collect();
        report.approximate_over_damping = map::approximate_over_damping(&classical, &twice, ranges[1][1]);
    }
    if system.greatest(&|t| t.f.abs().max(t.f1.abs()).max(t.f2.abs())) > 0.0 {
        report.add_motions(&system, &known, progress);
    }
    report.eigenproblem.incomplete = system.has_failed();
    report.eigenproblem.unnumbered = system.has_unnumbered();
    Ok(report)
}

impl StabilityAnalysis {
    /// The motion under load: over the turn and from rest at each speed, over the speeds, at the resonances.
    fn add_motions(&mut self, system: &System, known: &[Instability], progress: &(dyn Fn(Progress) + Sync)) {
        let Oscillator { natural_frequency: w0, damping_ratio: theta, .. } = self.oscillator;
        let [slowest, fastest] = self.ranges[0];
        let eta = || self.speeds.iter().map(|at| at.speed / w0);
        self.courses = eta().map(|eta| response::course(system, eta, theta).unwrap_or_default()).collect();
        self.transients = eta().map(|eta| response::transient(system, eta, theta)).collect();
        let counter = Counter::new(progress, "motion", SPEEDS);
        self.amplification = amplification(system, self.ranges[0], &self.orders, theta, &|| counter.step());
        let expected = |k: usize| {
            let (tongue, _) = known.iter().find(|(tongue, _)| tongue.j == k as f64 && tongue.lambda.low > 0.0)?;
            Some((2.0 / (tongue.lambda.low + tongue.lambda.high)).sqrt())
        };
        self.resonances =
            response::resonances(system, theta, RESONANCES.min((1.0 / slowest).ceil() as usize), &expected);
        // The list and the diagram show the same speeds.
        self.resonances.retain(|resonance| (slowest..=fastest).contains(&(resonance.speed / w0)));
    }
}

/// The reason why the drive cannot be examined at a speed.
fn unfollowed(why: Unfollowed, speed: f64, eta: f64, theta: f64) -> Fault {
    let at = format!("at {}, η = {}, and the damping ratio {}", shown(speed, &RPM), number(eta), number(theta));
    match why {
        Unfollowed::Range => {
            Fault::new(format!("{at} free motions change by more than the factor e^±700 in a turn, beyond the range of numbers"))
                .hint("examine speeds nearer to the natural frequency, η = 1, or less damping")
        }
        Unfollowed::Cells => Fault::new(format!(
            "{at} a turn cannot be followed to 8 digits: free motions vibrate or decay about {} times in it, or the inertia \
             vanishes up to rounding",
            number(1.0 / eta)
        ))
        .hint("examine speeds nearer to the natural frequency, η = 1"),
    }
}

/// The oscillator of a drive that turns the other way: with its coefficients at −φ, and J′ of the other sign.
fn mirrored(oscillator: PeriodicOscillator) -> PeriodicOscillator {
    let mut breakpoints: Vec<f64> = oscillator.breakpoints.iter().map(|phi| (TAU - phi) % TAU).collect();
    breakpoints.sort_by(f64::total_cmp);
    let (count, first) = (breakpoints.len().max(1), if breakpoints.first() == Some(&0.0) { 1 } else { 2 });
    // The segment that ends where this one begins.
    let of = move |segment: usize| (2 * count - first - segment) % count;
    let PeriodicOscillator { terms, reach, speed, start, .. } = oscillator;
    PeriodicOscillator {
        terms: Box::new(move |segment, phi| {
            let terms = terms(of(segment), -phi);
            Terms { b1: -terms.b1, c1: -terms.c1, f1: -terms.f1, ..terms }
        }),
        breakpoints,
        reach: Box::new(move |segment| reach(of(segment))),
        speed: speed.map(f64::abs),
        start: -start,
        ..oscillator
    }
}

/// The ranges of η, θ and μ that the maps show.
fn ranges(system: &System, known: &[Instability], options: &Options, speeds: &[f64], theta: f64) -> [[f64; 2]; 3] {
    let w0 = system.natural_frequency();
    let told = known.iter().filter(|(_, apex)| apex.is_none_or(|apex| apex.theta > NEGLIGIBLE));
    // Loads resonate with their second harmonic at η = ½, if no tongue lies below.
    let slow = told.clone().map(|(tongue, _)| 1.0 / tongue.lambda.high.sqrt()).fold(0.5, f64::min);
    let fast = told.clone().map(|(tongue, _)| match tongue.is_open() {
        true => 2.0 / tongue.lambda.high.sqrt(),
        false => 1.0 / tongue.lambda.low.sqrt(),
    });
    let fast = fast.fold(1.2, f64::max);
    let own = |fold: fn(f64, f64) -> f64, start: f64| speeds.iter().map(|speed| speed / w0).fold(start, fold);
    let eta = options
        .range
        .map(|r| [r[0] / w0, r[1] / w0])
        .unwrap_or([0.85 * own(f64::min, slow), 1.2 * own(f64::max, fast)]);
    let visible = told.clone().filter(|(tongue, _)| 1.0 / tongue.lambda.high.sqrt() < eta[1]);
    let open = visible.clone().any(|(_, apex)| apex.is_none());
    let highest = visible.filter_map(|(_, apex)| Some(apex.as_ref()?.theta)).fold(1.5 * theta, f64::max);
    let damping = if open { 1.5 * highest.max(0.1) } else { 1.2 * highest.max(1e-3) };
    let greatest = 1.0 + GREATEST_MODULATION * (system.greatest_modulation() - 1.0);
    let modulation = options.modulation.unwrap_or(USUAL_MODULATION).min(greatest);
    [eta, [0.0, damping], [0.0, modulation]]
}

/// An order at the damping ratio θ.
fn order(system: &System, (tongue, apex): &Instability, theta: f64, classical: &Harmonics) -> Order {
    let twice = tongue.n * system.parts.max(1);
    let inverse = |lambda: f64| if lambda > 0.0 { 1.0 / lambda.sqrt() } else { f64::INFINITY };
    let critical = apex.map(|apex| apex.theta);
    Order {
        j: tongue.j,
        undamped: [inverse(tongue.lambda.high), inverse(tongue.lambda.low)],
        extent: tongue.extent(),
        damped: tongue.interval(system, theta),
        critical_damping: critical,
        critical_eta: apex.map(|apex| apex.eta),
        safety: critical.filter(|critical| *critical > NEGLIGIBLE).map(|critical| theta / critical),
        modulation_ratio: None,
        bounds: classical.bounds(twice),
        approximate: classical.borders(twice, theta),
    }
}

/// ε* of each order closest to the scene's modulation, up to `top`; None also for ignored orders.
fn critical_modulations(
    system: &System,
    orders: &[Order],
    theta: f64,
    top: f64,
    progress: &(dyn Fn(Progress) + Sync),
) -> Vec<Option<f64>> {
    if theta <= 0.0 {
        return vec![None; orders.len()];
    }
    let told: Vec<bool> = orders.iter().enumerate().map(|(i, order)| is_listed(i, order)).collect();
    let numbers: Vec<usize> = (1..=orders.len()).filter(|n| told[n - 1]).collect();
    let counter = Counter::new(progress, "modulation ratios", numbers.len());
    let one = |n: &usize| modulation::next(system, *n, theta, top);
    let mut found = parallel::map(&numbers, one, &|| counter.step()).into_iter();
    told.into_iter().map(|told| if told { found.next().flatten() } else { None }).collect()
}

/// True if the order with this index has its own line in the report: the first ones, and those whose damping is not a
/// hundredfold safe.
pub fn is_listed(index: usize, order: &Order) -> bool {
    index < FIRST_ORDERS || order.safety.is_some_and(|safety| safety < SAFE) || order.critical_damping.is_none()
}

/// Stability at the speed Ω.
fn at_speed(system: &System, known: &[Instability], orders: &[Order], speed: f64, theta: f64) -> AtSpeed {
    let eta = speed / system.natural_frequency();
    let m = system.monodromy(1.0 / (eta * eta), 2.0 * theta / eta);
    // The turn is `parts` periods.
    let power = |[re, im]: [f64; 2]| {
        let (modulus, argument) = ((re * re + im * im).sqrt(), im.atan2(re));
        let parts = system.parts.max(1) as f64;
        let (sin, cos) = (parts * argument).sin_cos();
        let modulus = modulus.powf(parts);
        [modulus * cos, if im == 0.0 { 0.0 } else { modulus * sin }]
    };
    let radius = spectral_radius(&m).powi(system.parts.max(1) as i32);
    let lambda = 1.0 / (eta * eta);
    let within = |ends: [f64; 2], eta: f64| ends[0] < eta && eta < ends[1];
    let inside = known.iter().zip(orders).find(|((tongue, _), order)| {
        // Damping that differs over the turn may make speeds next to the undamped instability unstable.
        (tongue.lambda.low < lambda && lambda < tongue.lambda.high)
            || order.damped.is_some_and(|ends| within(ends, eta))
    });
    let ends = orders.iter().filter_map(|order| Some((order.j, order.damped?)));
    let w0 = system.natural_frequency();
    let below = ends.clone().filter(|(_, [_, high])| *high <= eta).max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    let above = ends.filter(|(_, [low, _])| *low >= eta).min_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    AtSpeed {
        speed,
        eta,
        multipliers: multipliers(&m).map(power),
        radius,
        stable: radius < 1.0 - BORDER,
        critical_damping: inside.map_or(0.0, |((tongue, _), _)| tongue.critical_above(system, 1.0 / eta, theta)),
        order: inside.map(|((tongue, _), _)| tongue.j),
        next: [below.map(|(j, [_, high])| [j, w0 * high]), above.map(|(j, [low, _])| [j, w0 * low])],
        nonlinear: None,
    }
}

/// The periodic motion over a range of η: at equal ratios, next to the borders of the unstable speeds, and at the peaks of the
/// amplification between them.
fn amplification(
    system: &System,
    range: [f64; 2],
    orders: &[Order],
    theta: f64,
    done: &(dyn Fn() + Sync),
) -> Vec<PeriodicMotion> {
    let [low, high] = range;
    let eta = |i: usize| low * (high / low).powf(i as f64 / (SPEEDS - 1) as f64);
    let beside = |[from, to]: [f64; 2]| [from * (1.0 - BESIDE), to * (1.0 + BESIDE)];
    let borders = orders.iter().filter_map(|order| order.damped).flat_map(beside);
    let mut places: Vec<f64> = (0..SPEEDS).map(eta).chain(borders.filter(|eta| (low..high).contains(eta))).collect();
    places.sort_by(f64::total_cmp);
    let mut motions: Vec<PeriodicMotion> =
        parallel::map(&places, |eta| response::periodic_motion(system, *eta, theta), done)
            .into_iter()
            .flatten()
            .collect();
    let value = |s: &PeriodicMotion| s.amplification.unwrap_or(0.0);
    let summits: Vec<[f64; 2]> = motions
        .windows(3)
        .filter(|w| value(&w[0]) < value(&w[1]) && value(&w[1]) >= value(&w[2]))
        .map(|w| [w[0].eta, w[2].eta])
        .collect();
    let summit = |ends: &[f64; 2]| {
        let mut f = |eta: f64| response::periodic_motion(system, eta, theta).map_or(0.0, |s| value(&s));
        let (eta, _) = search::maximum(&mut f, *ends, 1e-5 * ends[1]);
        response::periodic_motion(system, eta, theta)
    };
    motions.extend(parallel::map(&summits, summit, done).into_iter().flatten());
    motions.sort_by(|a, b| a.eta.total_cmp(&b.eta));
    motions
}
