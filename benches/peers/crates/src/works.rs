//! The works of `works.hpp`, word for word: scaled states, one sine and one cosine per evaluation.

pub const STEPS: [usize; 7] = [12500, 33333, 10000, 10000, 10000, 10000, 10000];

/// When the i-th output is read.
pub fn output_time(i: usize) -> f64 {
    i as f64 * 1e-3
}

/// U … U''' of U = Σ A_k cos kφ, k = 1, 3, 5, from sin φ and cos φ.
#[derive(Clone, Copy)]
struct Law([f64; 3]);

impl Law {
    const fn new(stroke: f64) -> Self {
        Law([0.59404 * stroke, -0.11066 * stroke, 0.01667 * stroke])
    }

    fn u0(&self, c: f64) -> f64 {
        let ([a1, a3, a5], c2) = (self.0, c * c);
        c * (a1 + a3 * (4.0 * c2 - 3.0) + a5 * ((16.0 * c2 - 20.0) * c2 + 5.0))
    }

    fn u1(&self, s: f64) -> f64 {
        let ([a1, a3, a5], s2) = (self.0, s * s);
        -s * (a1 + 3.0 * a3 * (3.0 - 4.0 * s2) + 5.0 * a5 * ((16.0 * s2 - 20.0) * s2 + 5.0))
    }

    fn u2(&self, c: f64) -> f64 {
        let ([a1, a3, a5], c2) = (self.0, c * c);
        -c * (a1 + 9.0 * a3 * (4.0 * c2 - 3.0) + 25.0 * a5 * ((16.0 * c2 - 20.0) * c2 + 5.0))
    }

    fn u3(&self, s: f64) -> f64 {
        let ([a1, a3, a5], s2) = (self.0, s * s);
        s * (a1 + 27.0 * a3 * (3.0 - 4.0 * s2) + 125.0 * a5 * ((16.0 * s2 - 20.0) * s2 + 5.0))
    }
}

/// A smooth work of N states.
#[derive(Clone, Copy)]
pub struct Smooth<const N: usize> {
    pub rate: fn(f64, [f64; N]) -> [f64; N],
    /// The states that are compared, and what they are multiplied by.
    pub outputs: [(usize, f64); 2],
    pub start: [f64; N],
    /// Where the motion has a corner (s), or 0.
    pub corner: f64,
}

impl<const N: usize> Smooth<N> {
    pub fn put(&self, y: &[f64; N]) -> [f64; 2] {
        self.outputs.map(|(k, scale)| y[k] * scale)
    }
}

pub enum Work {
    Two(Smooth<2>),
    Nine(Smooth<9>),
    Backlash,
    TrainBacklash,
}

pub fn work(number: usize) -> Work {
    const OUTPUT: [(usize, f64); 2] = [(0, Q), (1, Q * W0)];
    match number {
        0 => Work::Two(Smooth { rate: elastic_output, outputs: OUTPUT, start: [0.0; 2], corner: 0.0 }),
        1 => Work::Two(Smooth { rate: elastic_shaft, outputs: [(0, 0.1), (1, 20.0)], start: [0.0; 2], corner: 0.0 }),
        2 => Work::Backlash,
        3 => Work::Two(Smooth { rate: rigid_machine, outputs: [(0, 1.0), (1, 1.0)], start: [0.0, 0.5], corner: 0.0 }),
        4 => Work::Two(Smooth { rate: ramp, outputs: OUTPUT, start: [0.0; 2], corner: CORNER }),
        5 => Work::Nine(Smooth {
            rate: |_, y| train::rate(&y),
            outputs: [(1, train::W), (3, train::Q)],
            start: train::start(),
            corner: 0.0,
        }),
        _ => Work::TrainBacklash,
    }
}

const Q: f64 = 1e-4;
const W0: f64 = 376.99111843077515;
const CORNER: f64 = 5.0;
const SPEED: f64 = 50.26548245743669;
const OUTPUT_LAW: Law = Law::new(0.01);

fn respond([q, v]: [f64; 2], acceleration: f64) -> [f64; 2] {
    let (c, b) = (142122.30337568672, 15.079644737231007);
    [W0 * v, -b * v - c / W0 * q - acceleration * (1.0 / (Q * W0))]
}

#[inline]
fn elastic_output(t: f64, y: [f64; 2]) -> [f64; 2] {
    respond(y, OUTPUT_LAW.u2((SPEED * t).cos()) * SPEED * SPEED)
}

