//! The motion that a drive with backlash settles to: all passages with the effects of earlier impacts.

use super::machine::Machine;
use camdrive::drives::Fault;
use serde::Serialize;

/// Turns of a run; the second half of them counts.
const TURNS: usize = 40;
/// Those of a run that does not repeat after [`TURNS`]: ten vibrations a turn with a damping ratio of
/// 0.001 need about so many.
const MOST_TURNS: usize = 640;
/// A turn is taken in so many parts, so that the log, which holds 32 events, holds all of a part unless m1 chatters.
const PARTS: usize = 256;
/// Turns repeat each other when their losses differ by less: far above rounding, far below any change of the sequence.
const REPEATS: f64 = 1e-6;

/// A turn of the settled motion, on average over its second half.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SettledMotion {
    /// Turns that count.
    pub turns: usize,
    /// Impacts per turn.
    pub impacts: f64,
    /// The largest impulse (N·s).
    pub largest_impulse: f64,
    /// Energy lost in impacts per turn (J).
    pub loss: f64,
    /// True if each turn repeats the one before it.
    pub repeats: bool,
}

/// Runs `turns` turns from φ = 0 with this q (m), q̇ (m/s), or as many as it takes to repeat.
pub fn run(machine: &mut Machine, start: [f64; 2], turns: Option<usize>) -> Result<SettledMotion, Fault> {
    let found = run_for(machine, start, turns.unwrap_or(TURNS))?;
    let is_long_enough = found.repeats || turns.is_some();
    // Where the work admits no longer run, the short one stays.
    Ok(if is_long_enough { found } else { run_for(machine, start, MOST_TURNS).unwrap_or(found) })
}

fn run_for(machine: &mut Machine, start: [f64; 2], turns: usize) -> Result<SettledMotion, Fault> {
    if turns < 2 {
        return Err(
            Fault::new(format!("--turns {turns} is too few: half of them are left out; give at least 2")).of("--turns")
        );
    }
    machine.begin(0.0, Some(start), false)?;
    let turn = machine.turn();
    let skipped = turns / 2;
    let (mut impacts, mut losses, mut largest) = (Vec::new(), Vec::new(), 0.0f64);
    let mut last = machine.moment()?;
    for i in 0..turns {
        for part in 1..=PARTS {
            let events = machine.go((i as f64 + part as f64 / PARTS as f64) * turn)?;
            if i >= skipped {
                let impulses = events.iter().filter(|event| event.kind.starts_with("impact"));
                largest = impulses.fold(largest, |largest, event| largest.max(event.value.abs()));
            }
        }
        let now = machine.moment()?;
        if i >= skipped {
            impacts.push(now.impacts - last.impacts);
            losses.push(now.loss - last.loss);
        }
        last = now;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let scale = losses.iter().copied().fold(0.0, f64::max);
    let pairs = |values: &[f64], tolerance: f64| values.windows(2).all(|pair| (pair[0] - pair[1]).abs() <= tolerance);
    Ok(SettledMotion {
        turns: turns - skipped,
        impacts: mean(&impacts),
        largest_impulse: largest,
        loss: mean(&losses),
        // A single turn says nothing about the next one.
        repeats: impacts.len() > 1 && pairs(&impacts, 0.0) && pairs(&losses, REPEATS * scale),
    })
}
