//! The findings as a report.

use super::{Motion, Speeds, SteadyMotions, tables};
use crate::forces::report::LiftOff;
use crate::periodic_turn::{self, Dwell, GONE, NEUTRAL, NEVER, Turn};
use crate::plot::{Axis, Diagram, Series};
use crate::report::terminal::{range, shown};
use crate::report::unit::{DEG, MS, NM, ONE, PERCENT, RPM, W};
use crate::report::{Advice, Claim, Level, Report, Setting, Table, Value, Verdict, WrittenValue};
use crate::text::{counted, digits, digits_beside_one, distinguishing, in_a_turn, number, sentence, share, time};
use crate::transmission::Transmission;
use camdrive::drives::rigid_machine::Kloss;

/// The most significant digits of speeds and periods.
const FINE: usize = 7;

/// Sentences on the speed that yields a prescribed period.
const PRESCRIBED: usize = 10;

/// Name of the motion of a machine without torques.
const FREE: &str = "without torques";

/// The name of a motion, by its place.
fn name((i, motion): (usize, &Motion)) -> String {
    format!("{} ({})", i + 1, if motion.stable { "stable" } else { "unstable" })
}

/// A size in the digits that show on which side of 1 it is.
fn beside_one(size: f64) -> String {
    match digits_beside_one(&[size]) {
        3 => number(size),
        fine => digits(size, fine, -4),
    }
}

/// The multiplier, for a steep motor as a power of ten.
fn multiplier(growth: f64) -> String {
    let power = growth / std::f64::consts::LN_10;
    // A mass that ends every turn on its flank forgets all of it.
    if power.abs() < 300.0 || power == f64::NEG_INFINITY { beside_one(growth.exp()) } else { format!("10^{power:.0}") }
}

/// The fluctuation of a speed, as the end of a sentence.
fn fluctuation(speeds: &Speeds) -> String {
    let range = range([speeds.least_speed, speeds.largest_speed], &RPM);
    match speeds.fluctuation() {
        part if part > 1e-9 => format!("its speed fluctuates by {} ({range})", share(part)),
        _ => "its speed is constant".to_owned(),
    }
}

/// The decay of disturbances, in words; None where it is not known.
fn decay(motion: &Motion) -> Option<String> {
    if motion.growth.is_nan() || motion.growth == f64::INFINITY {
        return None;
    }
    if motion.growth.abs() < NEUTRAL {
        return Some(sentence(NEVER));
    }
    let turns = GONE.ln() / motion.growth;
    if turns <= 1.0 {
        return Some("A disturbance decays to 1 % within a turn.".to_owned());
    }
    let time = time(turns * motion.speeds.period);
    Some(format!("A disturbance decays to 1 % within {} ({time}).", counted(number(turns), "turn")))
}

impl SteadyMotions {
    /// All speeds with the names of their motions and, of those under torques, the motions.
    fn rows(&self) -> Vec<(String, &Speeds, Option<&Motion>)> {
        let motions = self.motions.iter().enumerate();
        let motions = motions.map(|(i, motion)| (name((i, motion)), &motion.speeds, Some(motion)));
        motions.chain(self.without_torques.iter().map(|free| (FREE.to_owned(), free, None))).collect()
    }

    /// The digits that distinguish the speeds of the motions.
    fn digits(&self) -> usize {
        let speeds: Vec<f64> = self.motions.iter().map(|motion| motion.speeds.mean_speed * RPM.factor).collect();
        distinguishing(&speeds, FINE)
    }

    /// The mean speed of a motion (rpm) in these digits.
    fn rpm(&self, speed: f64) -> String {
        digits(speed * RPM.factor, self.digits(), -4)
    }