fn ramp(t: f64, y: [f64; 2]) -> [f64; 2] {
    let rate = SPEED / CORNER;
    let [phi, w, a] =
        if t <= CORNER { [0.5 * rate * t * t, rate * t, rate] } else { [SPEED * (t - 0.5 * CORNER), SPEED, 0.0] };
    let (s, c) = phi.sin_cos();
    respond(y, OUTPUT_LAW.u2(c) * w * w + OUTPUT_LAW.u1(s) * a)
}

fn elastic_shaft(t: f64, [q, v]: [f64; 2]) -> [f64; 2] {
    const LAW: Law = Law::new(0.1);
    let (m, inertia, c, b, w, w0) = (20.0, 0.05, 2000.0, 0.6, 18.84955592153876, 200.0);
    let (sine, cosine) = f64::sin_cos(w * t);
    let (u1, u2, u3) = (LAW.u1(sine), LAW.u2(cosine), LAW.u3(sine));
    let g = m * w * u1 * u2;
    let stiffness = c + m * w * w * (u2 * u2 + u1 * u3);
    let torque = g * w * (1.0 / 20.0) + (b + 2.0 * g) * v + stiffness * (1.0 / w0) * q;
    [w0 * v, -torque / (inertia + m * u1 * u1)]
}

fn rigid_machine(_: f64, [phi, w]: [f64; 2]) -> [f64; 2] {
    const LAW: Law = Law::new(0.1);
    let (m1, m2, mk, sk, ws) = (30.0, 15.0, 60.0, 0.12, 62.83185307179586);
    let (s, c) = phi.sin_cos();
    let (p1, p2, q1, q2) = (LAW.u1(s), LAW.u2(c), LAW.u1(-c), LAW.u2(s));
    let inertia = 0.5 + m1 * p1 * p1 + m2 * q1 * q1;
    let slip = (ws - w) / ws;
    let torque = 2.0 * mk * sk * slip / (slip * slip + sk * sk);
    [w, (torque - (m1 * p1 * p2 + m2 * q1 * q2) * w * w) / inertia]
}

/// The train: y = (φ, φ' / W, M / T, then q / Q, q' / (Q W0) of each follower).
mod train {
    use super::Law;

    pub const W: f64 = 60.0;
    pub const Q: f64 = 1e-3;
    pub const W0: f64 = 300.0;
    pub const J0: f64 = 0.08;
    const T: f64 = 10.0;
    const LAG: f64 = 0.01;
    const W_START: f64 = 0.5;
    /// m, c, b and the law of each output.
    const FOLLOWERS: [(f64, f64, f64, Law); 3] = [
        (3.0, 426366.91012706014, 45.238934211693014, Law::new(0.06)),
        (5.0, 399718.978244119, 84.82300164692441, Law::new(0.04)),
        (1.5, 378992.80900183134, 30.159289474462014, Law::new(-0.08)),
    ];

    fn kloss(w: f64) -> f64 {
        let (mk, sk, ws) = (12.0, 0.15, 62.83185307179586);
        let slip = (ws - w) / ws;
        2.0 * mk * sk * slip / (slip * slip + sk * sk)
    }

    /// U' and U'' of a follower; they are a quarter of a turn apart, the third by the sign of its stroke.
    pub fn cam(j: usize, (s, c): (f64, f64)) -> [f64; 2] {
        let (s, c) = if j == 1 { (-c, s) } else { (s, c) };
        [FOLLOWERS[j].3.u1(s), FOLLOWERS[j].3.u2(c)]
    }

    fn pull(y: &[f64], j: usize) -> f64 {
        FOLLOWERS[j].1 * Q * y[3 + 2 * j] + FOLLOWERS[j].2 * (Q * W0) * y[4 + 2 * j]
    }

    /// The torque of the motor and of K elastic outputs.
    pub fn torque<const K: usize>(y: &[f64], angle: (f64, f64)) -> f64 {
        T * y[2] + (0..K).map(|j| cam(j, angle)[0] * pull(y, j)).sum::<f64>()
    }

    pub fn rates<const K: usize>(y: &[f64], f: &mut [f64], angle: (f64, f64), acceleration: f64) {
        let w = W * y[1];
        f[0] = w;
        f[1] = acceleration / W;
        f[2] = (kloss(w) / T - y[2]) / LAG;
        for j in 0..K {
            let [u1, u2] = cam(j, angle);
            f[3 + 2 * j] = W0 * y[4 + 2 * j];
            f[4 + 2 * j] = -(pull(y, j) / FOLLOWERS[j].0 + u2 * w * w + u1 * acceleration) / (Q * W0);
        }
    }

