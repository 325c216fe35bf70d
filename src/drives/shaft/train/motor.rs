//! The torque of a motor with its transmission on the shaft; the laws are in [`super::super::motor`].

use super::{Dynamics, Layout, Point};
use crate::drives::shaft::free::motor::Kloss;
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::motor::{Motor, Reference, Servo, Source, TorqueTable};
use crate::numerics::taylor::Arithmetic;

impl Motor {
    /// The number of states of the motor without its transmission.
    pub fn states(&self) -> usize {
        match &self.source {
            Source::Kloss(Kloss { dynamics: Some(_), .. }) => 1,
            Source::Servo(Servo { position: Some(_), reference, .. }) if *reference != Reference::Input => 2,
            Source::Servo(_) => 1,
            _ => 0,
        }
    }

    /// The states of the motor at the present speed of the shaft: the torque of Kloss' law, zero in a servo's integrator.
    pub fn begin(&self, y: &mut [f64], layout: &Layout) {
        if let Source::Kloss(kloss @ Kloss { dynamics: Some(_), .. }) = &self.source {
            y[layout.motor] = kloss.at(self.speed(y, layout));
        }
    }

    /// i² J_m of a rotor that follows the shaft without slip (kg·m²).
    pub fn stiff_rotor(&self) -> f64 {
        let t = self.transmission;
        if t.coupling.is_none() { t.ratio * t.ratio * t.rotor } else { 0.0 }
    }

    /// The servo.
    pub fn servo(&self) -> Option<&Servo> {
        if let Source::Servo(servo) = &self.source { Some(servo) } else { None }
    }

    /// The limit at which a servo with this demand is, if any.
    pub fn saturation(&self, demand: f64) -> i8 {
        self.servo().filter(|servo| demand.abs() > servo.limit).map_or(0, |_| demand.signum() as i8)
    }

    /// The table.
    pub fn table(&self) -> Option<&TorqueTable> {
        if let Source::Table(table) = &self.source { Some(table) } else { None }
    }

    /// Whether M is an input.
    pub fn takes_torque(&self) -> bool {
        self.source == Source::Input
    }

    /// Whether ω_ref is an input.
    pub fn takes_speed(&self) -> bool {
        self.servo().is_some_and(|servo| servo.reference == Reference::Input)
    }

    /// The name of the motor's first state.
    pub fn state_name(&self) -> &'static str {
        if self.servo().is_some() { "I" } else { "M" }
    }

    /// The usual speed of the shaft (rad/s), if known.
    pub fn usual_speed(&self) -> Option<f64> {
        let rotor = match &self.source {
            Source::Kloss(kloss) => kloss.synchronous_speed,
            Source::Servo(Servo { reference: Reference::Constant(w), .. }) => *w,
            Source::Servo(Servo { reference: Reference::Series(_, series), .. }) => series.a[0],
            Source::Table(table) => table.zero()?,
            _ => return None,
        };
        Some(rotor / self.transmission.ratio)
    }

    /// Whether its law does not change with time.
    pub fn is_steady(&self) -> bool {
        self.servo().is_none_or(|servo| matches!(servo.reference, Reference::Constant(_) | Reference::Input))
    }

    /// Whether φ_ref is an input.
    pub fn takes_position(&self) -> bool {
        self.servo().is_some_and(|servo| servo.position.is_some() && servo.reference == Reference::Input)
    }

    /// φ_m at `phi`, within its turn if `phi` is.
    pub fn angle<S: Arithmetic>(&self, phi: S, y: &[S], layout: &Layout) -> S {
        let at_shaft = if self.transmission.coupling.is_some() { phi + y[layout.coupling] } else { phi };
        at_shaft * self.transmission.ratio
    }

    /// ω_m.
    pub fn speed<S: Arithmetic>(&self, y: &[S], layout: &Layout) -> S {
        let at_shaft = if self.transmission.coupling.is_some() { y[1] + y[layout.coupling + 1] } else { y[1] };
        at_shaft * self.transmission.ratio
    }

    /// The torque on the shaft and the rates that do not depend on its acceleration.
    pub fn drive<S: Arithmetic>(&self, p: &Point<S>, layout: &Layout, d: &mut Dynamics<S>) {
        let Point { modes, y, input_values, .. } = *p;
        let (w, at) = (self.speed(y, layout), layout.motor);
        d.demand = w;
        let torque = match &self.source {
            Source::None => S::from(0.0),
            Source::Input => input_values.torque,
            Source::Constant(torque) => S::from(*torque),
            Source::Table(table) => table.torque(modes.piece, w),
            Source::Kloss(kloss) => match kloss.dynamics {
                None => kloss.at(w),
                Some(lag) => {
                    d.rates[at] = (kloss.at(w) - y[at]) * (1.0 / lag);
                    y[at]
                }
            },
            Source::Servo(servo) => {
                let mut error = input_values.reference - w;
                if let Some(k) = servo.position {
                    let mut lag = input_values.lag;
                    if self.states() == 2 {
                        (lag, d.rates[at + 1]) = (y[at + 1], error);
                    }
                    error = error + lag * k;
                }
                d.demand = error * servo.proportional + y[at];
                let limited = match modes.saturation {
                    0 => d.demand,
                    sign => S::from(f64::from(sign) * servo.limit),
                };
                let mut rate = error * servo.integral;
                if modes.saturation != 0 {
                    rate = rate - (d.demand - limited) * servo.anti_windup;
                }
                d.rates[at] = rate;
                limited
            }
        };
        let t = self.transmission;
        d.torque = match t.coupling {
            None => torque * t.ratio,
            Some([c, b]) => {
                let at = layout.coupling;
                let of_coupling = y[at] * c + y[at + 1] * b;
                d.rates[at] = y[at + 1];
                // φ̈_m/i; φ̈ is subtracted when it is known.
                d.rotor = (torque - of_coupling * (1.0 / t.ratio)) * (1.0 / t.rotor);
                d.rates[at + 1] = d.rotor * (1.0 / t.ratio);
                of_coupling
            }
        };
    }

    /// The rates that depend on the acceleration of the shaft.
    pub fn follow<S: Arithmetic>(&self, layout: &Layout, d: &mut Dynamics<S>) {
        if self.transmission.coupling.is_some() {
            d.rates[layout.coupling + 1] = d.rates[layout.coupling + 1] - d.a;
        }
    }
}

