//! The contact of a flat face with a contour: its direction in each point, and the places between points at which its curvature
//! jumps.
//!
//! The direction θ of a convex contour grows with its length s, and the chord between two points has the mean of θ over its
//! arc. So Θ(s) = ∫θ ds is known in each point; on a circular arc it is a parabola. The polynomial through neighbours then
//! gives θ = Θ′ and κ = Θ″; the differences select neighbours without a jump of κ between them. If the ends of an interval are
//! on different arcs, the polynomials of both touch at the jump of κ. The polynomials also correct length and direction of the
//! chords of arcs with another curvature.
//!
//! Symbols: c point of the contour seen from the cam (m), s its length (m), θ its direction (rad), κ its curvature (1/m), n its
//! normal. The face at φ = σ(π − θ) has the height h = Re(c n̄), h′ = −σ Im(c n̄), h″ = 1/κ − h. Valid for convex contours with three
//! points on each arc. Source: derived here; the choice of neighbours after A. Harten, B. Engquist, S. Osher, S. Chakravarthy,
//! Uniformly high order accurate essentially non-oscillatory schemes III, J. Comput. Phys. 71 (1987), 231–303.

use super::super::{I, Point};
use super::LEAST;
use camdrive::numerics::gauss::Gauss;
use std::f64::consts::{PI, TAU};

/// The highest order of a divided difference: seven points lie on a polynomial.
const MOST: usize = 8;

/// Neighbours on one side alone are chosen if their differences are smaller by this factor.
const ASIDE: f64 = 2.0;

/// A corner is found from points at least this part of a chord away from its first estimate.
const ASIDE_CORNER: f64 = 0.3;

/// A first look finds a corner this far (of a chord) outside its interval, because the neighbours of the next point may lie
/// across it.
const REACH: f64 = 0.5;

/// Corrections of the chords: each multiplies the error by the square of the turn between neighbours.
const PASSES: usize = 3;

/// The curvature in a point exceeds the curvatures of circles through it and its neighbours at most by this factor.
const BEYOND: f64 = 3.0;

/// A point at which the chords turn by a smaller part of both neighbours' turns is on no arc: it is straight, or has noise.
const EVEN: f64 = 0.05;

/// A jump of κ is this many times its change over a neighbouring chord.
const JUMP: f64 = 2.0;

/// A jump of κ that moves the contour by less than this part of its length within the interval is ignored.
const SMALL: f64 = 1e-8;

/// Two directions closer than this (rad) are one: ten times the least distance of points of a table.
const ONE: f64 = 1e-5;

/// Rounded coordinates may leave h″ uncertain between two contacts by this part of its largest value before one of them is left
/// out: a third of the required per cent of an acceleration.
const ROUGH: f64 = 3e-3;

/// A point is left out if h″ becomes less uncertain at least by this factor.
const BETTER: f64 = 0.9;

/// Contacts are left out within this angle (rad), a third of a gap; over it h″ of a law that is no arc bends little.
const NARROW: f64 = 0.015;

/// Contacts that are closer to another by this factor are also left out within a wider angle (rad): over it a polynomial of
/// degree 5 has h of an arc to Δθ⁶/46080 = 1e-7 of its radius.
const NEAR: (f64, f64) = (0.1, 0.4);

/// The contour in contact with the face.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Its point of the contour, from 0, or the last point before it.
    pub index: usize,
    /// θ.
    pub direction: f64,
    /// c.
    pub place: Point,
    /// κ before and after it, in the sense of growing θ.
    pub curvatures: [f64; 2],
}

impl Touch {
    /// φ, h, h′ and h″ at smaller and larger θ for a cam that turns by σφ.
    pub fn contact(&self, sense: f64) -> (f64, [f64; 2], [f64; 2]) {
        let seen = self.place * (-I * Point::from_polar(1.0, self.direction)).conj();
        let bends = self.curvatures.map(|curvature| 1.0 / curvature - seen.re);
        (sense * (PI - self.direction), [seen.re, -sense * seen.im], bends)
    }
}

