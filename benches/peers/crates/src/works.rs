//! The works of `works.hpp`, word for word: scaled states, one sine and one cosine per evaluation.

pub const STEPS: [usize; 5] = [12500, 33333, 10000, 10000, 10000];
pub const BACKLASH: usize = 2;

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

/// A smooth work: two states.
#[derive(Clone, Copy)]
pub struct Smooth {
    pub rate: fn(f64, [f64; 2]) -> [f64; 2],
    pub scale: [f64; 2],
    pub start: [f64; 2],
    /// Where the motion has a corner (s), or 0.
    pub corner: f64,
}

pub fn smooth(work: usize) -> Smooth {
    const OUTPUT: [f64; 2] = [Q, Q * W0];
    match work {
        0 => Smooth { rate: elastic_output, scale: OUTPUT, start: [0.0; 2], corner: 0.0 },
        1 => Smooth { rate: elastic_shaft, scale: [0.1, 20.0], start: [0.0; 2], corner: 0.0 },
        3 => Smooth { rate: rigid_machine, scale: [1.0; 2], start: [0.0, 0.5], corner: 0.0 },
        _ => Smooth { rate: ramp, scale: OUTPUT, start: [0.0; 2], corner: CORNER },
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

/// The drive with backlash: y = (x2, v2 / W, x1, v1 / W) / X.
pub mod backlash {
    use super::Law;

    pub const X: f64 = 0.01;
    pub const W: f64 = 251.32741228718345;
    const LAW: Law = Law::new(0.02);
    const SPEED: f64 = 31.41592653589793;
    const M1: f64 = 2.0;
    const M2: f64 = 8.0;
    const C: f64 = 505323.74533577514;
    const S: f64 = 1e-4;

    /// In contact with flank A (1), B (-1), or between them (0); what x1 does in contact follows from the flank.
    pub fn rate(t: f64, y: &[f64], flank: i32) -> [f64; 4] {
        let x1 = if flank == 0 { y[2] } else { flank_position(t, flank) / X };
        let pull = C / W * (y[0] - x1);
        let free = f64::from(flank == 0);
        [W * y[1], -pull / M2, free * W * y[3], free * pull / M1]
    }

    /// σ F_K, positive while the flank pushes.
    pub fn force(t: f64, y: &[f64], flank: i32) -> f64 {
        let cosine = (SPEED * t).cos();
        let x1 = LAW.u0(cosine) + if flank > 0 { 0.0 } else { S };
        f64::from(flank) * (M1 * LAW.u2(cosine) * SPEED * SPEED - C * (y[0] * X - x1))
    }

    /// The clearance to a flank.
    pub fn gap(t: f64, y: &[f64], flank: i32) -> f64 {
        let z = y[2] * X - LAW.u0((SPEED * t).cos());
        if flank > 0 { z } else { S - z }
    }

    pub fn flank_position(t: f64, flank: i32) -> f64 {
        LAW.u0((SPEED * t).cos()) + if flank > 0 { 0.0 } else { S }
    }

    /// (x1, v1 / W) / X on the flank.
    pub fn on_flank(t: f64, flank: i32) -> [f64; 2] {
        [flank_position(t, flank) / X, LAW.u1((SPEED * t).sin()) * SPEED / (X * W)]
    }

    /// At rest against the flank that pushes at the start.
    pub fn start() -> ([f64; 4], i32) {
        let flank = if LAW.u2(1.0) < 0.0 { -1 } else { 1 };
        let [x, v] = on_flank(0.0, flank);
        ([x, v, x, v], flank)
    }

    /// What the state is after an event: the mode and x1 with its speed. `side` is the flank left or reached.
    pub fn after_event(t: f64, y: &mut [f64; 4], flank: i32, side: i32) -> i32 {
        [y[2], y[3]] = on_flank(t, side);
        // A release, or a plastic impact: whether m1 stays is decided at once.
        if flank == 0 && force(t, y, side) > 0.0 { side } else { 0 }
    }

    /// (x1, x2).
    pub fn outputs(t: f64, y: &[f64], flank: i32) -> [f64; 2] {
        [if flank == 0 { y[2] * X } else { flank_position(t, flank) }, y[0] * X]
    }
}
