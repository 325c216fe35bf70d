//! The findings as a report: whether the machine may run at its speeds, which speeds to avoid, which damping cures.

use super::response::{Resonance, Transient};
use super::tongue::Extent;
use super::{AtSpeed, BORDER, Findings, NEGLIGIBLE, Order, PeriodicMotion, figures, is_listed, printed};
use crate::report::terminal::{range, shown};
use crate::report::unit::{DEG, HZ, ONE, PERCENT, RPM, Unit};
use crate::report::{Level, Report, Rows, Table, Value, Verdict};
use crate::text::{counted, number, rpm};
use camdrive::drives::Fault;

/// An unstable speed nearer than this part of the speed is one to be minded.
const CLOSE: f64 = 0.1;
/// A load so many times its kinetostatic value is told as a resonance.
const LOUD: f64 = 2.0;
/// Speeds to avoid, and resonances, that the verdict lists.
const MOST_TOLD: usize = 6;
/// Free motions that shrink to less than this part of themselves in a turn are gone.
const GONE: f64 = 1e-3;
/// Boundaries are exact where no more than this is left at them, relative to the multipliers.
const EXACT: f64 = 1e-12;
/// Turns.
const TURNS: Unit = Unit::new("turns", 1.0);

impl From<Extent> for Value {
    fn from(extent: Extent) -> Self {
        Value::from(match extent {
            Extent::Bounded => "bounded",
            Extent::Closed => "closed",
            Extent::Open => "open",
            Extent::Absent => "absent",
        })
    }
}

impl Order {
    /// Its boundaries without damping (rad/s); none where it is absent.
    fn undamped_speeds(&self, w0: f64) -> Option<[f64; 2]> {
        (self.extent != Extent::Absent).then(|| self.undamped.map(|eta| eta * w0))
    }
}

impl Findings {
    /// Unstable speeds at the damping of the scene (rad/s), with their orders.
    fn unstable(&self) -> impl Iterator<Item = (&Order, [f64; 2])> {
        let w0 = self.oscillator.natural_frequency;
        self.orders.iter().filter_map(move |order| Some((order, order.damped?.map(|eta| eta * w0))))
    }

    /// The orders that have a line of their own, or those that have none.
    pub(super) fn listed(&self, told: bool) -> impl DoubleEndedIterator<Item = &Order> {
        let orders: Vec<(usize, &Order)> = self.orders.iter().enumerate().collect();
        orders.into_iter().filter(move |(i, order)| is_listed(*i, order) == told).map(|(_, order)| order)
    }