/// The uncertainty of h″ between two contacts: the deviation of the polynomial of degree 5 in θ with h, h′ and h″ of both from
/// h″ of an arc. With Δθ their distance, the residual of h′ in the trapezoidal rule, e₁ = [h′] − Δθ (h″₁ + h″₂)/2 − Δθ³ h̄″/12,
/// where h⁗ = −h″, and the residual of h in Euler's and Maclaurin's rule, e₀ = [h] − Δθ (h′₁ + h′₂)/2 + Δθ² [h″]/12, move h″ by
/// 3 e₁/(2 Δθ) and 10 e₀/(√3 Δθ²): an error in the last digit of a coordinate counts more if both are closer.
fn rough(own: &Touch, next: &Touch) -> f64 {
    let [(start, [low, low_slope], [_, before]), (end, [high, high_slope], [behind, _])] =
        [own, next].map(|touch| touch.contact(-1.0));
    let width = (end - start).rem_euclid(TAU);
    let (sum, step) = (before + behind, behind - before);
    let turned = high_slope - low_slope - 0.5 * width * sum - width.powi(3) * sum / 24.0;
    let moved = high - low - 0.5 * width * (low_slope + high_slope) + width * width * step / 12.0;
    1.5 * turned.abs() / width + 10.0 / 3.0_f64.sqrt() * moved.abs() / (width * width)
}

/// The contacts without those that make h″ more uncertain, and its remaining uncertainty as a part of its largest value.
fn settled(mut list: Vec<Touch>) -> (Vec<Touch>, f64) {
    let bends = list.iter().flat_map(|touch| touch.contact(-1.0).2).map(f64::abs);
    let most = bends.fold(f64::MIN_POSITIVE, f64::max);
    let distance = |own: &Touch, next: &Touch| (next.direction - own.direction).rem_euclid(TAU);
    let mut k = 0;
    while k < list.len() && list.len() > LEAST {
        let n = list.len();
        let at = |i: usize| &list[i % n];
        let (own, near) = (rough(at(k), at(k + 1)), distance(at(k), at(k + 1)));
        // Drops the end without which it is better; a jump of κ stays.
        let ends = [(k, k + n - 1, k + 1), (k + 1, k, k + 2)].into_iter();
        let without = ends
            .filter(|&(i, from, to)| {
                let [before, behind] = at(i).curvatures;
                let width = distance(at(from), at(to));
                before == behind && (width < NARROW || width < NEAR.1 && near < NEAR.0 * width)
            })
            .map(|(i, from, to)| (i, rough(at(from), at(to))))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match without.filter(|(_, without)| own > ROUGH * most && *without < BETTER * own) {
            Some((i, _)) => {
                list.remove(i % n);
                k = k.saturating_sub(1);
            }
            None => k += 1,
        }
    }
    let n = list.len();
    let left = (0..n).map(|k| rough(&list[k], &list[(k + 1) % n])).fold(0.0, f64::max);
    (list, left / most)
}

/// The chords of a closed contour that runs counter-clockwise.
struct ClosedContour<'a> {
    points: &'a [Point],
    chords: Vec<Point>,
    /// The lengths of the arcs over the chords, and the means of θ over them.
    lengths: Vec<f64>,
    means: Vec<f64>,
    /// s of the points.
    places: Vec<f64>,
    length: f64,
    /// The divided differences of Θ of the orders 1 … `MOST` from each point on.
    differences: Vec<[f64; MOST + 1]>,
}

/// The polynomial of Θ through these neighbours.
#[derive(Clone, Copy)]
struct Local {
    first: usize,
    order: usize,
}

