//! The findings as a report: whether the machine may run at its speeds, which speeds to avoid, which damping helps.

use super::response::Transient;
use super::tongue::Extent;
use super::{
    AtSpeed, BORDER, Nonlinear, Order, Oscillator, PeriodicMotion, StabilityAnalysis, figures, is_listed, printed,
};
use crate::oscillator::LINEARISED;
use crate::periodic_turn::NEVER;
use crate::report::rounding::{Rounded, Rounding};
use crate::report::terminal::shown;
use crate::report::unit::{DEG, HZ, ONE, PERCENT, RPM, Unit};
use crate::report::{Advice, Claim, Level, Report, Rows, Setting, Table, Value, Verdict, WrittenValue};
use crate::text::{counted, digits, digits_beyond, distinguishing, number, sentence};
use camdrive::drives::limits::RESONANCE;
use std::cmp::Ordering;
use std::f64::consts::PI;

/// A warning is due if an unstable speed is closer than this part of the speed.
const CLOSE: f64 = 0.1;
/// A warning is due if a load is this many times its kinetostatic value; resonances of this size are listed.
const LOUD: f64 = 2.0;
/// Speeds to avoid lie within this factor of the working speed: farther ones are passed at most when the machine starts.
const BAND: f64 = 2.0;
/// The number of listed resonances, the nearest ones.
const MOST_TOLD: usize = 3;
/// The linear equation has the coefficients at φ, not at φ + q. A harmonic k of them is then wrong by 1 − cos kq or more; of the
/// sixth, which motions over 60° have, that is 13 % at a twist q of 5° (rad).
const LINEAR: f64 = PI / 36.0;
/// A multiplier this near 1 is 1 within the roundings of a resonance.
const ONES: f64 = 1e-4;
/// Turns.
const TURNS: Unit = Unit::new("turns", 1.0);

/// Significant digits of borders, more where they lie close together.
const DIGITS: usize = 3;
/// Significant digits of a speed that stays as it is.
const EXACT: usize = 12;

/// The growth in a turn by this factor, in words.
fn grown(radius: f64) -> String {
    if radius < 2.0 { shown(radius - 1.0, &PERCENT) } else { format!("the factor {}", number(radius)) }
}

/// The sentence on a speed (rad/s) at which free motions grow by this factor in a turn.
pub fn must_not_run(speed: f64, radius: f64) -> String {
    let speed = shown(speed, &RPM);
    format!("The machine must not run at {speed}: free motions grow by {} a turn.", grown(radius))
}

/// The change of free motions in a turn by this factor, in words.
fn changed(radius: f64) -> String {
    if (radius - 1.0).abs() <= BORDER {
        "neither grow nor decay".to_owned()
    } else if radius > 1.0 {
        format!("grow by {} a turn", grown(radius))
    } else {
        format!("decay by {} a turn", shown(1.0 - radius, &PERCENT))
    }
}

/// An error relative to 1; roundings have no size of their own.
fn exactness(error: f64) -> String {
    if error < 1e-12 { "rounding".to_owned() } else { number(error) }
}

impl StabilityAnalysis {
    /// Unstable speeds at the damping of the scene (rad/s), with their orders.
    fn unstable(&self) -> impl Iterator<Item = (&Order, [f64; 2])> {
        let w0 = self.oscillator.natural_frequency;
        self.orders.iter().filter_map(move |order| Some((order, order.damped?.map(|eta| eta * w0))))
    }

    /// The orders with a line of their own, or those without.
    pub(super) fn listed(&self, told: bool) -> impl DoubleEndedIterator<Item = &Order> {
        let orders: Vec<(usize, &Order)> = self.orders.iter().enumerate().collect();
        orders.into_iter().filter(move |(i, order)| is_listed(*i, order) == told).map(|(_, order)| order)
    }

    /// The distance of the interval from the nearest examined speed, as a factor; 1 without such a speed.
    pub(super) fn distance(&self, [from, to]: [f64; 2]) -> f64 {
        let factor = |at: &AtSpeed| (from / at.speed).max(at.speed / to).max(1.0);
        self.speeds.iter().map(factor).reduce(f64::min).unwrap_or(1.0)
    }

    /// True if the drive is not linear, so that most findings are of its linear equation.
    fn is_linearised(&self) -> bool {
        self.note.as_deref().is_some_and(|note| note.starts_with(LINEARISED))
    }

