//! The curves of the stability maps: boundaries over (speed, damping) and over (speed, modulation).
//!
//! Every point of a curve is a boundary found as an eigenvalue on a line across the map, at one damping ratio or one
//! modulation; the lines lie as densely as the picture needs. No grid of the map is evaluated, so the width of a
//! tongue does not matter.

use super::hill;
use super::modulation;
use super::system::System;
use super::tongue::{Apex, Extent, Tongue};
use crate::formulas::instability::Harmonics;
use crate::parallel;
use serde::Serialize;

/// The tongue of an order in a map: at each height (damping ratio or modulation) the lower and the upper speed ratio; the upper
/// one is infinite in an open tongue.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Region {
    /// j.
    pub j: f64,
    /// θ at which it is drawn, in the map over the modulation.
    pub theta: Option<f64>,
    /// (height, η, η), by rising height.
    pub lines: Vec<[f64; 3]>,
}

/// The polygon of a curve misses it by at most this part of the picture's width or height: a third of a line's thickness.
const DEVIATION: f64 = 1e-3;

/// Lines are halved at most so often.
const HALVINGS: usize = 6;

/// The modulations that the second map starts with.
const MODULATIONS: usize = 16;

/// A tongue at the modulation of the scene, and the damping at which it vanishes.
pub type Instability = (Tongue, Option<Apex>);

/// The regions over (speed, damping) up to the damping ratio `top`, of the tongues that reach a visible part of it.
pub fn over_damping(system: &System, known: &[Instability], top: f64, done: &(dyn Fn() + Sync)) -> Vec<Region> {
    let region = |(tongue, apex): &Instability| {
        let end = apex.map_or(top, |apex| apex.theta);
        let mut lines = Vec::new();
        if !tongue.is_empty() && end > DEVIATION * top {
            // Heights end · s (2 − s), because the top of a tongue is round.
            let height = |s: f64| if apex.is_some() { end * s * (2.0 - s) } else { end * s };
            let at = |s: f64| {
                let height = height(s);
                match apex {
                    Some(apex) if s == 1.0 => Some([height, apex.eta, apex.eta]),
                    _ => tongue.interval(system, height).map(|[low, high]| [height, low, high]),
                }
            };
            const FIRST: usize = 8;
            let first: Vec<(f64, [f64; 3])> =
                (0..=FIRST).filter_map(|i| Some((i as f64 / FIRST as f64, at(i as f64 / FIRST as f64)?))).collect();
            lines = refined(first, &at, top);
        }
        Region { j: tongue.j, theta: None, lines }
    };
    let regions = parallel::map(known, region, done);
    regions.into_iter().filter(|region| region.lines.len() > 1).collect()
}

/// Adds lines between the given ones wherever the curves bend.
fn refined(first: Vec<Line>, at: &dyn Fn(f64) -> Option<[f64; 3]>, top: f64) -> Vec<[f64; 3]> {
    let mut refinement = Refinement { at, top, lines: Vec::new() };
    for pair in first.windows(2) {
        refinement.lines.push(pair[0].1);
        refinement.halve(pair[0], pair[1], HALVINGS);
    }
    refinement.lines.extend(first.last().map(|(_, line)| *line));
    refinement.lines
}

type Line = (f64, [f64; 3]);

/// The lines of a region that is being refined, up to the height `top`.
struct Refinement<'a> {
    at: &'a dyn Fn(f64) -> Option<[f64; 3]>,
    top: f64,
    lines: Vec<[f64; 3]>,
}

impl Refinement<'_> {
    /// Adds the lines between two.
    fn halve(&mut self, a: Line, b: Line, depth: usize) {
        let s = 0.5 * (a.0 + b.0);
        let Some(line) = (self.at)(s) else { return };
        if depth > 0 && deviates(&a.1, &line, &b.1, self.top) {
            self.halve(a, (s, line), depth - 1);
            self.lines.push(line);
            self.halve((s, line), b, depth - 1);
        } else {
            self.lines.push(line);
        }
    }
}

/// True if the straight line from `a` to `b` would visibly miss `line` between them.
fn deviates(a: &[f64; 3], line: &[f64; 3], b: &[f64; 3], top: f64) -> bool {
    let part = if b[0] == a[0] { 0.5 } else { (line[0] - a[0]) / (b[0] - a[0]) };
    let misses = |k: usize| {
        // Speeds are drawn by their logarithm; a decade or so fills the width. A miss along a steep curve is a small
        // one across it.
        let (from, to, real) = (a[k].ln(), b[k].ln(), line[k].ln());
        let across = (from + part * (to - from) - real).abs();
        let slope = ((b[0] - a[0]) / top).abs() / (to - from).abs().max(f64::MIN_POSITIVE);
        across.is_finite() && across.min(across * slope) > 2.0 * DEVIATION
    };
    misses(1) || misses(2)
}

