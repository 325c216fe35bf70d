//! What is to be known of a system before it runs: algebraic loops, and the largest steps of its shafts.

use super::wiring::Wiring;
use super::{Connection, INERTIA, MOTION, Part, Shaft, System};
use crate::scene::section::Section;
use camdrive::drives::variable::Causality;
use camdrive_design::coupling::stability::{Exchange, Load, least_inertia, limit, load};
use camdrive_design::resource::Scene;
use camdrive_design::text::{number, time};

impl System {
    /// The algebraic loops: connections each of which depends directly on all the others.
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

impl Part {
    /// Whether an output depends directly on an input.
    fn depends(&self, output: &str, input: &str) -> bool {
        let of = self.find(output, Causality::Output);
        of.is_some_and(|v| v.by_all || v.about.dependencies.iter().any(|name| name == input))
    }
}

/// Refuses a step that does not divide the time of the run where a part takes steps of one length only.
pub fn lengths(root: &Section<'_>, wiring: &Wiring<'_>, stop: f64, step: f64) -> Option<()> {
    let rest = stop - (stop / step).round() * step;
    let Some(part) = wiring.raw.iter().map(|raw| &raw.part).find(|part| !part.capabilities.variable_steps) else {
        return Some(());
    };
    if rest.abs() <= SAME * stop {
        return Some(());
    }
    let said = format!(
        ": part {} takes steps of one length only (canHandleVariableCommunicationStepSize), of which {} leaves a rest of {}",
        part.name,
        time(stop),
        time(rest.rem_euclid(step))
    );
    root.refuse(root.fault_of("step", said).hint("take a step that divides `stop`"))
}

/// The shafts of a system with what is on them.
pub struct Judged {
    exchange: Exchange,
    /// The place of a machine, its least inertia (kg·m²), its loads with their ratios and whether it has their inertia.
    known: Vec<(usize, f64, Vec<(f64, Load, bool)>)>,
    /// Whether all that is known allows repeating a step unasked, if that is stable.
    repeatable: bool,
    /// What the limits leave out.
    pub notes: Vec<String>,
}

impl Judged {
    /// Of these parts and connections.
    pub fn new(parts: &[&Part], connections: &[Connection], exchange: Exchange) -> Self {
        let scenes: Vec<Option<(Scene, Vec<&str>)>> = parts.iter().map(|part| part.started()).collect();
        let mut notes = Vec::new();
        let of_shaft = |machine: usize| {
            let inertia = least_inertia(&scenes[machine].as_ref()?.0)?;
            let (mut loads, mut on) = (Vec::new(), vec![machine]);
            for (drive, scene) in scenes.iter().enumerate() {
                let Some(ratio) = ratio(connections, machine, drive) else { continue };
                on.push(drive);
                if let Some((scene, _)) = scene {
                    let own = connections.iter().any(|c| c.from == (drive, INERTIA[0].to_owned()));
                    loads.push((ratio, load(scene), own));
                }
            }
            for part in on.iter().filter(|_| on.len() > 1) {
                let unknown = match &scenes[*part] {
                    None => "inertia and stiffness of an FMU are not known; the limits of its shaft leave them out"
                        .to_owned(),
                    Some((_, unknown)) if unknown.is_empty() => continue,
                    Some((_, unknown)) => {
                        format!("the limits of its shaft have the values of the scene for {}", unknown.join(", "))
                    }
                };
                notes.push(format!("part {}: {unknown}", parts[*part].name));
            }
            (!loads.is_empty()).then_some((machine, inertia, loads))
        };
        let known = (0..scenes.len()).filter_map(of_shaft).collect();
        let restorable = parts.iter().all(|part| part.capabilities.saves_states);
        let repeatable = exchange.interpolates() && restorable && scenes.iter().all(Option::is_some);
        Judged { exchange, known, repeatable, notes }
    }

    /// The limits of the shafts where each step is repeated so often.
    fn limits(&self, repeats: u32) -> Vec<Shaft> {
        let of = |(machine, inertia, loads): &(usize, f64, Vec<_>)| Shaft {
            machine: *machine,
            limit: limit(self.exchange, repeats, *inertia, loads),
        };
        self.known.iter().map(of).collect()
    }

