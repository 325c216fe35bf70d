//! The report as text, CSV and JSON.

use super::bounds::Bounds;
use super::crank::Curve;
use super::response::PeriodicMotion;
use super::tongue::Extent;
use super::{BORDER, NEGLIGIBLE, Order, Report, TOLERATED, is_listed};
use crate::text::{NONE, Table, csv, digits, number};
use camdrive::drives::Fault;
use std::fmt::Write as _;

/// Said of a drive that turns backwards.
pub const BACKWARDS: &str = "The drive turns backwards: all speeds are for this sense, without their sign.";

/// Definition of θ where the damping is negative somewhere.
pub const ACTIVE: &str = "The damping is negative over a part of the turn. θ is the ratio of the constant damping with the \
     same decay over a turn, mean(b/m)/mean(1/m); its variation stays at every θ, also \"without damping\".";

/// Orders that a sentence lists.
const LISTED: usize = 4;

/// rad/s → rpm.
pub const RPM: f64 = 60.0 / std::f64::consts::TAU;

/// Six significant digits.
pub fn exact(value: f64) -> String {
    if value.is_infinite() || value.is_nan() { "∞".to_owned() } else { digits(value, 6, -4) }
}

/// A range of speeds in rpm, in as many digits as tell its ends apart.
fn interval([low, high]: [f64; 2], w0: f64) -> String {
    let rpm = |eta: f64| eta * w0 * RPM;
    if high.is_infinite() {
        return format!("{} to ∞", number(rpm(low)));
    }
    let (low, high) = (rpm(low), rpm(high));
    let needed = if high > low { (high / (high - low)).log10().ceil().max(0.0) as usize + 2 } else { 6 };
    let digits = needed.clamp(4, 15);
    let decimals = (digits as i32 - 1 - high.log10().floor() as i32).max(0) as usize;
    if high > low { format!("{low:.decimals$} to {high:.decimals$}") } else { format!("{high:.decimals$}") }
}

fn deviation(order: &Order, bound: f64) -> Option<f64> {
    let exact = order.critical_damping?;
    (exact > NEGLIGIBLE || bound > NEGLIGIBLE).then(|| bound / exact - 1.0)
}

/// A bound with its deviation from the exact value where that is more than tolerated.
fn bound(order: &Order, bound: f64) -> String {
    let shown = if bound < NEGLIGIBLE { "0".to_owned() } else { number(bound) };
    match deviation(order, bound) {
        Some(off) if off.abs() > TOLERATED => format!("{shown} ! {}", off_by(off)),
        _ => shown,
    }
}

/// "+3 %", "5.2 times".
fn off_by(off: f64) -> String {
    if off.is_infinite() {
        "instead of 0".to_owned()
    } else if off < 1.0 {
        format!("{:+.0} %", 100.0 * off)
    } else {
        format!("{} times", number(1.0 + off))
    }
}

/// The orders that have a line of their own, or those that have none.
fn orders(report: &Report, told: bool) -> impl DoubleEndedIterator<Item = &Order> {
    let of = move |(index, order): &(usize, &Order)| is_listed(*index, order) == told;
    report.orders.iter().enumerate().filter(of).map(|(_, order)| order).collect::<Vec<_>>().into_iter()
}

/// The orders, without those of no account.
pub fn of_orders(report: &Report) -> Table {
    let w0 = report.oscillator.natural_frequency;
    let head = "j  unstable without damping [rpm]  unstable at this damping [rpm]  θ*  at [rpm]  θ/θ*  ε/ε*  \
                θ* by three terms  θ* of second order";
    let row = |order: &Order| {
        let none = || NONE.to_owned();
        vec![
            order.j.to_string(),
            match order.extent {
                Extent::Closed => format!("closed at {}", interval(order.undamped, w0)),
                Extent::Absent => "at no speed".to_owned(),
                Extent::Bounded | Extent::Open => interval(order.undamped, w0),
            },
            order.damped.map_or_else(none, |ends| interval(ends, w0)),
            order.critical_damping.map_or_else(|| "∞".to_owned(), exact),
            order
                .critical_eta
                .filter(|_| order.extent == Extent::Bounded)
                .map_or_else(none, |eta| number(eta * w0 * RPM)),
            order.safety.map_or_else(none, number),
            order.modulation_ratio.map_or_else(none, number),
            bound(order, order.bounds.three_term),
            bound(order, order.bounds.second_order),
        ]
    };
    Table::new(head, orders(report, true).map(row))
}

