//! The analysis of a system before it runs: algebraic loops, and the largest steps of its shafts.

use super::wiring::Wiring;
use super::{Connection, INERTIA, MOTION, Part, Shaft, System};
use crate::document::Section;
use camdrive::drives::variable::Causality;
use camdrive_design::coupling::exchange::SAME_RATIO;
use camdrive_design::coupling::stability::{self, Exchange, Loaded, least_inertia};
use camdrive_design::resource::Scene;
use camdrive_design::text::{self, number, time, time_within};

impl System {
    /// The algebraic loops: connections that each depend directly on all the others.
    pub fn loops(&self) -> Vec<Vec<usize>> {
        let all = &self.connections;
        let follows = |first: usize, next: usize| {
            let ((part, input), (from, output)) = (&all[first].to, &all[next].from);
            part == from && self.parts[*part].depends(output, input)
        };
        let reached = |start: usize| {
            let (mut found, mut open) = (vec![false; all.len()], vec![start]);
            while let Some(at) = open.pop() {
                let next: Vec<usize> = (0..all.len()).filter(|next| !found[*next] && follows(at, *next)).collect();
                next.iter().for_each(|next| found[*next] = true);
                open.extend(next);
            }
            found
        };
        let reach: Vec<Vec<bool>> = (0..all.len()).map(reached).collect();
        let whole = |i: usize| -> Vec<usize> { (0..all.len()).filter(|k| reach[i][*k] && reach[*k][i]).collect() };
        (0..all.len()).map(|i| (i, whole(i))).filter(|(i, whole)| whole.first() == Some(i)).map(|(_, of)| of).collect()
    }
}

/// Factor and offset of a connection between SI values.
fn between(parts: &[&Part], connection: &Connection) -> Option<[f64; 2]> {
    let Connection { from, to, factor, offset } = connection;
    let output = &parts[from.0].find(&from.1, Causality::Output)?.unit;
    let input = &parts[to.0].find(&to.1, Causality::Input)?.unit;
    let factor = factor * input.factor / output.factor;
    Some([factor, input.to_si(*offset) - factor * output.offset])
}

/// True if two ratios are equal.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_RATIO * a.abs()
}

impl System {
    /// A sentence for each drive that takes other work than its shaft gives. τ φ̇ is equal on both sides if the torque has the
    /// factor of the motion.
    pub fn unbalanced(&self) -> Vec<String> {
        let parts: Vec<&Part> = self.parts.iter().collect();
        let pairs = (0..parts.len()).flat_map(|machine| (0..parts.len()).map(move |drive| (machine, drive)));
        pairs.filter(|(machine, drive)| machine != drive).flat_map(|at| self.unbalanced_drive(&parts, at)).collect()
    }

    /// Its notes, with the notes on unbalanced work.
    pub fn remarks(&self) -> Vec<String> {
        [&self.notes[..], &self.unbalanced()].concat()
    }

    fn unbalanced_drive(&self, parts: &[&Part], (machine, drive): (usize, usize)) -> Vec<String> {
        let last = |name: &str| name.rsplit('.').next().unwrap_or_default().to_owned();
        let between_both = |from: usize, to: usize| {
            let own = self.connections.iter().filter(move |c| (c.from.0, c.to.0) == (from, to));
            own.filter_map(|c| Some((c, between(parts, c)?)))
        };
        let motion = MOTION.map(|name| {
            between_both(machine, drive).find(|(c, _)| last(&c.from.1) == name && last(&c.to.1) == name).map(|of| of.1)
        });
        let [phi, Some([ratio, beyond]), a] = motion else { return Vec::new() };
        let names = [machine, drive].map(|part| &parts[part].name);
        let differs = |of: Option<[f64; 2]>| of.is_some_and(|[factor, _]| !is_same(ratio, factor));
        if differs(phi) || differs(a) || beyond != 0.0 || a.is_some_and(|[_, offset]| offset != 0.0) {
            let [machine, drive] = names;
            return vec![format!(
                "phi, w and a of {drive} contradict each other: they need the same factor on {machine}'s, and only phi may have an offset."
            )];
        }
        let mut all = Vec::new();
        for (c, [factor, offset]) in between_both(drive, machine) {
            let expected = match last(&c.from.1).as_str() {
                "tau" | "tau_mean" | "tau_rest" => ratio,
                "J_load" => ratio * ratio,
                "dJ_load" => ratio.powi(3),
                _ => continue,
            };
            if !is_same(expected, factor) {
                let [machine, drive] = names;
                all.push(format!(
                    "{drive}.{} acts on {machine} with the factor {}; with {} the shaft would give the work that {drive} takes.",
                    c.from.1,
                    text::digits(factor, FINE, -4),
                    text::digits(expected, FINE, -4)
                ));
            } else if offset != 0.0 {
                let [machine, drive] = names;
                all.push(format!("{machine} feels {} N·m more than {drive} gives: {}.", number(offset), c.from.1));
            }
        }
        all
    }
}