    pub fn rate(y: &[f64; 9]) -> [f64; 9] {
        let (angle, mut f) = (y[0].sin_cos(), [0.0; 9]);
        rates::<3>(y, &mut f, angle, torque::<3>(y, angle) / J0);
        f
    }

    pub fn start<const N: usize>() -> [f64; N] {
        let mut y = [0.0; N];
        [y[1], y[2]] = [W_START / W, kloss(W_START) / T];
        y
    }
}

/// A drive with backlash: N states, whatever the mode; its flank is 1 (A), -1 (B), or 0 between them.
pub trait Drive<const N: usize> {
    /// In contact x1 follows from the flank: its states rest.
    fn rate(t: f64, y: &[f64], flank: i32) -> [f64; N];

    /// σ F_K, positive while the flank pushes.
    fn force(t: f64, y: &[f64], flank: i32) -> f64;

    /// The clearance to a flank.
    fn gap(t: f64, y: &[f64], flank: i32) -> f64;

    /// x1 and its speed, scaled, on the flank; they are the last two states.
    fn on_flank(t: f64, y: &[f64], flank: i32) -> [f64; 2];

    /// Other states that jump in an impact on this flank.
    fn impact(y: &mut [f64; N], flank: i32);

    /// At rest against the flank that pushes at the start.
    fn start() -> ([f64; N], i32);

    /// (x1, x2).
    fn outputs(t: f64, y: &[f64], flank: i32) -> [f64; 2];

    /// What the state is after an event: the mode and x1 with its speed. `side` is the flank left or reached.
    fn after_event(t: f64, y: &mut [f64; N], flank: i32, side: i32) -> i32 {
        if flank == 0 {
            Self::impact(y, side);
        }
        [y[N - 2], y[N - 1]] = Self::on_flank(t, y, side);
        // A release, or a plastic impact: whether m1 stays is decided at once.
        if flank == 0 && Self::force(t, y, side) > 0.0 { side } else { 0 }
    }
}

/// y = (x2, v2 / W, x1, v1 / W) / X.
pub struct Backlash;

impl Backlash {
    const X: f64 = 0.01;
    const W: f64 = 251.32741228718345;
    const LAW: Law = Law::new(0.02);
    const SPEED: f64 = 31.41592653589793;
    const M1: f64 = 2.0;
    const M2: f64 = 8.0;
    const C: f64 = 505323.74533577514;
    const S: f64 = 1e-4;

    fn flank_position(t: f64, flank: i32) -> f64 {
        Self::LAW.u0((Self::SPEED * t).cos()) + if flank > 0 { 0.0 } else { Self::S }
    }
}

impl Drive<4> for Backlash {
    fn rate(t: f64, y: &[f64], flank: i32) -> [f64; 4] {
        let x1 = if flank == 0 { y[2] } else { Self::flank_position(t, flank) / Self::X };
        let pull = Self::C / Self::W * (y[0] - x1);
        let free = f64::from(flank == 0);
        [Self::W * y[1], -pull / Self::M2, free * Self::W * y[3], free * pull / Self::M1]
    }

    fn force(t: f64, y: &[f64], flank: i32) -> f64 {
        let cosine = (Self::SPEED * t).cos();
        let x1 = Self::LAW.u0(cosine) + if flank > 0 { 0.0 } else { Self::S };
        f64::from(flank)
            * (Self::M1 * Self::LAW.u2(cosine) * Self::SPEED * Self::SPEED - Self::C * (y[0] * Self::X - x1))
    }

    fn gap(t: f64, y: &[f64], flank: i32) -> f64 {
        let z = y[2] * Self::X - Self::LAW.u0((Self::SPEED * t).cos());
        if flank > 0 { z } else { Self::S - z }
    }

    fn on_flank(t: f64, _: &[f64], flank: i32) -> [f64; 2] {
        let speed = Self::LAW.u1((Self::SPEED * t).sin()) * Self::SPEED;
        [Self::flank_position(t, flank) / Self::X, speed / (Self::X * Self::W)]
    }

    fn impact(_: &mut [f64; 4], _: i32) {}

    fn start() -> ([f64; 4], i32) {
        let flank = if Self::LAW.u2(1.0) < 0.0 { -1 } else { 1 };
        let [x, v] = Self::on_flank(0.0, &[], flank);
        ([x, v, x, v], flank)
    }

