//! What is to be known of a system before it runs: algebraic loops, and the largest steps of its shafts.

use super::wiring::Wiring;
use super::{Content, INERTIA, Part, Seat, Shaft, System};
use crate::scene::section::Section;
use camdrive::drives::variable::Causality;
use camdrive_design::coupling::stability::{Exchange, Load, least_inertia, limit, load};
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

/// The limits of all shafts; refuses a step beyond them.
pub fn shafts(root: &Section<'_>, wiring: &Wiring<'_>, exchange: Exchange, step: f64) -> Option<Vec<Shaft>> {
    let parts = || wiring.raw.iter().map(|raw| &raw.part).enumerate();
    let (mut shafts, mut stable) = (Vec::new(), Some(()));
    for (machine, part) in parts() {
        let Content::Scene(scene) = &part.content else { continue };
        let Some(inertia) = least_inertia(&scene.scene) else { continue };
        let mut loads: Vec<(f64, Load, bool)> = Vec::new();
        for (i, drive) in parts() {
            let Some(Seat { ratio, .. }) = drive.seat.filter(|seat| seat.machine == machine) else { continue };
            match &drive.content {
                Content::Scene(scene) => {
                    let own = wiring.connections.iter().any(|c| c.from == (i, INERTIA[0].to_owned()));
                    loads.push((ratio, load(&scene.scene), own));
                }
                Content::Fmu(_) => root.faults.note(format!(
                    "part {}: inertia and stiffness of an FMU are not known; the limits of its shaft leave them out",
                    drive.name
                )),
            }
        }
        if loads.is_empty() {
            continue;
        }
        let limit = limit(exchange, inertia, &loads);
        let name = &part.name;
        if limit.kappa >= 1.0 {
            let said = format!(
                ": what follows the shaft of `{name}` without slip has up to {} times its inertia; no step is stable",
                number(limit.kappa)
            );
            let hint = match exchange {
                Exchange::EffectiveInertia => "write machine and drives as one DriveTrain",
                _ => "exchange = \"effective_inertia\" takes rigid loads out of the loop; or write one DriveTrain",
            };
            stable = root.refuse(root.fault_of("exchange", said).hint(hint));
        } else if let Some(longest) = limit.stable.filter(|longest| step > *longest) {
            let said = format!(": at {} the exchange on the shaft of `{name}` is unstable", time(step));
            let fault = root.fault_of("step", said).admissible(format!("at most {}", time(longest)));
            let small = limit.recommended.unwrap_or(longest).min(longest);
            stable = root.refuse(fault.hint(format!("up to {} errors are small", time(small))));
        }
        shafts.push(Shaft { machine, limit });
    }
    stable.map(|()| shafts)
}

/// The largest J_load/J at which a step may be repeated, however often: one repetition is stable up to 0.41.
const MOST_REPEATED: f64 = 0.4;

/// J_load/J up to which a step is repeated unasked, half of that.
const REPEATED: f64 = 0.2;

/// How often a step is repeated: as the file says, else once where that is known to be stable.
pub fn repeats(
    root: &Section<'_>,
    wiring: &Wiring<'_>,
    exchange: Exchange,
    asked: Option<u32>,
    shafts: &[Shaft],
) -> Option<u32> {
    let interpolates = matches!(exchange, Exchange::Interpolated | Exchange::EffectiveInertia);
    let kappa = shafts.iter().fold(0.0, |most: f64, shaft| most.max(shaft.limit.kappa));
    let known = wiring.raw.iter().all(|raw| matches!(raw.part.content, Content::Scene(_)));
    match asked {
        None => Some((interpolates && known && kappa <= REPEATED).into()),
        Some(1..) if !interpolates => {
            let fault = root.fault_of("repeat", " has no meaning here: only interpolated steps get better by it");
            root.refuse(fault.hint("remove it, or take exchange = \"interpolated\""))
        }
        Some(1..) if kappa > MOST_REPEATED => {
            let kappa = number(kappa);
            let said =
                format!(": with a load of up to {kappa} times the inertia of its shaft repeated steps are unstable");
            let fault = root.fault_of("repeat", said).admissible(format!("0 above {MOST_REPEATED}"));
            root.refuse(fault.hint("remove it, or take exchange = \"effective_inertia\""))
        }
        Some(times) => Some(times),
    }
}

impl System {
    /// Why a step of this length (s) is too long; None where it is not.
    pub fn too_long(&self, step: f64) -> Option<String> {
        let beyond = |shaft: &&Shaft| shaft.limit.stable.is_some_and(|stable| step > stable);
        let shaft = self.shafts.iter().find(beyond)?;
        let (name, most) = (&self.parts[shaft.machine].name, shaft.limit.stable.map_or_else(String::new, time));
        Some(format!("at {} the exchange on the shaft of `{name}` is unstable; expected at most {most}", time(step)))
    }
}