impl Part {
    /// True if an output depends directly on an input.
    fn depends(&self, output: &str, input: &str) -> bool {
        let of = self.find(output, Causality::Output);
        of.is_some_and(|v| v.by_all || v.about.dependencies.iter().any(|name| name == input))
    }
}

/// Refuses a step that does not divide the time of the run if a part admits only one length of steps.
pub fn lengths(root: &Section<'_>, wiring: &Wiring<'_>, stop: f64, step: f64) -> Option<()> {
    let rest = stop - (stop / step).round() * step;
    let Some(part) = wiring.raw.iter().map(|raw| &raw.part).find(|part| !part.description.capabilities.variable_steps)
    else {
        return Some(());
    };
    if rest.abs() <= SAME * stop {
        return Some(());
    }
    let said = format!(
        ": part {} takes steps of one length only (canHandleVariableCommunicationStepSize), and {} leaves a rest of {}",
        part.name,
        time(stop),
        time(rest.rem_euclid(step))
    );
    root.refuse(root.fault_of("step", said).hint("choose a step that divides `stop`"))
}

/// The shafts of a system with the loads on them.
pub struct SystemAnalysis {
    exchange: Exchange,
    /// The index of each machine with the loads on its shaft.
    known: Vec<(usize, Loaded)>,
    /// True if the known loads allow to repeat a step by default, if that is stable.
    repeatable: bool,
    /// Notes on what the limits leave out.
    pub notes: Vec<String>,
}

impl SystemAnalysis {
    /// Of these parts and connections.
    pub fn new(parts: &[&Part], connections: &[Connection], exchange: Exchange) -> Self {
        let scenes: Vec<Option<(Scene, Vec<&str>)>> = parts.iter().map(|part| part.started()).collect();
        let mut notes = Vec::new();
        let of_shaft = |machine: usize| {
            let inertia = least_inertia(&scenes[machine].as_ref()?.0)?;
            let (mut loads, mut on) = (Vec::new(), vec![machine]);
            for (drive, scene) in scenes.iter().enumerate() {
                let Some(ratio) = ratio(parts, connections, machine, drive) else { continue };
                on.push(drive);
                if let Some((scene, _)) = scene {
                    let own = connections.iter().any(|c| c.from == (drive, INERTIA[0].to_owned()));
                    loads.extend(stability::loads(scene).into_iter().map(|load| (ratio, load, own)));
                }
            }
            for part in on.iter().filter(|_| on.len() > 1) {
                let capabilities = &parts[*part].description.capabilities;
                let unknown = match &scenes[*part] {
                    None if *part != machine && !capabilities.interpolates_inputs => {
                        "it takes no input derivatives: its use of phi, w, a within a step, its inertia and its stiffness are \
                         unknown, and the limits of its shaft ignore them. Compare a run with a run at half the step"
                            .to_owned()
                    }
                    None => "inertia and stiffness of an FMU are unknown; the limits of its shaft ignore them"
                        .to_owned(),
                    Some((_, unknown)) if unknown.is_empty() => continue,
                    Some((_, unknown)) => {
                        format!("the limits of its shaft have the values of the scene for {}", unknown.join(", "))
                    }
                };
                notes.push(format!("part {}: {unknown}", parts[*part].name));
            }
            (!loads.is_empty()).then(|| (machine, Loaded::new(inertia, &loads)))
        };
        let known = (0..scenes.len()).filter_map(of_shaft).collect();
        let restorable = parts.iter().all(|part| part.description.capabilities.saves_states);
        let repeatable = exchange.interpolates() && restorable && scenes.iter().all(Option::is_some);
        SystemAnalysis { exchange, known, repeatable, notes }
    }