/// Notes below the orders: meaning of the columns, and orders that have no line.
pub fn below_orders(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    if report.orders.is_empty() {
        return lines;
    }
    if let (Some(first), Some(last)) = (orders(report, false).next(), orders(report, false).next_back()) {
        let largest = orders(report, false).filter_map(|order| order.critical_damping).fold(0.0, f64::max);
        let which = if first.j == last.j { format!("{}", first.j) } else { format!("{} to {}", first.j, last.j) };
        let amount = if largest > NEGLIGIBLE { format!("θ* up to {}", number(largest)) } else { "θ* = 0".to_owned() };
        lines.push(format!("j = {which}: {amount}; all digits are in the CSV file."));
    }
    lines.push("θ*: damping ratio from which the order is stable at every speed; below θ/θ* = 1 it is not.".to_owned());
    lines.push(if report.oscillator.damping_ratio > 0.0 {
        format!(
            "ε/ε*: modulation of the coefficients over that from which the order is unstable at this damping; {NONE} \
             where it is stable up to {} times the modulation of the scene.",
            exact(report.ranges[2][1].max(1.0))
        )
    } else {
        format!("ε/ε*: {NONE}, since without damping any modulation makes an order unstable.")
    });
    let is_off = |order: &Order, value: f64| deviation(order, value).is_some_and(|off| off.abs() > TOLERATED);
    if orders(report, true)
        .any(|order| is_off(order, order.bounds.three_term) || is_off(order, order.bounds.second_order))
    {
        lines.push(format!("!: off by more than {} % from the exact θ*.", 100.0 * TOLERATED));
    }
    lines
}

/// The formulas of the source beside the exact values, of the orders that have a line.
pub fn of_approximations(report: &Report) -> Table {
    let w0 = report.oscillator.natural_frequency;
    let head = "j  θ*  θ* by (14), (16) as printed  θ* by (9), (10)  unstable at this damping [rpm]  by (9), (13) [rpm]  \
                off by";
    let speeds = |ends: Option<[f64; 2]>| ends.map_or_else(|| "none".to_owned(), |ends| interval(ends, w0));
    let row = |order: &Order| {
        let off = order.damped.zip(order.approximate).filter(|(exact, _)| exact[1].is_finite());
        let percent = |part: f64| format!("{:+.1} %", 100.0 * part);
        let off = off.map(|(exact, near)| [0, 1].map(|end| percent(near[end] / exact[end] - 1.0)).join(", "));
        vec![
            order.j.to_string(),
            order.critical_damping.map_or_else(|| "∞".to_owned(), exact),
            bound(order, order.bounds.printed),
            bound(order, order.bounds.determinant),
            speeds(order.damped),
            speeds(order.approximate),
            off.unwrap_or_else(|| NONE.to_owned()),
        ]
    };
    Table::new(head, orders(report, true).map(row))
}

