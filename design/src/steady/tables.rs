//! Tables and diagrams of a turn.

use crate::periodic_turn::{Dwell, Harmonic, Impact, Range, Turn};
use crate::plot::{Axis, Diagram, Rule, Series};
use crate::report::unit::{DEG, HZ, NS, ONE, RPM};
use crate::report::{Table, Unit, Value};
use crate::text::{clean, digits_beside_one, in_a_turn};

/// This part of the size of an output is the error of its mean.
const OF_MEAN: f64 = 1e-6;

/// Parts of outputs that have a diagram, with its title.
const DIAGRAMS: [(&[&str], &str, &str); 5] = [
    (&["x", "U", "y"], "motion", "Law and tool"),
    (&["q", "gap"], "deformation", "Deformation and gap"),
    (&["force", "contact_force"], "force", "Force"),
    (&["tau"], "tau", "Torque from the shaft"),
    (&["M_an"], "motor", "Torque of the motor"),
];

fn unit(range: &Range) -> Unit {
    Unit::of(range.unit).sized(range.largest.abs().max(range.least.abs()))
}

/// A mean over the turn for people, of outputs of this size.
pub fn mean(value: f64, size: f64) -> f64 {
    clean(value, OF_MEAN / 1e-9 * size)
}

/// The outputs over the turn, each in its unit.
pub fn outputs(turn: &Turn) -> Table {
    let at = |phi: f64, value: f64, range: &Range| {
        let shown = range.clean(value) * unit(range).factor;
        if range.clean(range.largest - range.least) == 0.0 { Value::Number(shown) } else { Value::At(shown, phi) }
    };
    let note = "The means of force and torque contain the impulses of impacts, the rms values do not.".to_owned();
    // A prescribed speed says nothing.
    let moving = turn.outputs.iter().filter(|of| of.output != "w" || of.least < of.largest);
    Table::of("Over the turn", moving)
        .column("output", "output", ONE, |of| format!("{} [{}]", of.output, unit(of).name))
        .column("least", "least", ONE, |of| at(of.least_at, of.least, of))
        .column("largest", "largest", ONE, |of| at(of.largest_at, of.largest, of))
        .column("mean", "mean", ONE, |of| mean(of.mean, of.size) * unit(of).factor)
        .column("rms", "rms", ONE, |of| of.clean(of.rms) * unit(of).factor)
        .below((!turn.impulses.is_empty()).then_some(note))
        .into()
}

/// All outputs at the points, as a file.
pub fn course(turn: &Turn) -> Table {
    let rows: Vec<usize> = (0..turn.angles.len()).collect();
    let mut table = Table::file("turn", &rows).column("phi", "", DEG, |k| turn.angles[*k]);
    for range in &turn.outputs {
        table = table.column(range.output.clone(), "", Unit::of(range.unit), |k| range.values[*k]);
    }
    table.into()
}

/// The tools in the dwells.
pub fn dwells(dwells: &[Dwell]) -> Table {
    Table::of("Vibration in the dwells", dwells)
        .column("output", "output", ONE, |of| &of.output)
        .column("from", "from", DEG, |of| in_a_turn(of.from))
        .digits(4)
        .column("to", "to", DEG, |of| in_a_turn(of.to))
        .digits(4)
        .column("largest", "largest", ONE, |of| of.shown(of.largest))
        .column("rms", "rms", ONE, |of| of.shown(of.rms))
        .column("law", "of the law itself", ONE, |of| of.shown(of.law))
        .into()
}

/// More impacts than a table can be read with.
const MOST_IMPACTS: usize = 16;

/// The impacts, the hardest of many, in their order.
pub fn impacts(turn: &Turn) -> Table {
    let mut hardest: Vec<&Impact> = turn.impulses.iter().collect();
    hardest.sort_by(|a, b| b.impulse.total_cmp(&a.impulse));
    hardest.truncate(MOST_IMPACTS);
    hardest.sort_by(|a, b| a.phi.total_cmp(&b.phi));
    let count = turn.impulses.len();
    let most = (count > MOST_IMPACTS).then(|| format!("These are the hardest {MOST_IMPACTS} of {count}."));
    let follower = |of: &Impact| (turn.impacts.len() > 1).then_some(of.follower);
    Table::of("Impacts of a turn", hardest)
        .column("follower", "follower", ONE, follower)
        .column("at", "at", DEG, |of| of.phi)
        .digits(4)
        .column("on", "on", ONE, |of| of.on)
        .column("impulse", "impulse", NS, |of| of.impulse)
        .below(most)
        .into()
}