/// The contacts of the contour through these points, counter-clockwise in the order of θ; for each interval the distance (m) of
/// the polynomials on both sides of it; and the uncertainty of h″ as a part of its largest value.
///
/// # Errors
/// The index of a point at which the contour is not convex.
pub fn touches(points: &[Point]) -> Result<(Vec<Touch>, Vec<f64>, f64), usize> {
    let mut course = ClosedContour::new(points)?;
    let n = points.len();
    for pass in 1.. {
        let corners = course.corners();
        // A turn more than the points, so that neighbours have indices of their own.
        let locals: Vec<Local> = (n..=2 * n).map(|i| course.centred(i, &corners)).collect();
        // The corner of each interval.
        let within = |i: usize| {
            let [start, end] = [n + i, n + i + 1].map(|i| course.place(i));
            corners.iter().copied().find(|s| (start..end).contains(s))
        };
        let corners: Vec<Option<f64>> = (0..n).map(within).collect();
        if pass == PASSES {
            let apart = |i: usize| {
                let (start, width, of) = (course.place(n + i), course.lengths[i], [locals[i], locals[i + 1]]);
                let apart = course.apart([n + i, n + i + 1], of, corners[i].unwrap_or(start + 0.5 * width)).abs();
                // An arc with fewer points than a polynomial needs may rise above its chord by any height up to the
                // polynomial's.
                let lost = of.iter().any(|local| course.crosses(*local, &corners));
                let bend = of.iter().map(|local| course.at(*local, start)[2].abs()).fold(0.0, f64::max);
                if lost { apart + bend * width * width / 8.0 } else { apart }
            };
            let (touches, bend) = settled(course.contacts(&locals, &corners));
            return Ok((touches, (0..n).map(apart).collect(), bend));
        }
        course.correct(&locals, &corners);
    }
    unreachable!("the last pass returns")
}

impl<'a> ClosedContour<'a> {
    fn new(points: &'a [Point]) -> Result<Self, usize> {
        let n = points.len();
        let chords: Vec<Point> = (0..n).map(|i| points[(i + 1) % n] - points[i]).collect();
        let turns: Vec<f64> = (0..n).map(|i| (chords[i] / chords[(i + n - 1) % n]).arg()).collect();
        // Next to a corner a point on the flatter arc has one neighbour of its kind.
        let least = |i: usize| EVEN * turns[(i + 1) % n].min(turns[(i + n - 1) % n]).max(0.0);
        if let Some(i) = (0..n).find(|&i| !(turns[i] > least(i))) {
            return Err(i);
        }
        let means = turns.iter().skip(1).scan(chords[0].arg(), |mean, turn| {
            let own = *mean;
            *mean += turn;
            Some(own)
        });
        let mut means: Vec<f64> = means.collect();
        means.push(means[n - 2] + turns[n - 1]);
        // Over a chord the contour bends as in the end whose neighbour bends more alike.
        let bend = |i: usize| 2.0 * turns[i % n] / (chords[i % n].norm() + chords[(i + n - 1) % n].norm());
        let length = |i: usize| {
            let [before, own, next, behind] = [i + n - 1, i, i + 1, i + 2].map(bend);
            let half = 0.5 * chords[i].norm() * if (own - before).abs() < (behind - next).abs() { own } else { next };
            chords[i].norm() * half / half.sin()
        };
        let lengths = (0..n).map(length).collect();
        let mut course =
            ClosedContour { points, chords, lengths, means, places: Vec::new(), length: 0.0, differences: Vec::new() };
        course.differ();
        Ok(course)
    }

    /// s of a point, counted on over the turns like all indices here.
    fn place(&self, i: usize) -> f64 {
        let n = self.places.len();
        self.places[i % n] + self.length * (i / n) as f64
    }

    fn mean(&self, i: usize) -> f64 {
        let n = self.means.len();
        self.means[i % n] + TAU * (i / n) as f64
    }

    fn difference(&self, i: usize, order: usize) -> f64 {
        self.differences[i % self.differences.len()][order]
    }