    /// The limits, and how often a step of this length (s) is repeated: once where that is known to be stable.
    pub fn unasked(&self, step: f64) -> (Vec<Shaft>, u32) {
        let once = self.limits(0);
        if self.repeatable && largest_kappa(&once) <= REPEATED {
            let repeated = self.limits(1);
            if !repeated.iter().any(|shaft| shaft.is_beyond(step)) {
                return (repeated, 1);
            }
        }
        (once, 0)
    }
}

impl Shaft {
    /// Whether a step (s) is too long for it.
    fn is_beyond(&self, step: f64) -> bool {
        self.limit.stable.is_some_and(|longest| step > longest)
    }
}

fn largest_kappa(shafts: &[Shaft]) -> f64 {
    shafts.iter().fold(0.0, |most: f64, shaft| most.max(shaft.limit.kappa))
}

/// The ratio of a drive on the shaft of a machine, as its inputs phi, w, a are connected; None where none of its torques acts
/// there.
fn ratio(connections: &[Connection], machine: usize, drive: usize) -> Option<f64> {
    let from = |name: &str| {
        let is = |c: &&Connection| c.to.0 == drive && c.to.1 == name && c.from.0 == machine && c.from.1 == name;
        connections.iter().find(is)
    };
    let [phi, w, a] = MOTION.map(|name| from(name).map(|connection| connection.factor));
    let acts = connections.iter().any(|c| c.from.0 == drive && c.to.0 == machine);
    phi.filter(|_| acts && w == phi && a == phi)
}

/// The limits of all shafts and how often a step is repeated; refuses a step beyond.
pub fn shafts(
    root: &Section<'_>,
    wiring: &Wiring<'_>,
    exchange: Exchange,
    step: f64,
    asked: Option<u32>,
) -> Option<(Vec<Shaft>, u32)> {
    let parts: Vec<&Part> = wiring.raw.iter().map(|raw| &raw.part).collect();
    let judged = Judged::new(&parts, &wiring.connections, exchange);
    judged.notes.iter().for_each(|note| root.faults.note(note.clone()));
    let once = judged.limits(0);
    let mut stable = Some(());
    for Shaft { machine, limit } in once.iter().filter(|shaft| shaft.limit.kappa >= 1.0) {
        let said = format!(
            ": what follows the shaft of `{}` without slip has up to {} times its inertia; no step is stable",
            wiring.raw[*machine].part.name,
            number(limit.kappa)
        );
        let hint = match exchange {
            Exchange::EffectiveInertia => "write machine and drives as one DriveTrain",
            _ => "exchange = \"effective_inertia\" takes rigid loads out of the loop; or write one DriveTrain",
        };
        stable = root.refuse(root.fault_of("exchange", said).hint(hint));
    }
    stable?;
    let (shafts, repeats) = match asked {
        None => judged.unasked(step),
        Some(times) => {
            repeated(root, wiring, exchange, times, largest_kappa(&once))?;
            (judged.limits(times), times)
        }
    };
    for Shaft { machine, limit } in shafts.iter().filter(|shaft| shaft.is_beyond(step)) {
        let name = &wiring.raw[*machine].part.name;
        let longest = limit.stable.unwrap_or_default();
        let said = format!(": at {} the exchange on the shaft of `{name}` is unstable", time(step));
        let fault = root.fault_of("step", said).admissible(format!("at most {}", time(longest)));
        stable = root.refuse(fault.hint(match limit.recommended {
            Some(small) => format!("up to {} errors are small", time(small)),
            None => "errors are small at a small part of that".to_owned(),
        }));
    }
    stable.map(|()| (shafts, repeats))
}

/// The rounding of a time.
const SAME: f64 = 1e-9;

/// The largest J_load/J at which a step may be repeated, however often: one repetition is stable up to 0.41.
const MOST_REPEATED: f64 = 0.4;

/// J_load/J up to which a step is repeated unasked, half of that.
const REPEATED: f64 = 0.2;

/// Refuses to repeat steps that cannot be, or would be unstable.
fn repeated(root: &Section<'_>, wiring: &Wiring<'_>, exchange: Exchange, times: u32, kappa: f64) -> Option<()> {
    let fixed = wiring.raw.iter().map(|raw| &raw.part).find(|part| !part.capabilities.saves_states);
    if times == 0 {
        return Some(());
    }
    if !exchange.interpolates() {
        let fault = root.fault_of("repeat", " has no meaning here: only interpolated steps get better by it");
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
    /// Why a step of this length (s) is too long; None where it is not.
    pub fn too_long(&self, step: f64) -> Option<String> {
        let shaft = self.shafts.iter().find(|shaft| shaft.limit.kappa >= 1.0 || shaft.is_beyond(step))?;
        let name = &self.parts[shaft.machine].name;
        Some(match shaft.limit.stable {
            Some(most) if shaft.limit.kappa < 1.0 => {
                let (step, most) = (time(step), time(most));
                format!("at {step} the exchange on the shaft of `{name}` is unstable; expected at most {most}")
            }
            _ => format!(
                "what follows the shaft of `{name}` without slip has up to {} times its inertia; no step is stable",
                number(shaft.limit.kappa)
            ),
        })
    }
}
