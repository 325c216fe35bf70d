//! Forces over the turn as diagrams.

use super::quantity::Quantity;
use super::turn::{MachineTurn, State};
use super::{Drive, Machine};
use crate::plot::{Axis, Diagram, Rule, Series};

fn diagram(title: String, ordinate: String, series: Vec<Series>) -> Diagram {
    let axes = [Axis::angular("Angle of the cam [°]").between(0.0, 360.0), Axis::linear(&ordinate)];
    Diagram::new(title, axes, series, vec![Rule::Horizontal(0.0, String::new())])
}

fn line(turn: &MachineTurn<'_>, name: &str, of: impl Fn(&State) -> f64) -> Series {
    Series::line(name, turn.states().map(|state| [state.phi.to_degrees(), of(state)]))
}

/// Diagrams of a drive with their names: force and pressure of the roller, the forces in the joints of each mechanism.
pub fn of_drive(turn: &MachineTurn<'_>, j: usize, drive: &Drive) -> Vec<(String, Diagram)> {
    let quantities = drive.quantities();
    let of = |file: String, what: &str, begin: &str| {
        let shown = quantities.iter().filter(|q| !q.part && q.key.starts_with(begin) && !q.key.ends_with("_input"));
        let shown: Vec<&Quantity<'_>> = shown.collect();
        let unit = shown.first()?.unit.0;
        // The title already says this part.
        let name = |q: &Quantity<'_>| q.name.rsplit([',', ':']).next().unwrap_or_default().trim().to_owned();
        let series = shown.iter().map(|q| line(turn, &name(q), |state| (q.of)(&state.drives[j]))).collect();
        Some((file, diagram(format!("{what}, {}", drive.name), format!("{what} [{unit}]"), series)))
    };
    let mechanisms = (1..=drive.follower.linkage.0.len())
        .map(|i| of(format!("linkage{i}"), &format!("Forces in the joints of linkage[{i}]"), &format!("linkage{i}_")));
    let roller = [
        of("roller_force".to_owned(), "Roller force", "roller_force"),
        of("hertzian_pressure".to_owned(), "Hertzian pressure", "hertzian_pressure"),
    ];
    roller.into_iter().chain(mechanisms).flatten().collect()
}

/// The torque on the shaft: of each drive, and in all.
pub fn torque(turn: &MachineTurn<'_>, machine: &Machine) -> Diagram {
    let own = |(j, drive): (usize, &Drive)| line(turn, &drive.name, move |state| state.drives[j].torque);
    let mut series: Vec<Series> = machine.drives.iter().enumerate().map(own).collect();
    if series.len() != 1 || machine.inertia.is_some() {
        series.push(line(turn, "all together", |state| state.torque));
    }
    diagram(format!("Torque on the shaft of {}", machine.name), "Torque [N·m]".to_owned(), series)
}