    /// The limits of the shafts where each step is repeated so often.
    fn limits(&self, repeats: u32) -> Vec<Shaft> {
        let of = |(machine, loaded): &(usize, Loaded)| Shaft {
            machine: *machine,
            limit: loaded.limit(self.exchange, repeats),
        };
        self.known.iter().map(of).collect()
    }

    /// The largest κ of all shafts.
    fn kappa(&self) -> f64 {
        self.known.iter().fold(0.0, |most: f64, (_, loaded)| most.max(loaded.kappa()))
    }

    /// The default number of repetitions of a step of this length (s): one if that is stable. If no number is stable, the one that
    /// admits the longer steps.
    fn unasked(&self, step: f64) -> u32 {
        let grows = |repeats: u32| self.known.iter().any(|(_, loaded)| loaded.grows(self.exchange, repeats, step));
        let longest = |repeats: u32| {
            let limits = self.limits(repeats).into_iter().filter_map(|shaft| shaft.limit.stable);
            limits.fold(f64::INFINITY, f64::min)
        };
        let once = || !grows(1) || (grows(0) && longest(1) > longest(0));
        u32::from(self.repeatable && self.kappa() <= REPEATED && once())
    }

    /// The limits, and the number of repetitions of a step of this length (s).
    pub fn shafts(&self, asked: Option<u32>, step: f64) -> (Vec<Shaft>, u32) {
        let repeats = asked.unwrap_or_else(|| self.unasked(step));
        (self.limits(repeats), repeats)
    }
}

impl Shaft {
    /// True if a step (s) is too long for this shaft.
    fn is_beyond(&self, step: f64) -> bool {
        self.limit.stable.is_some_and(|longest| step > longest)
    }
}

/// The ratio of a drive on the shaft of a machine, from the connections of its inputs phi, w, a; None if none of its torques acts
/// there.
fn ratio(parts: &[&Part], connections: &[Connection], machine: usize, drive: usize) -> Option<f64> {
    let factor = |name: &str| {
        let is = |c: &&Connection| c.to.0 == drive && c.to.1 == name && c.from.0 == machine && c.from.1 == name;
        let connection = connections.iter().find(is)?;
        let unit = |part: usize, causality| parts[part].find(name, causality).map_or(1.0, |v| v.unit.factor);
        Some(connection.factor * unit(drive, Causality::Input) / unit(machine, Causality::Output))
    };
    let [phi, w, a] = MOTION.map(factor);
    let acts = connections.iter().any(|c| c.from.0 == drive && c.to.0 == machine);
    let fits = |other: Option<f64>| phi.zip(other).is_some_and(|(a, b)| is_same(a, b));
    phi.filter(|_| acts && fits(w) && fits(a))
}

/// The limits of all shafts and the number of repetitions of a step; refuses longer steps than the limits.
pub fn shafts(
    root: &Section<'_>,
    wiring: &Wiring<'_>,
    exchange: Exchange,
    step: f64,
    asked: Option<u32>,
) -> Option<(Vec<Shaft>, u32)> {
    let parts: Vec<&Part> = wiring.raw.iter().map(|raw| &raw.part).collect();
    let judged = SystemAnalysis::new(&parts, &wiring.connections, exchange);
    judged.notes.iter().for_each(|note| root.faults.note(note.clone()));
    let mut stable = Some(());
    for (machine, loaded) in judged.known.iter().filter(|(_, loaded)| loaded.kappa() >= 1.0) {
        let said = format!(
            ": the parts that follow the shaft of `{}` without slip have up to {} times its inertia; no step is stable",
            wiring.raw[*machine].part.name,
            number(loaded.kappa())
        );
        let hint = match exchange {
            Exchange::EffectiveInertia => "write machine and drives as one DriveTrain",
            _ => "exchange = \"effective_inertia\" takes rigid loads out of the loop; or write one DriveTrain",
        };
        stable = root.refuse(root.fault_of("exchange", said).hint(hint));
    }
    stable?;
    repeated(root, wiring, exchange, asked.unwrap_or(0), judged.kappa())?;
    let (shafts, repeats) = judged.shafts(asked, step);
    for Shaft { machine, limit } in shafts.iter().filter(|shaft| shaft.is_beyond(step)) {
        let name = &wiring.raw[*machine].part.name;
        let longest = limit.stable.unwrap_or_default();
        let said = format!(": at {} the exchange on the shaft of `{name}` is unstable", time(step));
        let fault = root.fault_of("step", said).admissible(format!("at most {}", time_within(longest)));
        stable = root
            .refuse(fault.hint("errors are small at a small fraction of it: `camdrive system --study` measures them"));
    }
    stable.map(|()| (shafts, repeats))
}