/// Extent of the map over the modulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulation<'a> {
    /// For each order n = 1 … a modulation at which it becomes unstable or stable at the damping ratio, if known.
    pub critical: &'a [Option<f64>],
    /// The modulation at the upper edge.
    pub top: f64,
    /// The damping ratio of the second set of boundaries, in addition to those without damping.
    pub theta: f64,
}

/// The tongue of an order at a modulation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TonguePoint {
    n: usize,
    modulation: f64,
    /// The unstable speeds without damping and at the damping ratio of the plan.
    intervals: [Option<[f64; 2]>; 2],
}

/// A modulation at which the tongue of an order appears or vanishes at a damping ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tip {
    /// n.
    n: usize,
    /// The modulation.
    modulation: f64,
    /// η.
    eta: f64,
    /// True if speeds are unstable above this modulation, else below it.
    opens: bool,
}

/// The tongues of these orders at a modulation; Hill's matrices yield all of them at once.
fn row(system: &System, theta: f64, modulation: f64, orders: &[usize]) -> Vec<TonguePoint> {
    let system = system.modulated(modulation);
    let start = hill::boundaries(&system, orders.iter().copied().max().unwrap_or(0));
    let point = |n: &usize| {
        let nothing = TonguePoint { n: *n, modulation, intervals: [None; 2] };
        let Some(tongue) = Tongue::numbered(&system, *n, &start) else {
            system.mark_unnumbered();
            return nothing;
        };
        let closed = || (tongue.extent() == Extent::Closed).then(|| [1.0 / tongue.lambda.high.sqrt(); 2]);
        let damped = if theta > 0.0 { tongue.interval(&system, theta) } else { None };
        TonguePoint { intervals: [tongue.undamped().or_else(closed), damped], ..nothing }
    };
    orders.iter().map(point).collect()
}

/// The tongues at these pairs of modulation and order n, those of a modulation together.
fn points(system: &System, theta: f64, mut places: Vec<(f64, usize)>, done: &(dyn Fn() + Sync)) -> Vec<TonguePoint> {
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let rows: Vec<(f64, Vec<usize>)> =
        places.chunk_by(|a, b| a.0 == b.0).map(|row| (row[0].0, row.iter().map(|place| place.1).collect())).collect();
    parallel::map(&rows, |(modulation, orders)| row(system, theta, *modulation, orders), done).concat()
}

/// The regions over (speed, modulation).
pub fn over_modulation(system: &System, plan: &Modulation, done: &(dyn Fn() + Sync)) -> Vec<Region> {
    let Modulation { critical, top, theta } = *plan;
    let at = |places: Vec<(f64, usize)>| points(system, theta, places, done);
    let first = |i: usize| top * i as f64 / MODULATIONS as f64;
    let mut all = at((1..=MODULATIONS).flat_map(|i| (1..=critical.len()).map(move |n| (first(i), n))).collect());
    let sort =
        |all: &mut Vec<TonguePoint>| all.sort_by(|a, b| a.n.cmp(&b.n).then(a.modulation.total_cmp(&b.modulation)));
    sort(&mut all);
    let tips = if theta > 0.0 { tips(system, plan, &all, done) } else { Vec::new() };
    // At its tip a region is round like a parabola.
    let near = |tip: &Tip| {
        let (n, from) = (tip.n, tip.modulation);
        let room = if tip.opens { top - from } else { -from };
        [1e-4, 2e-3, 1e-2, 4e-2].map(|part| (from + part * room, n))
    };
    all.extend(at(tips.iter().flat_map(near).collect()));
    for _ in 0..2 {
        sort(&mut all);
        let between = |pair: &[TonguePoint]| {
            let middle = 0.5 * (pair[0].modulation + pair[1].modulation);
            let wide = pair[1].modulation - pair[0].modulation > 0.02 * top;
            (pair[0].n == pair[1].n && wide && bends(pair)).then_some((middle, pair[0].n))
        };
        let more = all.windows(2).filter_map(between).collect();
        all.extend(at(more));
    }
    sort(&mut all);
    regions(system, theta, &all, &tips)
}