/// Misprints of the source, with their effect in this scene.
pub fn below_approximations(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    if report.orders.is_empty() {
        return lines;
    }
    let told = |value: f64| if value < NEGLIGIBLE { "0".to_owned() } else { number(value) };
    let cases = |is_one: &dyn Fn(&Order, f64) -> bool, words: &dyn Fn(&Order, String) -> String| {
        let known = orders(report, true).filter_map(|order| Some((order, order.critical_damping?)));
        let cases = known.filter(|(order, exact)| is_one(order, *exact));
        let cases: Vec<String> = cases.map(|(o, exact)| format!("j = {}: {}", o.j, words(o, told(exact)))).collect();
        let more = cases.len().saturating_sub(LISTED);
        let more = if more > 0 {
            format!("; and {more} more order{}", if more > 1 { "s" } else { "" })
        } else {
            String::new()
        };
        Some(cases[..cases.len().min(LISTED)].join("; ") + &more + ".").filter(|_| !cases.is_empty())
    };
    let differs =
        |o: &Order, _| (o.bounds.printed - o.bounds.three_term).abs() > 1e-3 * o.bounds.three_term + NEGLIGIBLE;
    let differently = |o: &Order, exact| {
        format!("{} instead of {}, exact {exact}", told(o.bounds.printed), told(o.bounds.three_term))
    };
    let misprints = cases(&differs, &differently).unwrap_or_else(|| "here both are the same.".to_owned());
    lines.push(format!(
        "Printed wrong: (15), (16) add moduli where the modulus of a complex sum belongs: {misprints} (9) has lost the entry k_j \
         of its first row, (12) the factor Ω of b₂ⱼ; these are corrected here. Borders by them decide nothing."
    ));
    let missed = |o: &Order, exact| exact > NEGLIGIBLE && o.bounds.determinant < (1.0 - TOLERATED) * exact;
    let range = |o: &Order, exact| format!("from θ = {} to {exact}", told(o.bounds.determinant));
    let missed = cases(&missed, &range);
    lines.extend(missed.map(|cases| format!("(9), (13) have no root where the drive is unstable: {cases}")));
    let Some(crank) = &report.crank else { return lines };
    let ratios = |curve: &Curve| {
        let ratios = curve.points.iter().filter_map(|point| Some(point.bounds.printed / point.exact?));
        let [low, high] = ratios.fold([f64::INFINITY, 0.0], |[l, h], ratio| [l.min(ratio), h.max(ratio)]);
        format!("{} to {} at j = {}", number(low), number(high), curve.j)
    };
    lines.push(format!(
        "Parallel crank, σ = c₁₂/(c_AB R²) = {}. Over σ, (7) is {} of the exact θ*.",
        exact(crank.sigma),
        crank.curves.iter().map(ratios).collect::<Vec<_>>().join(", ")
    ));
    if crank.curves.get(2).is_some_and(|curve| curve.j == 3.0) {
        lines.push(
            "The source takes the second term of j = 3 as zero since r₃ = 0, and Ω ≈ ω₀/3 as safe; but r₂ r₄ and r₂³ \
             outweigh r₆, so its formula and the borders miss this order."
                .to_owned(),
        );
    }
    lines
}

/// Sentences before the tables.
pub fn about(report: &Report) -> Vec<String> {
    let o = &report.oscillator;
    let mut lines: Vec<String> = report.note.clone().into_iter().collect();
    lines.push(format!(
        "Natural frequency ω₀ = {} rad/s ({} rpm) of the mean coefficients, damping ratio θ = {}.",
        exact(o.natural_frequency),
        exact(o.natural_frequency * RPM),
        exact(o.damping_ratio)
    ));
    if o.periods_per_turn == 0 {
        lines.push(
            "The coefficients do not vary over the turn: no speed excites the drive by its parameters.".to_owned(),
        );
    } else {
        let e = &report.eigenproblem;
        lines.push(format!(
            "The coefficients repeat {} a turn. Orders numbered by Hill's matrices of {} harmonics; at their \
             boundaries |1 ∓ tr M + det M| ≤ {}.",
            match o.periods_per_turn {
                1 => "once".to_owned(),
                2 => "twice".to_owned(),
                n => format!("{n} times"),
            },
            e.harmonics,
            number(e.residual)
        ));
    }
    lines
}

/// Stability at each speed, in sentences.
pub fn of_speeds(report: &Report) -> Vec<String> {
    let complex = |[re, im]: [f64; 2]| {
        if im == 0.0 {
            exact(re)
        } else {
            format!("{} {} {}i", exact(re), if im < 0.0 { '-' } else { '+' }, exact(im.abs()))
        }
    };
    let sentence = |at: &super::AtSpeed| {
        let mut line = format!("{} rpm (η = {}): ", exact(at.speed * RPM), exact(at.eta));
        line += if at.stable {
            "stable"
        } else if at.radius > 1.0 + BORDER {
            "UNSTABLE"
        } else {
            "on the border, free motions do not decay"
        };
        let _ = write!(
            line,
            "; Floquet multipliers over a turn {}, {}",
            complex(at.multipliers[0]),
            complex(at.multipliers[1])
        );
        let _ = write!(line, "; free motions change by the factor {} in a turn", exact(at.radius));
        if let Some(j) = at.order {
            let critical = exact(at.critical_damping);
            let _ = if at.stable {
                write!(line, "; with less damping than θ = {critical} in the instability of order {j}")
            } else {
                write!(line, "; in the instability of order {j}, stable from θ = {critical} on")
            };
        }
        for (next, side) in at.next.iter().zip(["below", "above"]) {
            if let Some([j, w]) = next {
                let _ = write!(line, "; next unstable speed {side} {} rpm (j = {j})", exact(w * RPM));
            }
        }
        line + "."
    };
    report.speeds.iter().map(sentence).collect()
}