    /// Sums the lengths and takes the differences.
    fn differ(&mut self) {
        let n = self.points.len();
        self.places =
            self.lengths.iter().scan(0.0, |sum, length| Some(std::mem::replace(sum, *sum + length))).collect();
        self.length = self.lengths.iter().sum();
        let from = |i: usize| {
            let mut own = [0.0; MOST + 1];
            let mut row: [f64; MOST] = std::array::from_fn(|k| self.mean(i + k));
            for order in 1..=MOST {
                own[order] = row[0];
                for k in 0..MOST - order {
                    row[k] = (row[k + 1] - row[k]) / (self.place(i + k + order + 1) - self.place(i + k));
                }
            }
            own
        };
        self.differences = (0..n).map(from).collect();
    }

    /// The places at which κ jumps, over the turn from point n on: first estimated from neighbours on one side, then found from
    /// points that are certainly on their side.
    fn corners(&self) -> Vec<f64> {
        let n = self.points.len();
        let locals: Vec<Local> = (n..=2 * n).map(|i| self.smooth(i)).collect();
        let holds = |local: Local, i: usize| local.first <= i && i < local.first + local.order;
        let found = (0..n).filter_map(|k| {
            let (i, of) = (n + k, [locals[k], locals[k + 1]]);
            if of.iter().all(|local| holds(*local, i)) { None } else { self.corner([i, i + 1], of, REACH) }
        });
        let mut found: Vec<f64> = found.collect();
        let width = |s: f64| self.place(self.index(s) + 1) - self.place(self.index(s));
        found.dedup_by(|next, own| *next - *own < width(*own));
        let all = |k: usize| found[k % found.len()] + self.length * (k / found.len()) as f64;
        let sharper = |k: usize| {
            let [before, own, next] = [k + found.len() - 1, k + found.len(), k + found.len() + 1].map(all);
            // Neighbouring points may lie on either side.
            let near = ASIDE_CORNER * width(own);
            let [a, b] = [self.index(own - near), self.index(own + near) + 1];
            let [first, last] = [self.index(before + near) + 1, self.index(next - near)];
            let orders = [a - first.min(a), last.max(b) - b].map(|order| order.min(4));
            if orders.iter().any(|order| *order < 2) {
                return Some(own);
            }
            let of = [Local { first: a - orders[0], order: orders[0] }, Local { first: b, order: orders[1] }];
            self.corner([a, b], of, 0.0)
        };
        let turned = |s: f64| self.place(n) + (s - self.place(n)).rem_euclid(self.length);
        (0..found.len()).filter_map(sharper).map(turned).collect()
    }

    /// True if κ jumps between these neighbours, by the corners of the intervals.
    fn crosses(&self, local: Local, corners: &[Option<f64>]) -> bool {
        let n = self.points.len();
        let inside = |i: usize| {
            corners[i % n].is_some_and(|s| {
                let (s, start) = ((s - self.place(i)).rem_euclid(self.length), self.place(i + 1) - self.place(i));
                (i > local.first || s > 1e-9 * start) && (i + 1 < local.first + local.order || s < (1.0 - 1e-9) * start)
            })
        };
        (local.first..local.first + local.order).any(inside)
    }

    /// The last point up to `s`.
    fn index(&self, s: f64) -> usize {
        let (n, turns) = (self.places.len(), (s / self.length).floor());
        n * turns as usize + self.places.partition_point(|place| *place <= s - turns * self.length) - 1
    }

    /// At least four neighbours of a point, without a jump of κ between them.
    fn smooth(&self, i: usize) -> Local {
        let size = |first: usize| self.difference(first, 3).abs();
        let aside = |first: usize| if first + 3 == i || first == i { ASIDE } else { 1.0 };
        let ranked = |first: &usize| (aside(*first) * size(*first), first.abs_diff(i - 1));
        let four = (i - 3..=i).min_by(|a, b| ranked(a).partial_cmp(&ranked(b)).unwrap_or(std::cmp::Ordering::Equal));
        self.grown(i, Local { first: four.unwrap_or(i - 1), order: 3 }, [0, usize::MAX])
    }