    fn outputs(t: f64, y: &[f64], flank: i32) -> [f64; 2] {
        [if flank == 0 { y[2] * Self::X } else { Self::flank_position(t, flank) }, y[0] * Self::X]
    }
}

/// y = (the shaft and two outputs, x2 / X, v2 / V, x1 / X, v1 / V).
pub struct TrainBacklash;

impl TrainBacklash {
    const X: f64 = 0.04;
    const V: f64 = 20.0;
    const M1: f64 = 0.5;
    const M2: f64 = 1.5;
    const C: f64 = 378992.80900183134;
    const D: f64 = 75.39822368615505;
    const S: f64 = 1e-4;
    const LAW: Law = Law::new(-0.08);

    fn flank_position(c: f64, flank: i32) -> f64 {
        Self::LAW.u0(c) + if flank > 0 { 0.0 } else { Self::S }
    }

    /// The force of m1 on m2.
    fn spring(y: &[f64], x1: f64, v1: f64) -> f64 {
        Self::C * (x1 - Self::X * y[7]) + Self::D * (v1 - Self::V * y[8])
    }
}

impl Drive<11> for TrainBacklash {
    fn rate(_: f64, y: &[f64], flank: i32) -> [f64; 11] {
        let (angle, mut f) = (y[0].sin_cos(), [0.0; 11]);
        let (w, free) = (train::W * y[1], flank == 0);
        let [u1, u2] = [Self::LAW.u1(angle.0), Self::LAW.u2(angle.1)];
        let alone = train::torque::<2>(y, angle);
        let (acceleration, spring) = if free {
            (alone / train::J0, Self::spring(y, Self::X * y[9], Self::V * y[10]))
        } else {
            let spring = Self::spring(y, Self::flank_position(angle.1, flank), u1 * w);
            ((alone - u1 * (spring + Self::M1 * u2 * w * w)) / (train::J0 + Self::M1 * u1 * u1), spring)
        };
        train::rates::<2>(y, &mut f, angle, acceleration);
        f[7] = Self::V / Self::X * y[8];
        f[8] = spring / (Self::M2 * Self::V);
        if free {
            f[9] = Self::V / Self::X * y[10];
            f[10] = -spring / (Self::M1 * Self::V);
        }
        f
    }

    fn force(_: f64, y: &[f64], flank: i32) -> f64 {
        let (angle, w) = (y[0].sin_cos(), train::W * y[1]);
        let [u1, u2] = [Self::LAW.u1(angle.0), Self::LAW.u2(angle.1)];
        let spring = Self::spring(y, Self::flank_position(angle.1, flank), u1 * w);
        let alone = train::torque::<2>(y, angle) / train::J0;
        f64::from(flank) * (Self::M1 * (u2 * w * w + u1 * alone) + spring) / (1.0 + Self::M1 * u1 * u1 / train::J0)
    }

    fn gap(_: f64, y: &[f64], flank: i32) -> f64 {
        let z = Self::X * y[9] - Self::LAW.u0(y[0].cos());
        if flank > 0 { z } else { Self::S - z }
    }

    fn on_flank(_: f64, y: &[f64], flank: i32) -> [f64; 2] {
        let (s, c) = y[0].sin_cos();
        [Self::flank_position(c, flank) / Self::X, Self::LAW.u1(s) * train::W * y[1] / Self::V]
    }

    fn impact(y: &mut [f64; 11], _: i32) {
        let angle = y[0].sin_cos();
        let u1 = Self::LAW.u1(angle.0);
        let approach = Self::V * y[10] - u1 * train::W * y[1];
        let jump = u1 * approach / (1.0 / Self::M1 + u1 * u1 / train::J0) / train::J0;
        y[1] += jump / train::W;
        for j in 0..2 {
            y[4 + 2 * j] -= train::cam(j, angle)[0] * jump / (train::Q * train::W0);
        }
    }

    fn start() -> ([f64; 11], i32) {
        let mut y = train::start();
        for flank in [1, -1] {
            [y[9], y[10]] = Self::on_flank(0.0, &y, flank);
            [y[7], y[8]] = [y[9], y[10]];
            if Self::force(0.0, &y, flank) > 0.0 {
                return (y, flank);
            }
        }
        (y, 0)
    }

    fn outputs(_: f64, y: &[f64], flank: i32) -> [f64; 2] {
        let x1 = if flank == 0 { Self::X * y[9] } else { Self::flank_position(y[0].cos(), flank) };
        [x1, Self::X * y[7]]
    }
}