/// Warnings.
pub fn warnings(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    let off = |pick: fn(&Order) -> f64, name: &str| {
        let judged: Vec<(&Order, f64)> =
            orders(report, true).filter_map(|order| Some((order, deviation(order, pick(order))?))).collect();
        let missed: Vec<&(&Order, f64)> = judged.iter().filter(|(_, off)| off.abs() > TOLERATED).collect();
        let (order, off) = missed.iter().max_by(|a, b| ratio(a.1).total_cmp(&ratio(b.1)))?;
        let names: Vec<String> = missed.iter().map(|(order, _)| order.j.to_string()).collect();
        let example = format!(
            "by {} ({} instead of {})",
            off_by(*off),
            if pick(order) < NEGLIGIBLE { "0".to_owned() } else { number(pick(order)) },
            order.critical_damping.map_or_else(|| "∞".to_owned(), number)
        );
        Some(match &names[..] {
            [one] => format!("{name} misses θ* of order {one} {example}: take the exact value."),
            _ => format!(
                "{name} misses θ* of {} of the {} orders listed, j = {}, most that of order {} {example}: take the exact \
                 values.",
                names.len(),
                judged.len(),
                names.join(", "),
                order.j
            ),
        })
    };
    lines.extend(off(|order| order.bounds.three_term, "The classical bound of three terms"));
    lines.extend(off(|order| order.bounds.second_order, "The bound of second order"));
    for order in report.orders.iter().filter(|order| order.critical_damping.is_none()) {
        lines.push(format!(
            "The instability of order {} reaches from {} rpm to infinite speed; no damping ratio removes it.",
            order.j,
            number(order.undamped[0] * report.oscillator.natural_frequency * RPM)
        ));
    }
    if let Some(last) =
        report.orders.last().filter(|order| order.damped.is_some() && report.oscillator.damping_ratio > 0.0)
    {
        lines.push(format!(
            "Order {} is still unstable at this damping; more unstable speeds lie below those listed: ask for them with \
             --orders.",
            last.j
        ));
    }
    if let Some(j) = report.eigenproblem.lost {
        lines.push(format!(
            "The boundaries from order {j} on have not been found: Hill's matrices of {} harmonics do not separate them, \
             since the inertia or the stiffness nearly vanishes; these orders are left out.",
            report.eigenproblem.harmonics
        ));
    }
    if report.eigenproblem.unnumbered {
        lines.push(
            "At some modulations the inertia or the stiffness nearly vanishes, and Hill's matrices do not separate the \
             orders; ε/ε* is missing and the map over the modulation white where it would need them."
                .to_owned(),
        );
    }
    if report.eigenproblem.incomplete {
        lines.push(
            "At some speeds a turn could not be followed: free motions grow or decay beyond the range of numbers, or the \
             inertia vanishes up to rounding. Numbers that depend on them are missing or coarse."
                .to_owned(),
        );
    }
    if report.eigenproblem.residual > 1e-12 {
        lines
            .push(format!("Boundaries are exact to {} of the multipliers only.", number(report.eigenproblem.residual)));
    }
    lines
}

/// How far a deviation is from 0, downwards as upwards.
fn ratio(off: f64) -> f64 {
    (1.0 + off).max(1e-300).ln().abs()
}

/// Starts from rest.
pub fn of_transients(report: &Report) -> Table {
    let [q, load] = report.units;
    let head = format!(
        "speed [rpm]  peak |q| [{q}]  steady |q| [{q}]  peak |M| [{load}]  steady |M| [{load}]  \
         kinetostatic |M| [{load}]  R  settled after [turns]"
    );
    let rows = report.transients.iter().zip(&report.speeds).map(|(transient, at)| {
        let Some(t) = transient else {
            return [exact(at.speed * RPM), "unbounded".to_owned()]
                .into_iter()
                .chain(vec![NONE.to_owned(); 6])
                .collect();
        };
        let s = &t.steady;
        let steady = |value: f64| if s.stable { number(value) } else { NONE.to_owned() };
        vec![
            exact(t.speed * RPM),
            number(t.peak),
            steady(s.amplitude),
            number(t.peak_load),
            steady(s.load),
            number(s.kinetostatic),
            s.amplification.map_or(NONE.to_owned(), steady),
            t.settled_after.map_or("never".to_owned(), number),
        ]
    });
    Table::new(&head, rows)
}