    /// An advice, with the equation that it holds for.
    fn advised(&self, text: String) -> Advice {
        if !self.is_linearised() {
            return Advice::new(text);
        }
        let mut letters = text.chars();
        let first = letters.next().map_or(String::new(), |letter| letter.to_lowercase().to_string());
        Advice::new(format!("By the linear equation: {first}{}", letters.as_str()))
    }

    /// True if the amplitude exceeds the range of the linear equation.
    fn is_beyond(&self, amplitude: f64) -> bool {
        self.units[0] == "rad" && amplitude > LINEAR
    }

    /// The verdict.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        for (i, at) in self.speeds.iter().enumerate() {
            let transient = self.transients.get(i).map(Option::as_ref);
            match self.nonlinear.get(i) {
                Some(found) => self.judge_nonlinear(at, found, transient.flatten(), &mut verdict),
                None => self.judge(at, transient, &mut verdict),
            }
        }
        if self.oscillator.periods_per_turn == 0 {
            verdict.result(
                Level::Good,
                "The coefficients are constant over the turn: no speed excites the drive parametrically.",
            );
        }
        self.advise(&mut verdict);
        self.certify(&mut verdict);
        verdict
    }

    /// Judges a speed by the motion of the nonlinear equation, with the figures of the linear one next to it.
    fn judge_nonlinear(&self, at: &AtSpeed, found: &Nonlinear, transient: Option<&Transient>, verdict: &mut Verdict) {
        let speed = shown(at.speed, &RPM);
        if let ("stable", Some(radius)) = (found.kind(), found.radius) {
            let [q, load] = [0, 1].map(|i| shown(found.peaks[i], &Unit::of(self.units[i])));
            let begin = if found.judged.level == Level::Bad { "At" } else { "The machine may run at" };
            verdict.result(
                found.judged.level,
                format!("{begin} {speed}: the shaft twists by up to {q} and takes up to {load}."),
            );
            if radius < 1.0 {
                verdict
                    .result(Level::Good, format!("A disturbance decays by {} a turn.", shown(1.0 - radius, &PERCENT)));
            }
        }
        verdict.join(found.judged.clone());
        let steady = transient.map(|start| &start.steady).filter(|steady| steady.stable && at.stable);
        let of_load = steady.map_or(String::new(), |steady| {
            format!(", and the load reaches {}", shown(steady.load, &Unit::of(self.units[1])))
        });
        verdict
            .result(Level::Good, format!("Linear equation at {speed}: free motions {}{of_load}.", changed(at.radius)));
        if let Some(peak) = transient.map(|start| start.peak).filter(|peak| at.stable && self.is_beyond(*peak)) {
            let twist = shown(peak, &DEG);
            verdict
                .result(Level::Good, format!("Its shaft twists by {twist}: the linear equation does not hold there."));
        }
    }

    /// Judges a speed: its stability, its load, and its distance from the next unstable speed. The start from rest is None without
    /// a periodic motion.
    fn judge(&self, at: &AtSpeed, transient: Option<Option<&Transient>>, verdict: &mut Verdict) {
        let meets = |[re, im]: &[f64; 2]| (re - 1.0).hypot(*im) < ONES;
        if transient == Some(None) && at.radius < 1.0 + BORDER && at.multipliers.iter().any(meets) {
            verdict.result(Level::Bad, sentence(RESONANCE));
            verdict.advice("Set a damping above 0, or choose another speed.");
            return;
        }
        let transient = transient.flatten();
        let of_next = at.next.iter().flatten().map(|[_, next]| next * RPM.factor);
        let fine = distinguishing(&of_next.chain([at.speed * RPM.factor]).collect::<Vec<f64>>(), EXACT);
        let speed = digits(at.speed * RPM.factor, fine, -4);
        if at.radius > 1.0 + BORDER {
            verdict.result(Level::Bad, must_not_run(at.speed, at.radius));
            return;
        }
        let steady = transient.map(|start| &start.steady).filter(|steady| steady.stable);
        let ratio = steady.and_then(|steady| steady.amplification).unwrap_or(0.0);
        let load = steady.filter(|_| ratio > 0.0).map(|steady| {
            let (load, but) =
                (shown(steady.load, &Unit::of(self.units[1])), if ratio < LOUD { ", and" } else { ", but" });
            let start = transient.map_or(0.0, |start| start.peak_load);
            let start = match start > steady.load * (1.0 + CLOSE) {
                true => format!(" ({} starting from rest)", shown(start, &Unit::of(self.units[1]))),
                false => String::new(),
            };
            let of = if self.is_linearised() { "the linearised load" } else { "the load" };
            format!("{but} {of} reaches {load}, {} times its kinetostatic value{start}", number(ratio))
        });
        let decay = match at.stable {
            true => format!("Free motions {}.", changed(at.radius)),
            false => sentence(NEVER),
        };
        let near = at.next.iter().flatten().any(|[_, next]| (next / at.speed - 1.0).abs() < CLOSE);
        let level = if near || ratio >= LOUD || !at.stable { Level::Mind } else { Level::Good };
        verdict.result(level, format!("The machine may run at {speed} rpm{}.", load.unwrap_or_default()));
        verdict.result(level, decay);
        let next = |[_, next]: &[f64; 2]| {
            let limit = digits_beyond(next * RPM.factor, fine, *next < at.speed);
            format!("{limit} rpm ({} times the speed)", number(next / at.speed))
        };
        let next: Vec<String> = at.next.iter().flatten().map(next).collect();
        if !next.is_empty() {
            verdict.result(level, format!("Nearest unstable: {}.", next.join(" and ")));
        }
        if let Some(peak) = transient.map(|start| start.peak).filter(|peak| self.is_beyond(*peak)) {
            let twist = shown(peak, &DEG);
            verdict.result(
                Level::Mind,
                format!("The shaft twists by {twist} at {speed} rpm: the linear equation does not hold there."),
            );
        }
        if at.critical_damping > 0.0 {
            let least = digits_beyond(at.critical_damping, DIGITS, true);
            verdict.certainty(format!("A damping ratio below {least} would make {speed} rpm unstable."));
        }
    }

    /// Adds the speeds to avoid around the examined ones, and the damping that makes all of them stable.
    fn advise(&self, verdict: &mut Verdict) {
        let theta = number(self.oscillator.damping_ratio);
        let count = self.unstable().count();
        let lost = self.eigenproblem.lost;
        // Orders that are left out may be unstable at any speed.
        let level = if lost.is_some() { Level::Mind } else { Level::Good };
        if let (0, Some(highest)) = (count, self.orders.last()) {
            let j = highest.j;
            verdict.result(level, format!("Orders up to {j} are stable at every speed (damping ratio {theta})."));
        } else if let (0, Some(lost)) = (count, lost) {
            verdict.result(level, format!("No order below {lost} is judged: any speed may be unstable."));
        } else if count > 0 && self.speeds.is_empty() {
            verdict.result(Level::Mind, format!("Unstable in {}.", counted(count, "speed interval")));
        }
        let mut near: Vec<(&Order, [f64; 2])> =
            self.unstable().filter(|(_, ends)| self.distance(*ends) <= BAND).collect();
        near.sort_by(|a, b| self.distance(a.1).total_cmp(&self.distance(b.1)));
        if !near.is_empty() {
            self.avoid(&near.iter().map(|(_, ends)| *ends).collect::<Vec<_>>(), verdict);
            self.damp(&near.iter().map(|(order, _)| *order).collect::<Vec<_>>(), verdict);
        }
        let loud = |ratio: &f64| *ratio >= LOUD;
        let mut loud: Vec<(f64, f64)> =
            self.resonances.iter().filter_map(|r| Some((r.speed, r.amplification.filter(loud)?))).collect();
        loud.retain(|(speed, _)| self.distance([*speed; 2]) <= BAND);
        let nearness = |(speed, ratio): &(f64, f64)| (self.distance([*speed; 2]), -ratio);
        loud.sort_by(|a, b| nearness(a).partial_cmp(&nearness(b)).unwrap_or(Ordering::Equal));
        let told: Vec<String> = loud
            .iter()
            .take(MOST_TOLD)
            .map(|(speed, ratio)| format!("{} ({})", shown(*speed, &RPM), number(*ratio)))
            .collect();
        if !told.is_empty() {
            let told = told.join(", ");
            verdict.result(Level::Good, format!("Resonances (amplification of the kinetostatic load): {told}."));
        }
    }

    /// Speeds to avoid (rad/s), and the speed of the scene or the nearest one outside them.
    fn avoid(&self, ends: &[[f64; 2]], verdict: &mut Verdict) {
        let intervals = Rounding::Outward.of(ends, &RPM);
        let advice = self.advised(format!("Avoid {}.", Rounding::Outward.list(&intervals, &RPM)));
        let own = self.speeds.first().map_or(0.0, |at| at.speed);
        let inside = intervals.iter().find(|Rounded { ends: [low, high], .. }| (*low..*high).contains(&own.abs()));
        let written =
            |speed: f64, digits: usize, up: bool| WrittenValue::rounded(speed.copysign(own), &RPM, digits, up);
        let value = match inside {
            Some(Rounded { ends: [low, high], digits }) if own.abs() - low > high - own.abs() => {
                written(*high, *digits, true)
            }
            Some(Rounded { ends: [low, _], digits }) => written(*low, *digits, false),
            None => WrittenValue::nearest(own, &RPM, EXACT),
        };
        let ends = |Rounded { ends: [low, high], digits }: &Rounded| {
            (written(*low, *digits, false), high.is_finite().then(|| written(*high, *digits, true)))
        };
        let speed = Setting::outside("drive.speed", value, intervals.iter().map(ends).collect());
        verdict.advice(advice.set([speed], Claim::Stable { at: Vec::new() }));
    }

    /// The damping from which the speeds of these orders are stable.
    fn damp(&self, orders: &[&Order], verdict: &mut Verdict) {
        let Oscillator { natural_frequency: w0, damping_ratio: theta, mean_inertia, .. } = self.oscillator;
        let most = orders.iter().map(|order| order.critical_damping.unwrap_or(f64::INFINITY)).fold(0.0, f64::max);
        if most.is_infinite() {
            verdict.result(Level::Mind, "Damping alone cannot make all these speeds stable.");
            return;
        }
        let ratio = Setting::at_least("elasticity.damping_ratio", most, &ONE, DIGITS);
        let now = digits_beyond(theta, DIGITS + 1, false);
        let text = format!("Raise the damping ratio to {} (now {now}): these speeds are then stable.", ratio.value);
        let b = |ratio: &WrittenValue| {
            if let WrittenValue::Number(ratio) = ratio { 2.0 * mean_inertia * w0 * ratio } else { f64::NAN }
        };
        let (same, b) = (ratio.value.clone(), b(&ratio.value));
        let ratio = ratio.or("elasticity.b", b).or("crank.damping_ratio", same).or("crank.b_T", b);
        let at = orders.iter().filter_map(|order| Some(order.critical_eta? * w0)).collect();
        verdict.advice(self.advised(text).set([ratio], Claim::Stable { at }));
    }

    /// Adds how certain the verdict is.
    fn certify(&self, verdict: &mut Verdict) {
        let e = &self.eigenproblem;
        verdict.certainty.extend(self.note.clone());
        let more =
            self.orders.last().is_some_and(|order| order.damped.is_some() && self.oscillator.damping_ratio > 0.0);
        let lost = e.lost.unwrap_or_default();
        for (holds, text) in [
            (
                self.oscillator.periods_per_turn > 0 && e.residual > 0.0,
                format!("Boundaries are exact to {} for the model. Its damping is uncertain.", exactness(e.residual)),
            ),
            (more, "There are more unstable speeds below these. List them with --orders.".to_owned()),
            (
                e.lost.is_some(),
                format!(
                    "Orders from {lost} on are left out: inertia or stiffness nearly vanishes and orders cannot be told apart. \
                     They may make any speed unstable. Judge the speeds you need with --speed."
                ),
            ),
            (
                e.unnumbered,
                "The map over the modulation has gaps, where inertia or stiffness nearly vanishes.".to_owned(),
            ),
            (
                e.incomplete,
                "Some numbers are missing or coarse: free motions leave the range of numbers, or the inertia vanishes."
                    .to_owned(),
            ),
        ] {
            verdict.certainty.extend(holds.then_some(text));
        }
    }

    /// The columns of the orders, for people and, of all orders, for a file.
    fn orders<'a>(&'a self, rows: Rows<'a, Order>) -> Rows<'a, Order> {
        let w0 = self.oscillator.natural_frequency;
        let rows = rows
            .column("order", "order", ONE, |o| o.j)
            .column("damped", "unstable at this damping", RPM, move |o| o.damped.map(|ends| ends.map(|eta| eta * w0)))
            .rounded(Rounding::Outward)
            .column("undamped", "without damping", RPM, move |o| {
                (o.extent != Extent::Absent).then(|| o.undamped.map(|eta| eta * w0))
            })
            .rounded(Rounding::Outward)
            .column("critical_damping", "stable from damping ratio", ONE, |o| {
                o.critical_damping.unwrap_or(f64::INFINITY)
            })
            .rounded(Rounding::Outward)
            .hidden("critical", RPM, move |o| {
                o.critical_eta.filter(|_| o.extent == Extent::Bounded).map(|eta| eta * w0)
            })
            .hidden("safety", ONE, |o| o.safety)
            .hidden("modulation_ratio", ONE, |o| o.modulation_ratio)
            .hidden("extent", ONE, |o| format!("{:?}", o.extent).to_lowercase());
        printed::hidden(rows, w0)
    }

    /// A sentence on the orders that the table leaves out.
    fn below_orders(&self) -> Option<String> {
        let (first, last) = (self.listed(false).next()?, self.listed(false).next_back()?);
        let largest = self.listed(false).filter_map(|order| order.critical_damping).fold(0.0, f64::max);
        let which = if first.j == last.j { first.j.to_string() } else { format!("{} to {}", first.j, last.j) };
        Some(format!("Stable with a damping ratio of {} or more: order {which}.", digits_beyond(largest, DIGITS, true)))
    }

    /// The motions of both equations of a drive that is not linear.
    fn both(&self) -> Table {
        let [q, load] = self.units.map(Unit::of);
        let steady = |i: usize| Some(self.transients.get(i)?.as_ref()?.steady).filter(|_| self.speeds[i].stable);
        let rows: Vec<_> = self
            .nonlinear
            .iter()
            .enumerate()
            .flat_map(|(i, found)| {
                let (at, linear) = (self.speeds[i], steady(i));
                let own = found.radius.map(|_| found.peaks);
                [
                    (at.speed, "nonlinear", own, found.radius),
                    (at.speed, "linear", linear.map(|steady| [steady.amplitude, steady.load]), Some(at.radius)),
                ]
            })
            .collect();
        Table::of("Motion by both equations", &rows)
            .column("speed", "speed", RPM, |row| row.0)
            .column("equation", "equation", ONE, |row| row.1)
            .column("amplitude", "largest |q|", q, |row| row.2.map(|peaks| peaks[0]))
            .column("load", "largest load", load, |row| row.2.map(|peaks| peaks[1]))
            .column("multiplier", "multiplier", ONE, |row| row.3)
            .into()
    }

    fn starts(&self) -> Table {
        let [q, load] = self.units.map(Unit::of);
        let steady = |value: fn(&PeriodicMotion) -> f64| {
            move |start: &Transient| Some(&start.steady).filter(|steady| steady.stable).map(value)
        };
        Table::of("Start from rest", self.transients.iter().flatten())
            .column("speed", "speed", RPM, |start| start.speed)
            .column("peak", "largest |q|", q.clone(), |start| start.peak)
            .column("amplitude", "steady |q|", q, steady(|s| s.amplitude))
            .column("peak_load", "largest load", load.clone(), |start| start.peak_load)
            .column("load", "steady load", load.clone(), steady(|s| s.load))
            .column("kinetostatic", "kinetostatic load", load, |start| start.steady.kinetostatic)
            .column("amplification", "steady over kinetostatic", ONE, steady(|s| s.amplification.unwrap_or(f64::NAN)))
            .column("settled_after", "settled after", TURNS, |start| {
                start.settled_after.map_or(Value::from("never"), Value::from)
            })
            .into()
    }

    fn of_resonances(&self) -> Table {
        let q = Unit::of(self.units[0]);
        let beyond = self.resonances.iter().filter_map(|r| r.amplitude).any(|amplitude| self.is_beyond(amplitude));
        let limit = format!(
            "The linear equation does not hold above |q| = {}. Avoid such speeds in any case.",
            shown(LINEAR, &DEG)
        );
        Table::of("Resonances with the harmonics of the load", &self.resonances)
            .column("k", "harmonic", ONE, |r| r.k)
            .column("speed", "speed", RPM, |r| r.speed)
            .column("deflection", "static |q|", q.clone(), |r| r.deflection)
            .column("amplitude", "|q|", q, |r| r.amplitude)
            .column("amplification", "load over kinetostatic", ONE, |r| {
                if r.unstable { "unstable".into() } else { Value::from(r.amplification) }
            })
            .below(beyond.then_some(limit))
            .into()
    }

    /// Adds the tables of the files: boundaries of the maps, load over the turn, motion over the speed.
    fn add_files(&self, report: &mut Report) {
        let w0 = self.oscillator.natural_frequency;
        let [q, load] = self.units.map(Unit::of);
        let maps = [
            ("damping", &self.over_damping),
            ("modulation", &self.over_modulation),
            ("damping, approximate", &self.approximate_over_damping),
        ];
        let regions = maps.into_iter().flat_map(|(name, list)| list.iter().map(move |region| (name, region)));
        let rows: Vec<_> =
            regions.flat_map(|(name, region)| region.lines.iter().map(move |line| (name, region, line))).collect();
        if !rows.is_empty() {
            let table = Table::file("map", &rows)
                .column("map", "", ONE, |row| row.0)
                .column("order", "", ONE, |row| row.1.j)
                .column("damping_ratio", "", ONE, |(_, region, line)| region.theta.unwrap_or(line[0]))
                .column("modulation", "", ONE, |(_, region, line)| region.theta.map_or(1.0, |_| line[0]))
                .column("speed", "", RPM, move |(.., line)| [w0 * line[1], w0 * line[2]]);
            report.table(table).diagram("damping", figures::over_damping(self));
            report.diagram("modulation", figures::over_modulation(self));
        }
        if let Some(crank) = &self.crank {
            report.diagram("crank", figures::crank(self, crank));
        }
        if !self.amplification.is_empty() {
            let table = Table::file("amplification", &self.amplification)
                .column("eta", "", ONE, |s| s.eta)
                .column("speed", "", RPM, move |s| w0 * s.eta)
                .column("amplitude", "", q, |s| s.amplitude)
                .column("load", "", load.clone(), |s| s.load)
                .column("kinetostatic", "", load.clone(), |s| s.kinetostatic)
                .column("amplification", "", ONE, |s| s.amplification)
                .column("stable", "", ONE, |s| s.stable);
            report.table(table).diagram("amplification", figures::amplification(self));
        }
        if !self.courses.is_empty() {
            let courses = self.speeds.iter().zip(&self.courses);
            let rows: Vec<_> =
                courses.flat_map(|(at, course)| course.iter().map(move |point| (at.speed, point))).collect();
            let table = Table::file("load", &rows)
                .column("speed", "", RPM, |row| row.0)
                .column("phi", "", DEG, |row| row.1[0])
                .column("load", "", load.clone(), |row| row.1[1])
                .column("kinetostatic", "", load, |row| row.1[2]);
            report.table(table).diagram("load", figures::load(self));
        }
    }

    /// Adds the method.
    fn explain(&self, report: &mut Report) {
        let multiplier = |[re, im]: [f64; 2]| match im {
            0.0 => number(re),
            im => format!("{} {} {}i", number(re), if im < 0.0 { '-' } else { '+' }, number(im.abs())),
        };
        report.explain_table(
            Table::of("Floquet multipliers over a turn", &self.speeds)
                .column("speed", "speed", RPM, |at| at.speed)
                .digits(5)
                .column("eta", "over natural frequency", ONE, |at| at.eta)
                .column("multipliers", "multipliers", ONE, move |at| at.multipliers.map(multiplier).join(", "))
                .column("radius", "largest modulus", ONE, |at| at.radius)
                .digits(6)
                .column("order", "of order", ONE, |at| at.order),
        );
        let e = &self.eigenproblem;
        if self.oscillator.periods_per_turn > 0 {
            report.explain("Orders", [format!(
                "Orders count the vibrations in a turn (Hill's matrices of {} harmonics). The monodromy matrix M gives the \
                 boundaries, |1 ∓ tr M + det M| ≤ {}. An order is stable at every speed from its critical damping ratio on. \
                 The file's modulation ratio is the modulation of the coefficients, divided by the modulation from which the \
                 order is unstable at this damping.",
                e.harmonics,
                exactness(e.residual)
            )]);
        }
        printed::explain(self, report);
    }

    /// The report.
    pub fn report(&self) -> Report {
        let o = &self.oscillator;
        let mut report = Report::new(&self.scene, format!("stability ({})", self.model));
        report.verdict = self.verdict();
        if !self.nonlinear.is_empty() {
            report.table(self.both());
        }
        report
            .table(self.orders(Table::of("Unstable speeds", self.listed(true))).below(self.below_orders()))
            .table(self.orders(Table::file("", &self.orders)))
            .table(self.starts())
            .table(self.of_resonances())
            .lines(
                "Drive",
                [format!(
                    "Natural frequency {} ({}) of the mean coefficients, which repeat {} a turn; damping ratio {}.",
                    shown(o.natural_frequency, &HZ),
                    shown(o.natural_frequency, &RPM),
                    counted(o.periods_per_turn, "time"),
                    number(o.damping_ratio)
                )],
            );
        self.add_files(&mut report);
        self.explain(&mut report);
        report
    }
}