    /// The answer.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        for (i, at) in self.speeds.iter().enumerate() {
            self.judge(at, &mut verdict);
            if let Some(motion) = self.transients.get(i).and_then(|transient| Some(&transient.as_ref()?.steady)) {
                self.judge_load(motion, &mut verdict);
            }
        }
        if self.oscillator.periods_per_turn == 0 {
            verdict.result(
                Level::Good,
                "The coefficients do not vary over the turn: no speed excites the drive by its parameters.",
            );
        }
        self.advise(&mut verdict);
        self.certify(&mut verdict);
        verdict
    }

    /// Whether the drive may run at a speed, and how far it is to the next unstable one.
    fn judge(&self, at: &AtSpeed, verdict: &mut Verdict) {
        let speed = rpm(at.speed);
        if at.radius > 1.0 + BORDER {
            let growth = match at.radius {
                radius if radius < 2.0 => format!("by {}", shown(radius - 1.0, &PERCENT)),
                radius => format!("{} times", number(radius)),
            };
            verdict.result(
                Level::Bad,
                format!("At {speed} rpm the machine must not run: free motions grow {growth} a turn."),
            );
            if at.critical_damping > 0.0 {
                let now = number(self.oscillator.damping_ratio);
                verdict.advice(format!(
                    "At {speed} rpm a damping ratio above {} is needed (now {now}), or another speed.",
                    number(at.critical_damping)
                ));
            }
            return;
        }
        let [below, above] = at.next.map(|next| next.map(|[_, speed]| speed));
        let next = [(below, "below"), (above, "above")].map(|(next, side)| {
            let next = next?;
            Some(format!("{} rpm ({} {side})", rpm(next), shown((next / at.speed - 1.0).abs(), &PERCENT)))
        });
        let next: Vec<String> = next.into_iter().flatten().collect();
        let next = match next.len() {
            0 => String::new(),
            1 => format!("; the next unstable speed is {}", next[0]),
            _ => format!("; the next unstable speeds are {}", next.join(" and ")),
        };
        let near = [below, above].iter().flatten().any(|next| (next / at.speed - 1.0).abs() < CLOSE);
        if !at.stable {
            verdict.result(Level::Mind, format!("At {speed} rpm free motions neither grow nor decay, undamped{next}."));
            return;
        }
        let decay = if at.radius < GONE {
            format!("more than {}", shown(1.0 - GONE, &PERCENT))
        } else {
            shown(1.0 - at.radius, &PERCENT)
        };
        let level = if near { Level::Mind } else { Level::Good };
        verdict
            .result(level, format!("At {speed} rpm the machine may run: free motions decay by {decay} a turn{next}."));
        if at.critical_damping > 0.0 {
            let least = number(at.critical_damping);
            verdict.certainty(format!("At {speed} rpm a damping ratio below {least} would make it unstable."));
        }
    }

    /// How much more than the kinetostatic load the elastic member bears.
    fn judge_load(&self, motion: &PeriodicMotion, verdict: &mut Verdict) {
        let Some(ratio) = motion.amplification.filter(|_| motion.stable) else { return };
        let level = if ratio < LOUD { Level::Good } else { Level::Mind };
        let load = shown(motion.load, &Unit::of(self.units[1]));
        verdict
            .result(level, format!("There the load reaches {load}, {} times its kinetostatic value.", number(ratio)));
    }

    /// Speeds to avoid, and the damping from which there are none.
    fn advise(&self, verdict: &mut Verdict) {
        let theta = self.oscillator.damping_ratio;
        let unstable: Vec<String> =
            self.unstable().map(|(order, ends)| format!("{} (order {})", range(ends, &RPM), order.j)).collect();
        let more = unstable.len().saturating_sub(MOST_TOLD);
        let more = if more > 0 { format!(", and {} below", counted(more, "interval")) } else { String::new() };
        if !unstable.is_empty() {
            let told = unstable[..unstable.len().min(MOST_TOLD)].join(", ");
            verdict.advice(format!("Avoid {told}{more}."));
            if self.speeds.is_empty() {
                verdict.result(Level::Mind, format!("Unstable in {}.", counted(unstable.len(), "interval of speeds")));
            }
        } else if !self.orders.is_empty() {
            verdict.result(Level::Good, format!("No speed is unstable at the damping ratio {}.", number(theta)));
        }
        let needed = self.orders.iter().filter_map(|order| order.critical_damping).fold(0.0, f64::max);
        let open = self.unstable().find(|(order, _)| order.critical_damping.is_none());
        if let Some((order, [from, _])) = open {
            verdict.advice(format!("No damping makes speeds from {} rpm on stable (order {}).", rpm(from), order.j));
        }
        if needed > theta && needed > NEGLIGIBLE && !unstable.is_empty() {
            let others = if open.is_some() { "all other orders are stable" } else { "all speeds are stable" };
            verdict.advice(format!("From a damping ratio of {} on (now {}) {others}.", number(needed), number(theta)));
        }
        let amplification = |r: &Resonance| r.amplification.filter(|ratio| *ratio >= LOUD && !r.unstable);
        let mut loud: Vec<(f64, f64)> =
            self.resonances.iter().filter_map(|r| Some((r.speed, amplification(r)?))).collect();
        loud.sort_by(|a, b| b.1.total_cmp(&a.1));
        let told: Vec<String> = loud
            .iter()
            .take(MOST_TOLD)
            .map(|(speed, ratio)| format!("{} rpm ({} times the kinetostatic load)", rpm(*speed), number(*ratio)))
            .collect();
        if !told.is_empty() {
            verdict.advice(format!("Keep away from the resonances at {}.", told.join(", ")));
        }
    }

    /// How sure it is.
    fn certify(&self, verdict: &mut Verdict) {
        let (theta, e) = (self.oscillator.damping_ratio, &self.eigenproblem);
        if let Some(note) = &self.note {
            verdict.certainty(note);
        }
        if self.oscillator.periods_per_turn > 0 {
            verdict.certainty(if e.residual > EXACT {
                format!("Boundaries are exact to {} of the multipliers.", number(e.residual))
            } else {
                "Boundaries are exact for the model, to rounding; what is uncertain is its damping.".to_owned()
            });
        }
        let spare = self.orders.iter().filter(|order| order.damped.is_none());
        let next = spare.filter_map(|order| Some((order.critical_damping?, order.critical_eta?)));
        if let Some((critical, eta)) = next.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(next, _)| 2.0 * next > theta) {
            let speed = rpm(eta * self.oscillator.natural_frequency);
            verdict.certainty(format!(
                "Below a damping ratio of {} speeds near {speed} rpm are unstable, too.",
                number(critical)
            ));
        }
        if self.orders.last().is_some_and(|order| order.damped.is_some() && theta > 0.0) {
            verdict.certainty("More unstable speeds lie below those listed: ask for them with --orders.");
        }
        if let Some(j) = e.lost {
            verdict.certainty(format!(
                "Orders from {j} on are left out: inertia or stiffness nearly vanishes, and they are not told apart."
            ));
        }
        if e.unnumbered {
            verdict.certainty(
                "The map over the modulation has gaps: at some modulations inertia or stiffness nearly vanishes.",
            );
        }
        if e.incomplete {
            verdict.certainty(
                "At some speeds free motions leave the range of numbers in a turn, or the inertia vanishes: numbers that \
                 depend on them are missing or coarse.",
            );
        }
    }

    /// The columns of the orders, for people and, of all orders, for a file.
    fn orders<'a>(&'a self, rows: Rows<'a, Order>) -> Rows<'a, Order> {
        let w0 = self.oscillator.natural_frequency;
        let rows = rows
            .column("j", "order", ONE, |o| o.j)
            .column("damped", "unstable at this damping", RPM, move |o| o.damped.map(|ends| ends.map(|eta| eta * w0)))
            .column("undamped", "without damping", RPM, move |o| o.undamped_speeds(w0))
            .column("critical_damping", "stable from damping ratio", ONE, |o| {
                o.critical_damping.unwrap_or(f64::INFINITY)
            })
            .column("critical", "last at", RPM, move |o| {
                o.critical_eta.filter(|_| o.extent == Extent::Bounded).map(|eta| eta * w0)
            })
            .column("safety", "damping over it", ONE, |o| o.safety)
            .hidden("modulation_ratio", ONE, |o| o.modulation_ratio)
            .hidden("extent", ONE, |o| o.extent);
        printed::hidden(rows, w0)
    }

    /// What the table of the orders leaves out.
    fn below_orders(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let (Some(first), Some(last)) = (self.listed(false).next(), self.listed(false).next_back()) {
            let largest = self.listed(false).filter_map(|order| order.critical_damping).fold(0.0, f64::max);
            let which = if first.j == last.j { first.j.to_string() } else { format!("{} to {}", first.j, last.j) };
            lines.push(format!("Order {which}: stable from a damping ratio of {} on.", number(largest)));
        }
        let closed: Vec<String> =
            self.listed(true).filter(|o| o.extent == Extent::Closed).map(|o| o.j.to_string()).collect();
        if !closed.is_empty() {
            lines.push(format!("Order {}: the boundaries coincide, no speed is unstable.", closed.join(", ")));
        }
        lines
    }

    fn transients<'a>(&self, rows: &'a [(f64, &'a Option<Transient>)]) -> Table {
        let [q, load] = self.units.map(Unit::of);
        let of = |value: fn(&Transient) -> f64| move |row: &(f64, &Option<Transient>)| row.1.as_ref().map(value);
        let steady = |value: fn(&PeriodicMotion) -> f64| {
            move |row: &(f64, &Option<Transient>)| {
                row.1.as_ref().map(|t| &t.steady).filter(|steady| steady.stable).map(value)
            }
        };
        Table::of("Start from rest", rows)
            .column("speed", "speed", RPM, |row| row.0)
            .digits(5)
            .column("peak", "largest |q|", q.clone(), |row| {
                row.1.as_ref().map_or(Value::from("unbounded"), |t| t.peak.into())
            })
            .column("amplitude", "steady |q|", q, steady(|s| s.amplitude))
            .column("peak_load", "largest load", load.clone(), of(|t| t.peak_load))
            .column("load", "steady load", load.clone(), steady(|s| s.load))
            .column("kinetostatic", "kinetostatic", load, of(|t| t.steady.kinetostatic))
            .column("amplification", "steady over it", ONE, steady(|s| s.amplification.unwrap_or(f64::NAN)))
            .column("settled_after", "settled after", TURNS, |row| {
                row.1.as_ref().map(|t| t.settled_after.map_or(Value::from("never"), Value::from))
            })
            .into()
    }

    fn of_resonances(&self) -> Table {
        let q = Unit::of(self.units[0]);
        Table::of("Resonances with the harmonics of the load", &self.resonances)
            .column("k", "harmonic", ONE, |r| r.k)
            .column("speed", "speed", RPM, |r| r.speed)
            .column("deflection", "static |q|", q.clone(), |r| r.deflection)
            .column("amplitude", "|q|", q, |r| r.amplitude)
            .column("amplification", "load over kinetostatic", ONE, |r| {
                if r.unstable { "unstable".into() } else { Value::from(r.amplification) }
            })
            .into()
    }

    /// Tables that stand in files alone: boundaries of the maps, load over the turn, motion over the speed.
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
                .column("j", "", ONE, |row| row.1.j)
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

    /// How it was computed.
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
                "Numbered by vibrations in a turn, by Hill's matrices of {} harmonics; boundaries by the monodromy matrix M, \
                 |1 ∓ tr M + det M| ≤ {}. An order is stable at every speed from its critical damping ratio on. The \
                 modulation ratio of the file is the modulation of the coefficients over that from which the order is unstable \
                 at this damping.",
                e.harmonics,
                number(e.residual)
            )]);
        }
        printed::explain(self, report);
    }

    /// The report.
    pub fn report(&self) -> Report {
        let o = &self.oscillator;
        let mut report = Report::new(&self.scene, format!("stability ({})", self.model));
        report.verdict = self.verdict();
        let starts: Vec<(f64, &Option<Transient>)> =
            self.speeds.iter().map(|at| at.speed).zip(&self.transients).collect();
        report
            .table(self.orders(Table::of("Unstable speeds", self.listed(true))).below(self.below_orders()))
            .table(self.orders(Table::file("", &self.orders)))
            .table(self.transients(&starts))
            .table(self.of_resonances())
            .lines(
                "Drive",
                [format!(
                    "Natural frequency {} ({} rpm) of the mean coefficients, which repeat {} a turn; damping ratio {}.",
                    shown(o.natural_frequency, &HZ),
                    rpm(o.natural_frequency),
                    counted(o.periods_per_turn, "time"),
                    number(o.damping_ratio)
                )],
            );
        self.add_files(&mut report);
        self.explain(&mut report);
        report
    }

    /// The findings with the verdict as JSON.
    ///
    /// # Errors
    /// None in practice.
    pub fn json(&self) -> Result<String, Fault> {
        crate::report::json(&self.verdict(), self)
    }
}