    /// The verdict on the machine: whether it runs, and how steadily.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        if let Some(fault) = &self.none {
            if self.judged.result.is_empty() {
                verdict.result(Level::Bad, sentence(&periodic_turn::reason(fault)));
            }
            verdict.join(self.judged.clone());
            return verdict;
        }
        let stable: Vec<&Motion> = self.motions.iter().filter(|motion| motion.stable).collect();
        match (&stable[..], &self.motions[..], &self.without_torques) {
            ([first, others @ ..], all, _) => {
                let level = if others.is_empty() { Level::Good } else { Level::Mind };
                let speed = self.rpm(first.speeds.mean_speed);
                verdict.result(
                    level,
                    match self.motor.is_some() || first.speeds.fluctuation() > 0.0 {
                        true => format!("The machine runs at {speed} rpm on average; {}.", fluctuation(&first.speeds)),
                        false => format!("At {speed} rpm the motion repeats every turn."),
                    },
                );
                // The judgement has some of them.
                for decay in decay(first).into_iter().filter(|decay| !self.judged.result.contains(decay)) {
                    verdict.result(level, decay);
                }
                let speeds: Vec<String> = others.iter().map(|motion| self.rpm(motion.speeds.mean_speed)).collect();
                if !speeds.is_empty() {
                    let text = format!("It also runs at {} rpm, depending on how it starts.", speeds.join(", "));
                    verdict.result(level, text).advice(
                        Advice::new("`start.mode` = \"steady_state\" begins with the fastest stable motion.").set(
                            [Setting::new("start.mode", "steady_state")],
                            Claim::Speed { mean: first.speeds.mean_speed },
                        ),
                    );
                }
                let slower = |motion: &&Motion| !motion.stable && motion.speeds.period > first.speeds.period;
                if let Some(slow) = all.iter().find(slower) {
                    let limit = self.rpm(slow.speeds.mean_speed);
                    verdict.result(level, format!("Slower than about {limit} rpm it loses speed for good."));
                }
            }
            // The judgement says that it is unstable.
            ([], [_, ..], _) if self.motor.is_none() => {}
            ([], motions, None) => self.stalls(motions.len(), &mut verdict),
            ([], _, Some(free)) => {
                let speed = self.rpm(free.mean_speed);
                verdict.result(
                    Level::Good,
                    format!(
                        "Without a motor the machine turns at any speed. At {speed} rpm on average {}.",
                        fluctuation(free)
                    ),
                );
            }
        }
        verdict.join(self.judged.clone());
        if let Some(speed) = self.synchronous_speed {
            let speed = WrittenValue::nearest(speed, &RPM, PRESCRIBED);
            let text = format!("The period needs a synchronous speed of the motor of {speed}: set `motor.w_s` to it.");
            let mean = stable.first().map_or(f64::NAN, |motion| motion.speeds.mean_speed);
            verdict.advice(Advice::new(text).set([Setting::new("motor.w_s", speed)], Claim::Speed { mean }));
        }
        if let Some(turn) = &self.turn {
            self.of_turn(turn, &mut verdict);
        }
        for mechanism in self.mechanisms.iter().filter(|mechanism| !mechanism.is_usual()) {
            verdict.result(Level::Mind, mechanism.sentence());
        }
        verdict.certainty(match self.lift_offs {
            Some(_) => "There may be other periodic motions. The decay holds for small disturbances.",
            None => "The list is complete for the rigid machine. The decay holds for small disturbances.",
        });
        for period in &self.lost_periods {
            verdict.certainty(format!("Without the lag of the motor's torque there would also be a motion of {}. With it none was found near: either none exists, or disturbances grow too fast to follow it.", time(*period)));
        }
        verdict
    }

    /// That no motion is stable.
    fn stalls(&self, count: usize, verdict: &mut Verdict) {
        let Some(Kloss { breakdown_torque, synchronous_speed, .. }) = self.motor else { return };
        let [load, torque] = [self.load, breakdown_torque].map(|torque| shown(torque, &NM));
        let (does, found) = match count {
            0 if self.load * synchronous_speed < 0.0 => ("runs away", "there is no periodic motion"),
            0 => ("stalls", "there is no periodic motion"),
            _ => ("stalls or runs away", "no periodic motion is stable"),
        };
        verdict.result(
            Level::Bad,
            format!("The motor {does}: against a load of {load} {found}. Its breakdown torque is {torque}."),
        );
        verdict.advice("Reduce the load, or take a stronger motor.");
    }

    /// Torques, vibration, impacts and contact over a turn.
    fn of_turn(&self, turn: &Turn, verdict: &mut Verdict) {
        let torques = turn.outputs.iter().filter(|of| of.unit == "N.m").map(|of| of.size);
        let size = torques.fold(0.0, f64::max);
        let torque = tables::mean(turn.mean_torque, size);
        // A thousandth of the largest torque is of no account.
        if torque.abs() > 1e-3 * size {
            let power = tables::mean(turn.mean_power, size * turn.mean_speed.abs());
            let (torque, power) = (shown(torque, &NM), shown(power, &W));
            verdict.result(Level::Good, format!("It takes a mean torque of {torque} and a mean power of {power}."));
        }
        let worst = self.dwells.iter().max_by(|a, b| a.largest.total_cmp(&b.largest));
        if let Some(dwell) = worst.filter(|dwell| dwell.clean(dwell.largest) > 0.0) {
            let Dwell { output, from, to, largest, rms, .. } = dwell;
            let ([from, to], [largest, rms]) =
                ([*from, *to].map(|phi| shown(in_a_turn(phi), &DEG)), [*largest, *rms].map(|value| dwell.shown(value)));
            verdict.result(
                Level::Good,
                format!("In the dwell from {from} to {to} `{output}` vibrates by up to {largest} ({rms} rms)."),
            );
        }
        // The judgement has those that lift off.
        for (level, sentence) in self.lift_offs.iter().flatten().map(LiftOff::judged) {
            if level == Level::Good {
                verdict.result(level, sentence);
            }
        }
    }

    /// The report.
    pub fn report(&self) -> Report {
        let (rows, digits) = (self.rows(), self.digits());
        let mut report = Report::new(&self.name, "periodic motion");
        report.verdict = self.verdict();
        let motions = Table::of("Motions", &rows)
            .column("motion", "motion", ONE, |(name, ..)| name)
            .column("period", "period", MS, |(_, speeds, _)| speeds.period)
            .digits(digits)
            .column("mean", "mean speed", RPM, |(_, speeds, _)| speeds.mean_speed)
            .digits(digits)
            .column("speed", "speed", RPM, |(_, speeds, _)| [speeds.least_speed, speeds.largest_speed])
            .column("fluctuation", "fluctuation", PERCENT, |(_, speeds, _)| speeds.fluctuation())
            .column("multiplier", "multiplier", ONE, |(.., motion)| {
                motion.filter(|motion| !motion.growth.is_nan()).map(|motion| multiplier(motion.growth))
            })
            .below(["Multiplier: the fraction of a small disturbance that is left after one turn.".to_owned()]);
        let points = rows.iter().flat_map(|(name, speeds, _)| speeds.course.iter().map(move |point| (name, point)));
        let points: Vec<(&String, &[f64; 2])> = points.collect();
        let course = Table::file("steady", &points)
            .column("motion", "", ONE, |(name, _)| *name)
            .column("phi", "", DEG, |(_, [phi, _])| *phi)
            .column("w", "", RPM, |(_, [_, w])| *w);
        report.table(motions).table(course);
        if !self.mechanisms.is_empty() {
            report.table(transmissions(&self.mechanisms));
        }
        if let Some(turn) = &self.turn {
            report.table(tables::outputs(turn)).table(tables::course(turn));
            report
                .table(tables::impacts(turn))
                .table(tables::dwells(&self.dwells))
                .table(tables::harmonics(&self.harmonics));
            report.explain_table(tables::multipliers(turn));
            for (key, diagram) in tables::diagrams(&self.name, turn) {
                report.diagram(&key, diagram);
            }
        }
        let equation = match self.turn {
            Some(_) => "The equations of the model are solved",
            None => "J(φ) φ̈ + ½ J′(φ) φ̇² = M is integrated",
        };
        let equation = format!(
            "{equation} over turns; a motion is periodic where a turn ends as it began, and stable where all multipliers of \
             Floquet, the eigenvalues of that map, are below 1 in size."
        );
        let kloss = "The torque of an asynchronous motor is that of Kloss, M = 2 M_k / (s/s_k + s_k/s), with its lag where the \
                     scene names one.";
        let lines = [Some(equation), self.motor.as_ref().map(|_| kloss.to_owned())];
        report.explain("How it was found", lines.into_iter().flatten());
        if rows.iter().any(|(_, speeds, _)| speeds.fluctuation() > 0.0) {
            report.diagram("steady", self.diagram(&rows));
        }
        report
    }

    fn diagram(&self, rows: &[(String, &Speeds, Option<&Motion>)]) -> Diagram {
        let point = |[phi, w]: &[f64; 2]| [phi * DEG.factor, w * RPM.factor];
        let series = rows.iter().map(|(name, speeds, _)| Series::line(name.clone(), speeds.course.iter().map(point)));
        let axes = [Axis::angular("Angle of the main shaft [°]"), Axis::linear("Speed [rpm]")];
        Diagram::new(format!("Periodic motions of {}", self.name), axes, series.collect(), Vec::new())
    }
}

/// The mechanisms between cams and tools.
fn transmissions(mechanisms: &[Transmission]) -> Table {
    Table::of("Mechanisms", mechanisms)
        .column("follower", "follower", ONE, |of| of.follower)
        .column("mechanism", "mechanism", ONE, |of| format!("linkage[{}] ({})", of.mechanism, of.kind))
        .column("least_angle", "least transmission angle", DEG, |of| Value::At(of.least_angle, of.phi))
        .digits(4)
        .into()
}