impl Servo {
    /// ω_ref about `time` (s) as coefficients in this `unit` of time; for an input from its signal at this time since its start.
    pub fn expand_reference(&self, time: f64, unit: f64, (input, since): (&Signal, f64), row: &mut [f64]) {
        row.fill(0.0);
        match &self.reference {
            Reference::Constant(w) => row[0] = *w,
            Reference::Ramp(rate) => (row[0], row[1]) = (rate * time, rate * unit),
            Reference::Series(frequency, series) => series.expand(frequency * time, frequency * unit, row),
            Reference::Input => input.expand(since, unit, row),
        }
    }
}

impl Kloss {
    /// M at the speed `w`, see [`crate::drives::shaft::free::motor::kloss`].
    pub fn at<S: Arithmetic>(&self, w: S) -> S {
        let Kloss { breakdown_torque, breakdown_slip, synchronous_speed, .. } = *self;
        let sigma = (S::from(synchronous_speed) - w) * (1.0 / (synchronous_speed * breakdown_slip));
        sigma * (2.0 * breakdown_torque.copysign(breakdown_torque * synchronous_speed)) / (sigma * sigma + S::from(1.0))
    }
}

impl TorqueTable {
    /// The piece that holds the speed `w`: 0 below the first of n speeds, n beyond the last.
    pub fn piece(&self, w: f64) -> usize {
        self.speeds.partition_point(|speed| *speed <= w)
    }

    /// The ends of a piece.
    pub fn ends(&self, piece: usize) -> [f64; 2] {
        let end = |i: Option<usize>, beyond: f64| i.and_then(|i| self.speeds.get(i)).copied().unwrap_or(beyond);
        [end(piece.checked_sub(1), f64::NEG_INFINITY), end(Some(piece), f64::INFINITY)]
    }

    /// The speed at which the torque falls to zero, between its points.
    fn zero(&self) -> Option<f64> {
        let falls = |i: &usize| self.torques[*i] > 0.0 && self.torques[i + 1] <= 0.0;
        let i = (0..self.speeds.len() - 1).find(falls)?;
        let part = self.torques[i] / (self.torques[i] - self.torques[i + 1]);
        Some(self.speeds[i] + part * (self.speeds[i + 1] - self.speeds[i]))
    }

    /// The range of the speeds.
    pub fn span(&self) -> f64 {
        self.speeds[self.speeds.len() - 1] - self.speeds[0]
    }

    /// The slope of the interpolant at a point, after Fritsch and Butland.
    fn slope(&self, k: usize) -> f64 {
        let (x, last) = (&self.speeds, self.speeds.len() - 1);
        let step = |i: usize| x[i + 1] - x[i];
        let rise = |i: usize| (self.torques[i + 1] - self.torques[i]) / step(i);
        let end = |[h0, h1]: [f64; 2], [d0, d1]: [f64; 2]| {
            let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
            if slope * d0 <= 0.0 {
                0.0
            } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
                3.0 * d0
            } else {
                slope
            }
        };
        match k {
            _ if last == 1 => rise(0),
            0 => end([step(0), step(1)], [rise(0), rise(1)]),
            _ if k == last => end([step(last - 1), step(last - 2)], [rise(last - 1), rise(last - 2)]),
            _ => {
                let ([h0, h1], [d0, d1]) = ([step(k - 1), step(k)], [rise(k - 1), rise(k)]);
                let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
                if d0 * d1 <= 0.0 { 0.0 } else { (w0 + w1) / (w0 / d0 + w1 / d1) }
            }
        }
    }

    /// M on a piece.
    pub fn torque<S: Arithmetic>(&self, piece: usize, w: S) -> S {
        let last = self.speeds.len() - 1;
        if piece == 0 || piece > last {
            return S::from(self.torques[piece.min(last)]);
        }
        let k = piece - 1;
        let h = self.speeds[k + 1] - self.speeds[k];
        let rise = (self.torques[k + 1] - self.torques[k]) / h;
        let [d0, d1] = [self.slope(k), self.slope(k + 1)];
        let x = w - S::from(self.speeds[k]);
        let [second, third] = [(3.0 * rise - 2.0 * d0 - d1) / h, (d0 + d1 - 2.0 * rise) / (h * h)];
        ((x * third + S::from(second)) * x + S::from(d0)) * x + S::from(self.torques[k])
    }
}