/// The strongest harmonics of the deformations, and where each is in resonance, where that is known.
pub fn harmonics(harmonics: &[Harmonic]) -> Table {
    let table = Table::of("Harmonics of the deformation", harmonics)
        .column("output", "output", ONE, |of| &of.output)
        .column("harmonic", "harmonic", ONE, |of| of.harmonic)
        .column("frequency", "frequency", HZ, |of| of.frequency)
        .column("amplitude", "amplitude", ONE, |of| crate::report::terminal::shown(of.amplitude, &Unit::of(of.unit)));
    match harmonics.iter().any(|of| of.resonance.is_some()) {
        true => table.column("resonance", "in resonance at", RPM, |of| of.resonance).into(),
        false => table.into(),
    }
}

/// The multipliers; a complex pair counts once.
pub fn multipliers(turn: &Turn) -> Table {
    let upper: Vec<&[f64; 2]> = turn.multipliers.iter().filter(|at| at[1] >= 0.0).collect();
    let sizes: Vec<f64> = upper.iter().map(|[re, im]| re.hypot(*im)).collect();
    let fine = digits_beside_one(&sizes);
    Table::of("Floquet multipliers of a turn", upper)
        .column("re", "real part", ONE, |[re, _]| *re)
        .digits(fine)
        .column("im", "imaginary part", ONE, |[_, im]| *im)
        .digits(fine)
        .column("size", "size", ONE, |[re, im]| re.hypot(*im))
        .digits(fine)
        .into()
}

/// Harmonics of a spectrum at least, and the part of the strongest below which it ends.
const FEWEST: usize = 12;
const END: f64 = 0.01;

/// The amplitudes of the deformations over the harmonic, a diagram for each unit.
pub fn spectra(name: &str, turn: &Turn) -> Vec<(String, Diagram)> {
    let mut all: Vec<(String, Diagram)> = Vec::new();
    for range in turn.outputs.iter().filter(|range| range.part().0 == "q") {
        let (series, unit) = (turn.series(range), unit(range));
        let strongest = series.iter().map(|of| of.amplitude).fold(0.0, f64::max);
        let count = series.iter().rposition(|of| of.amplitude > END * strongest).map_or(0, |last| last + 1);
        let shown = &series[..count.max(FEWEST)];
        // A comb, as one line.
        let tooth = |of: &Harmonic| [0.0, of.amplitude * unit.factor, 0.0].map(|y| [of.harmonic as f64, y]);
        let line = Series::line(range.output.clone(), shown.iter().flat_map(tooth));
        let key = format!("spectrum.{}", unit.key());
        match all.iter_mut().find(|(other, _)| *other == key) {
            Some((_, diagram)) => diagram.series.push(line),
            None => {
                let axes = [Axis::linear("Harmonic"), Axis::linear(&format!("Amplitude [{}]", unit.name))];
                all.push((
                    key,
                    Diagram::new(format!("Spectrum of the deformation of {name}"), axes, vec![line], Vec::new()),
                ));
            }
        }
    }
    all
}

/// The outputs over the angle, one diagram for each kind and unit.
pub fn diagrams(name: &str, turn: &Turn) -> Vec<(String, Diagram)> {
    let mut all = Vec::new();
    for (parts, key, title) in DIAGRAMS {
        let mut left: Vec<&Range> = turn.outputs.iter().filter(|range| parts.contains(&range.part().0)).collect();
        while let Some(first) = left.first() {
            let unit = unit(first);
            let (shown, others): (Vec<&Range>, Vec<&Range>) = left.iter().partition(|range| range.unit == first.unit);
            let points = |range: &Range| -> Vec<[f64; 2]> {
                turn.angles.iter().zip(&range.values).map(|(phi, v)| [phi * DEG.factor, v * unit.factor]).collect()
            };
            let has = |part: &str| shown.iter().any(|range| range.part().0 == part);
            let title = match [has("q"), has("gap")] {
                [true, false] => "Deformation",
                [false, true] => "Gap",
                _ => title,
            };
            // A single line needs no legend.
            let name_of = |range: &Range| if shown.len() == 1 { String::new() } else { range.output.clone() };
            let series = shown.iter().map(|range| Series::line(name_of(range), points(range))).collect();
            let axes = [Axis::angular("Angle of the shaft [°]"), Axis::linear(&format!("{title} [{}]", unit.name))];
            let zero = vec![Rule::Horizontal(0.0, String::new())];
            let key = if all.iter().any(|(other, _)| other == key) {
                format!("{key}.{}", unit.key())
            } else {
                key.to_owned()
            };
            all.push((key, Diagram::new(format!("{title} of {name}"), axes, series, zero)));
            left = others;
        }
    }
    all
}