/// True if a boundary moves by more than three per cent between two points, so that its bend could show.
fn bends(pair: &[TonguePoint]) -> bool {
    let both = pair[0].intervals.iter().zip(&pair[1].intervals);
    both.filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?)))
        .any(|(a, b)| (0..2).any(|k| (a[k] / b[k]).ln().abs() > 0.03))
}

/// The modulations at which each order becomes unstable or stable at the damping ratio; `points` by order and modulation.
fn tips(system: &System, plan: &Modulation, points: &[TonguePoint], done: &(dyn Fn() + Sync)) -> Vec<Tip> {
    let theta = plan.theta;
    let mut crossings: Vec<(usize, [f64; 2], bool)> = Vec::new();
    for own in points.chunk_by(|a, b| a.n == b.n) {
        // Without modulation nothing is unstable.
        let mut below = (0.0, false);
        for point in own {
            let above = (point.modulation, point.intervals[1].is_some());
            if below.1 != above.1 {
                crossings.push((point.n, [below.0, above.0], above.1));
            }
            below = above;
        }
    }
    let tip = |(n, ends, opens): &(usize, [f64; 2], bool)| {
        let known = plan.critical[n - 1].filter(|known| ends[0] < *known && *known <= ends[1]);
        let modulation = known.or_else(|| {
            let margins = ends.map(|modulation| modulation::margin(system, *n, theta, modulation));
            modulation::crossing(system, *n, theta, *ends, margins)
        })?;
        let eta = modulation::least_stable(system, *n, theta, modulation)?;
        Some(Tip { n: *n, modulation, eta, opens: *opens })
    };
    parallel::map(&crossings, tip, done).into_iter().flatten().collect()
}

/// The regions of these points, by order and modulation, and tips.
fn regions(system: &System, theta: f64, points: &[TonguePoint], tips: &[Tip]) -> Vec<Region> {
    let mut regions = Vec::new();
    for (which, theta) in [0.0, theta].into_iter().enumerate() {
        for own in points.chunk_by(|a, b| a.n == b.n) {
            let n = own[0].n;
            let j = 0.5 * (n * system.parts.max(1)) as f64;
            let tip = |opens: bool| tips.iter().filter(move |tip| tip.n == n && tip.opens == opens && which == 1);
            // A tongue may vanish and appear again: each stretch is a region of its own.
            let mut lines: Vec<[f64; 3]> = if which == 0 { vec![[0.0, 1.0 / j, 1.0 / j]] } else { Vec::new() };
            let mut finish = |lines: &mut Vec<[f64; 3]>| {
                let lines = std::mem::take(lines);
                if lines.len() > 1 {
                    regions.push(Region { j, theta: Some(theta), lines });
                }
            };
            let mut last = 0.0;
            for point in own {
                let between = |tip: &&Tip| last <= tip.modulation && tip.modulation <= point.modulation;
                let line = |tip: &Tip| [tip.modulation, tip.eta, tip.eta];
                match point.intervals[which] {
                    Some([low, high]) => {
                        if lines.is_empty() {
                            lines.extend(tip(true).find(between).map(line));
                        }
                        lines.push([point.modulation, low, high]);
                    }
                    None => {
                        if !lines.is_empty() {
                            lines.extend(tip(false).find(between).map(line));
                        }
                        finish(&mut lines);
                    }
                }
                last = point.modulation;
            }
            finish(&mut lines);
        }
    }
    regions
}

/// Heights at which an approximate border is drawn: it is smooth, and each takes some microseconds.
const HEIGHTS: usize = 64;

/// The borders of the three terms over (speed, damping) up to the damping ratio `top`, of the orders j = `twice`/2.
pub fn approximate_over_damping(harmonics: &Harmonics, twice: &[usize], top: f64) -> Vec<Region> {
    let region = |twice: &usize| {
        let [x, end] = harmonics.summit(*twice);
        let j = 0.5 * *twice as f64;
        let height = |i: usize| i as f64 / HEIGHTS as f64;
        let line = |s: f64| {
            let height = end * s * (2.0 - s);
            harmonics.borders(*twice, height).map(|[low, high]| [height, low, high])
        };
        let mut lines: Vec<[f64; 3]> = (0..HEIGHTS).filter_map(|i| line(height(i))).collect();
        lines.push([end, x.sqrt() / j, x.sqrt() / j]);
        (end > DEVIATION * top).then_some(Region { j, theta: None, lines })
    };
    twice.iter().filter_map(region).collect()
}