/// Significant digits of a factor that distinguish it from a nearly equal one.
const FINE: usize = 7;

/// The relative rounding error of a time.
const SAME: f64 = 1e-9;

/// The largest J_load/J at which a step may be repeated, for any number of repetitions: one repetition is stable up to 0.41.
const MOST_REPEATED: f64 = 0.4;

/// J_load/J up to which a step is repeated by default, half of that.
const REPEATED: f64 = 0.2;

/// Refuses to repeat a step if it is impossible or unstable.
fn repeated(root: &Section<'_>, wiring: &Wiring<'_>, exchange: Exchange, times: u32, kappa: f64) -> Option<()> {
    let fixed = wiring.raw.iter().map(|raw| &raw.part).find(|part| !part.description.capabilities.saves_states);
    if times == 0 {
        return Some(());
    }
    if !exchange.interpolates() {
        let fault = root.fault_of("repeat", " has no meaning here: it improves only interpolated steps");
        return root.refuse(fault.hint("remove it, or take exchange = \"interpolated\""));
    }
    if let Some(part) = fixed {
        let said = format!(": part {} cannot restore its state (canGetAndSetFMUstate)", part.name);
        return root.refuse(root.fault_of("repeat", said).admissible("0").hint("remove it"));
    }
    if kappa > MOST_REPEATED {
        let kappa = number(kappa);
        let said = format!(": with a load of up to {kappa} times the inertia of its shaft repeated steps are unstable");
        let fault = root.fault_of("repeat", said).admissible(format!("0 above {MOST_REPEATED}"));
        return root.refuse(fault.hint("remove it, or take exchange = \"effective_inertia\""));
    }
    Some(())
}

impl System {
    /// The limits of the shafts with this many repetitions of each step.
    pub fn limits(&self, repeats: u32) -> Vec<Shaft> {
        SystemAnalysis::new(&self.parts.iter().collect::<Vec<_>>(), &self.connections, self.exchange).limits(repeats)
    }

    /// The number of repetitions of a step of this length (s) with these additional start values: the index of a part, the name and
    /// the value in its unit.
    ///
    /// # Errors
    /// The reason why such steps are unstable.
    pub fn repeats(&self, starts: &[(usize, &str, f64)], step: f64) -> Result<u32, String> {
        let mut parts = self.parts.clone();
        for (part, name, value) in starts {
            let own = &mut parts[*part].start;
            own.retain(|(other, _)| other != name);
            own.push(((*name).to_owned(), *value));
        }
        let judged = SystemAnalysis::new(&parts.iter().collect::<Vec<_>>(), &self.connections, self.exchange);
        let repeats = self.asked.unwrap_or_else(|| judged.unasked(step));
        for (machine, loaded) in &judged.known {
            let (name, kappa) = (&self.parts[*machine].name, loaded.kappa());
            let what = format!(
                "the parts that follow the shaft of `{name}` without slip have up to {} times its inertia",
                number(kappa)
            );
            if kappa >= 1.0 {
                return Err(format!("{what}; no step is stable"));
            }
            if repeats > 0 && kappa > MOST_REPEATED {
                return Err(format!("{what}; repeated steps are unstable"));
            }
            if loaded.grows(self.exchange, repeats, step) {
                let most = loaded.limit(self.exchange, repeats).stable.map_or_else(String::new, time_within);
                let step = time(step);
                return Err(format!(
                    "at {step} the exchange on the shaft of `{name}` is unstable; expected at most {most}"
                ));
            }
        }
        Ok(repeats)
    }
}
