//! The multipliers of Floquet of a drive at constant speed: the fraction of a small disturbance of q and q̇ that is left after
//! a turn.

use super::{TOLERANCE, Turn, Walk, place, prepared};
use crate::resource::Scene;
use camdrive::drives::Fault;
use nalgebra::DMatrix;

/// A disturbance in parts of the largest q and q̇ of the turn, if the motion is linear in both: the larger, the less rounding.
const LINEAR: f64 = 1.0;

/// The same with a clearance, which it must not cross.
const SMALL: f64 = 1e-3;

/// The eigenvalues [re, im] of the columns of a map, the largest one first.
pub fn eigenvalues(columns: &[impl AsRef<[f64]>]) -> Vec<[f64; 2]> {
    let n = columns.len();
    // A stiff mass that is on its flank at φ = 0 has no multipliers.
    if n == 0 || columns.iter().any(|column| column.as_ref().iter().any(|x| !x.is_finite())) {
        return Vec::new();
    }
    let values = DMatrix::from_fn(n, n, |i, k| columns[k].as_ref()[i]).complex_eigenvalues();
    let mut multipliers: Vec<[f64; 2]> = values.iter().map(|value| [value.re, value.im]).collect();
    multipliers.sort_by(|a, b| b[0].hypot(b[1]).total_cmp(&a[0].hypot(a[1])));
    multipliers
}

/// The multipliers of a drive at constant speed with the states q and q̇; with clearance only if it is in contact at φ = 0
/// before and after the turn.
pub fn multipliers(scene: &Scene, turn: &Turn) -> Result<Vec<[f64; 2]>, Fault> {
    let refused = || Fault::new("the states are not q and q̇ alone");
    let drive = prepared(scene, "steady_state", TOLERANCE)?;
    let all = drive.descriptions().to_vec();
    let find = |name: &str| place(&all, name).ok_or_else(refused);
    let (states, starts) = ([find("q")?, find("der(q)")?], [find("start.q")?, find("start.q_dot")?]);
    let contact = place(&all, "contact");
    let mut begun = prepared(scene, "steady_state", TOLERANCE)?;
    begun.start()?;
    let first = [begun.get(states[0])?, begun.get(states[1])?];
    let held = contact.map(|contact| begun.get(contact)).transpose()?;
    if held == Some(0.0) {
        return Err(refused());
    }
    let q = turn.output("q").map_or(0.0, |q| q.least.abs().max(q.largest.abs()));
    let part = if matches!(scene, Scene::ElasticOutput(_)) { LINEAR } else { SMALL };
    // A drive without vibration is disturbed by a micrometre, or a microradian.
    let sizes = [q, q * turn.mean_speed.abs()].map(|size| part * if size > 0.0 { size } else { 1e-6 });
    let end = |start: [f64; 2]| -> Result<[f64; 2], Fault> {
        let mut drive = prepared(scene, "given", TOLERANCE)?;
        for (place, value) in starts.iter().zip(start) {
            drive.set(*place, value)?;
        }
        drive.start()?;
        let mut walk = Walk { begin: drive.save(), drive, time: 0.0 };
        walk.to(turn.period)?;
        if contact.map(|contact| walk.drive.get(contact)).transpose()? != held {
            return Err(refused());
        }
        Ok([walk.drive.get(states[0])?, walk.drive.get(states[1])?])
    };
    let mut columns = Vec::new();
    for i in 0..2 {
        let mut ends = [[0.0; 2]; 2];
        for (ends, sign) in ends.iter_mut().zip([-1.0, 1.0]) {
            let mut start = first;
            start[i] += sign * sizes[i];
            *ends = end(start)?;
        }
        columns.push([0, 1].map(|k| (ends[1][k] - ends[0][k]) / (2.0 * sizes[i])));
    }
    Ok(eigenvalues(&columns))
}