/// The resonances.
pub fn of_resonances(report: &Report) -> Table {
    let q = report.units[0];
    let head = format!("k  speed [rpm]  ω₀/k [rpm]  static |q| [{q}]  static/(2θ) [{q}]  |q| [{q}]  R");
    let row = |r: &super::Resonance| {
        let shown = |value: Option<f64>| match value {
            Some(value) => number(value),
            None => if r.unstable { "unstable" } else { NONE }.to_owned(),
        };
        vec![
            r.k.to_string(),
            number(r.speed * RPM),
            number(r.nominal_speed * RPM),
            number(r.deflection),
            r.estimate.map_or(NONE.to_owned(), number),
            shown(r.amplitude),
            shown(r.amplification),
        ]
    };
    Table::new(&head, report.resonances.iter().map(row))
}

/// Nothing in the place of infinity and of what is no number.
fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

/// The orders, one line each; an upper boundary at infinite speed is empty.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn orders_csv(report: &Report) -> Result<String, Fault> {
    let head = "j,undamped_low_eta,undamped_high_eta,extent,damped_low_eta,damped_high_eta,critical_damping,critical_eta,\
                safety,modulation_ratio,three_term,second_order,printed,determinant,without_mean,approximate_low_eta,\
                approximate_high_eta";
    let both = |ends: Option<[f64; 2]>| [0, 1].map(|end| finite(ends?[end]));
    let row = |o: &Order| {
        let Bounds { three_term, second_order, printed, determinant, without_mean } = o.bounds;
        let bounds = [three_term, second_order, printed, determinant, without_mean].map(finite);
        let critical = [o.critical_damping, o.critical_eta, o.safety, o.modulation_ratio].map(|value| finite(value?));
        (o.j, both(Some(o.undamped)), o.extent, both(o.damped), critical, bounds, both(o.approximate))
    };
    csv(head, report.orders.iter().map(row))
}

/// The boundaries of both maps.
///
/// # Errors
/// None in practice.
pub fn map_csv(report: &Report) -> Result<String, Fault> {
    let w0 = report.oscillator.natural_frequency;
    let head = "map,j,damping_ratio,modulation,low_eta,high_eta,low_rad_per_s,high_rad_per_s";
    let maps = [
        ("damping", &report.over_damping),
        ("modulation", &report.over_modulation),
        ("damping, approximate", &report.approximate_over_damping),
    ];
    let regions = maps.into_iter().flat_map(|(name, list)| list.iter().map(move |region| (name, region)));
    let rows = regions.flat_map(|(name, region)| {
        region.lines.iter().map(move |[height, low, high]| {
            let (theta, modulation) = region.theta.map_or((*height, 1.0), |theta| (theta, *height));
            (name, region.j, [theta, modulation, *low, *high, w0 * low, w0 * high].map(finite))
        })
    });
    csv(head, rows)
}

/// The load over the turn at each speed; M is empty where the drive is unstable.
///
/// # Errors
/// None in practice.
pub fn load_csv(report: &Report) -> Result<String, Fault> {
    let rows = report.speeds.iter().zip(&report.courses);
    let rows = rows.flat_map(|(at, course)| course.iter().map(move |point| (at.speed, point.map(finite))));
    csv("speed_rad_per_s,phi_rad,load,kinetostatic", rows)
}

/// The periodic motion over the speed.
///
/// # Errors
/// None in practice.
pub fn amplification_csv(report: &Report) -> Result<String, Fault> {
    let w0 = report.oscillator.natural_frequency;
    let head = "eta,speed_rad_per_s,speed_rpm,amplitude,load,kinetostatic,amplification,stable";
    let row = |s: &PeriodicMotion| {
        let numbers = [s.eta, w0 * s.eta, w0 * s.eta * RPM, s.amplitude, s.load, s.kinetostatic].map(finite);
        (numbers, s.amplification, s.stable)
    };
    csv(head, report.amplification.iter().map(row))
}