    /// The neighbours of a point on its side of these corners.
    fn centred(&self, i: usize, corners: &[f64]) -> Local {
        let s = self.place(i);
        let sides = corners.iter().flat_map(|corner| [-1.0, 0.0, 1.0].map(|turns| corner + turns * self.length));
        let (mut low, mut high) = (s - 0.5 * self.length, s + 0.5 * self.length);
        for corner in sides {
            if corner < s {
                low = low.max(corner);
            } else {
                high = high.min(corner);
            }
        }
        let borders = [self.index(low) + 1, self.index(high)];
        if borders[1] < borders[0] + 2 {
            return Local { first: i - 1, order: 2 };
        }
        let first = (i - 1).clamp(borders[0], borders[1] - 2);
        self.grown(i, Local { first, order: 2 }, borders)
    }

    /// The limits of κ at a point, from the chords next to it.
    fn bends(&self, i: usize) -> [f64; 2] {
        let near = (i - 3..=i + 1).map(|first| 2.0 * self.difference(first, 2));
        let [least, most] = near.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], bend| [a.min(bend), b.max(bend)]);
        [least / BEYOND, most * BEYOND]
    }

    /// κ at `s`, by the neighbours of point i.
    fn curvature(&self, local: Local, i: usize, s: f64) -> f64 {
        let [least, most] = self.bends(i);
        self.at(local, s)[2].clamp(least, most)
    }

    /// Extends these neighbours of a point on both sides, from the first to the last of `borders`, as long as the added terms
    /// become smaller.
    fn grown(&self, i: usize, mut local: Local, borders: [usize; 2]) -> Local {
        while local.order < MOST {
            let (Local { first, order }, next) = (local, local.order + 1);
            // The distance of the middle, and the added term.
            let rank = |first: usize| ((2 * first + next).abs_diff(2 * i), self.difference(first, next).abs());
            let left = (first > borders[0]).then(|| (rank(first - 1), first - 1));
            let right = (first + order < borders[1]).then(|| (rank(first), first));
            let better =
                left.into_iter().chain(right).min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
            let Some(((_, size), from)) = better else { break };
            if size * (self.place(from + next) - self.place(from)) > self.difference(first, order).abs() {
                break;
            }
            local = Local { first: from, order: next };
        }
        // The direction lies between those of both chords; otherwise too few points lie on this arc.
        let [low, high] = [self.mean(i - 1), self.mean(i)];
        let [_, direction, bend, _] = self.at(local, self.place(i));
        let [least, most] = self.bends(i);
        let between = direction > low && direction < high && bend > least && bend < most;
        if between { local } else { Local { first: i - 1, order: 2 } }
    }

    /// Θ from the first of these neighbours on, θ, κ and dκ/ds at the length `s`.
    fn at(&self, local: Local, s: f64) -> [f64; 4] {
        let Local { first, order } = local;
        let newton = |[a, b, c, d]: [f64; 4], k: usize| {
            let (x, coefficient) = (s - self.place(first + k), if k == 0 { 0.0 } else { self.difference(first, k) });
            // The difference of order 1 counts its turns.
            let coefficient = if k == 1 { self.mean(first) } else { coefficient };
            [a * x + coefficient, b * x + a, c * x + b, d * x + c]
        };
        let [sum, direction, bend, change] = (0..=order).rev().fold([0.0; 4], newton);
        [sum, direction, 2.0 * bend, 6.0 * change]
    }

    /// The distance of the polynomials of two points at `s` between them; each is exact in its own point.
    fn apart(&self, ends: [usize; 2], [left, right]: [Local; 2], s: f64) -> f64 {
        let [start, end] = ends.map(|i| self.place(i));
        let before = self.at(left, s)[0] - self.at(left, start)[0];
        let behind = self.at(right, end)[0] - self.at(right, s)[0];
        let whole: f64 = (ends[0]..ends[1]).map(|i| self.mean(i) * (self.place(i + 1) - self.place(i))).sum();
        before + behind - whole
    }

    /// The place between two points, or within `reach` of their distance outside, at which κ jumps: their polynomials touch
    /// there.
    fn corner(&self, ends: [usize; 2], of: [Local; 2], reach: f64) -> Option<f64> {
        let [start, end] = ends.map(|i| self.place(i));
        let (width, mut s) = (end - start, 0.5 * (start + end));
        let jump = |s: f64| {
            let [before, behind] = of.map(|local| self.at(local, s));
            [behind[1] - before[1], behind[2] - before[2]]
        };
        for _ in 0..8 {
            let [turn, bend] = jump(s);
            s = (s - if bend == 0.0 { 0.0 } else { turn / bend }).clamp(start - reach * width, end + reach * width);
        }
        let ([turn, bend], apart) = (jump(s), self.apart(ends, of, s));
        let moves = bend.abs() * width * width;
        let touch = turn.abs() * width < 0.05 * moves && apart.abs() < 0.1 * moves;
        // On both sides of a jump the curvature changes by less than across it.
        let steady = of.iter().all(|local| self.at(*local, s)[3].abs() * width < bend.abs() / JUMP);
        (touch && steady && moves > SMALL * self.length).then_some(s)
    }

    /// The chord of a part of the contour.
    fn chord(&self, local: Local, from: f64, to: f64) -> Point {
        let ahead = |s: f64| {
            let direction = self.at(local, from + s)[1];
            [direction.cos(), direction.sin()]
        };
        let [x, y] = Gauss::with(6).integrate(to - from, ahead);
        Point::new(x, y)
    }

    /// Lengths and directions such that the polynomials have the chords of the contour.
    fn correct(&mut self, locals: &[Local], corners: &[Option<f64>]) {
        let n = self.points.len();
        let own = |i: usize| {
            let ([left, right], [start, end]) = ([locals[i], locals[i + 1]], [i, i + 1].map(|i| self.place(n + i)));
            let chord = match corners[i] {
                Some(s) => self.chord(left, start, s) + self.chord(right, s, end),
                None => 0.5 * (self.chord(left, start, end) + self.chord(right, start, end)),
            };
            self.chords[i] / chord
        };
        let ratios: Vec<Point> = (0..n).map(own).collect();
        for (i, ratio) in ratios.iter().enumerate() {
            self.lengths[i] *= ratio.norm();
            self.means[i] += ratio.arg();
        }
        self.differ();
    }

    /// The points and the corners between them.
    fn contacts(&self, locals: &[Local], corners: &[Option<f64>]) -> Vec<Touch> {
        let n = self.points.len();
        let mut list: Vec<Touch> = Vec::new();
        let direction = |i: usize| self.at(locals[i], self.place(n + i))[1];
        let corner = |i: usize| corners[i].map(|s| (s, self.at(locals[i], s)[1]));
        // A corner in a point is not between points.
        let at_start = |i: usize| corner(i).is_some_and(|(_, turned)| turned - direction(i) < ONE);
        let at_end = |i: usize| corner(i).is_some_and(|(_, turned)| direction(i + 1) - turned < ONE);
        for i in 0..n {
            let (before, own) = ((i + n - 1) % n, self.place(n + i));
            let mut curvatures = [self.curvature(locals[i], n + i, own); 2];
            if at_end(before) {
                curvatures[0] = self.curvature(locals[before], n + before, self.place(n + before + 1));
            }
            if at_start(i) {
                curvatures[1] = self.curvature(locals[i + 1], n + i + 1, own);
            }
            list.push(Touch { index: i, direction: direction(i), place: self.points[i], curvatures });
            if let Some((s, turned)) = corner(i).filter(|_| !at_start(i) && !at_end(i)) {
                let place = self.points[i] + self.chord(locals[i], own, s);
                let curvatures = [i, i + 1].map(|j| self.curvature(locals[j], n + j, s));
                list.push(Touch { index: i, direction: turned, place, curvatures });
            }
        }
        list
    }
}
