//! The compared settings: all dials that the drive declares, over communication steps and ways to pass inputs.

use super::run::{Grid, Inputs, Interface};
use camdrive::drives::variable::Kind;

/// The method whose dial is the internal step; all others work to the tolerance.
const BY_STEP: &str = "fixed_cost";

/// A setting of the solver and of the host.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The item of `solver.method` if the drive has it.
    pub method: Option<String>,
    /// `solver.tolerance` if the drive has it and the method works to it; 0 for the default.
    pub tolerance: Option<f64>,
    /// `solver.step_size` (s) if the method works with it; 0 for the default.
    pub step_size: Option<f64>,
    /// The values to be set.
    pub starts: Vec<(u32, f64)>,
    /// The communication points.
    pub grid: Grid,
    /// How inputs are passed if a run-up moves them.
    pub inputs: Option<Inputs>,
}

impl Setting {
    /// True if the solver uses its defaults.
    pub fn is_default(&self) -> bool {
        self.tolerance.unwrap_or(0.0) == 0.0 && self.step_size.unwrap_or(0.0) == 0.0
    }
}

/// Names and numbers of the items of `solver.method`.
pub fn methods(interface: &Interface) -> Vec<(String, f64)> {
    let kind = interface.find("solver.method").map(|reference| &interface.variables[reference as usize].kind);
    match kind {
        Some(Kind::Enumeration(e)) => {
            e.items.iter().enumerate().map(|(i, (name, _))| ((*name).to_owned(), (i + 1) as f64)).collect()
        }
        _ => Vec::new(),
    }
}

/// Relative tolerances; 0 is the default.
fn tolerances(quick: bool) -> Vec<f64> {
    let exponents = if quick { vec![3, 6, 9, 12] } else { (2..=13).collect() };
    exponents.into_iter().map(|n| 10f64.powi(-n)).chain([0.0]).collect()
}

/// Internal steps per turn; 0 is the default.
fn steps_per_turn(quick: bool) -> Vec<f64> {
    let powers = if quick { vec![4, 7, 10] } else { (4..=11).collect() };
    powers.into_iter().map(|n| 2f64.powi(n)).chain([0.0]).collect()
}

/// Communication steps as (stride, parts): 3⁴ to 3⁻³ intervals. Powers of three lie evenly on the axis and do not
/// fall into step with the 10 or 100 intervals of a turn.
fn communication(quick: bool) -> &'static [(usize, usize)] {
    match quick {
        true => &[(1, 1), (27, 1), (1, 9)],
        false => &[(1, 1), (3, 1), (9, 1), (27, 1), (81, 1), (1, 3), (1, 9), (1, 27)],
    }
}

/// All settings: the dials of each method at the instants of `grid`, and communication steps for a few of them. The
/// first one is the drive as the scene has it.
pub fn settings(interface: &Interface, grid: Grid, turn: f64, quick: bool) -> Vec<Setting> {
    let forms: &[Option<Inputs>] = if !interface.is_driven() {
        &[None]
    } else if interface.derivatives > 0 {
        &[Some(Inputs::Values), Some(Inputs::Derivatives)]
    } else {
        &[Some(Inputs::Values)]
    };
    let scene = |inputs| Setting { method: None, tolerance: None, step_size: None, starts: Vec::new(), grid, inputs };
    let mut list: Vec<Setting> = Vec::new();
    let mut add = |setting: Setting| {
        if !list.contains(&setting) {
            list.push(setting);
        }
    };
    for &inputs in forms {
        let dials = dials(interface, turn, quick, &scene(inputs));
        if dials.is_empty() {
            communication(quick).iter().for_each(|&(stride, parts)| {
                add(Setting { grid: Grid { stride, parts, ..grid }, ..scene(inputs) });
            });
        }
        // Over the communication steps: each method's default, and a coarse tolerance.
        let coarse = |setting: &Setting| setting.tolerance.is_some_and(|tolerance| (tolerance - 1e-3).abs() < 1e-9);
        for setting in dials.iter().filter(|s| s.is_default()).chain(dials.iter().filter(|s| coarse(s))) {
            for &(stride, parts) in communication(quick) {
                add(Setting { grid: Grid { stride, parts, ..grid }, ..setting.clone() });
            }
        }
        dials.into_iter().for_each(&mut add);
    }
    list
}

/// The setting of the whole drive to compare a drive without a feature with; [`defaults`] sets that drive in the same way: the
/// defaults at the instants, with the derivatives of inputs if the drive takes them.
pub fn whole(settings: &[Setting]) -> usize {
    let with_derivatives =
        |s: &Setting| s.is_default() && s.grid == settings[0].grid && s.inputs == Some(Inputs::Derivatives);
    settings.iter().position(with_derivatives).unwrap_or(0)
}

/// The values that set the solver of a drive to its defaults, whatever its scene asks for.
pub fn defaults(interface: &Interface) -> Vec<(u32, f64)> {
    let method = interface.find("solver.method").zip(methods(interface).first().map(|(_, number)| *number));
    let left = ["solver.tolerance", "solver.step_size"].map(|name| interface.find(name).map(|r| (r, 0.0)));
    method.into_iter().chain(left.into_iter().flatten()).collect()
}

/// Each value of each dial; the default of each method first.
fn dials(interface: &Interface, turn: f64, quick: bool, scene: &Setting) -> Vec<Setting> {
    let tolerance = interface.find("solver.tolerance");
    let step_size = interface.find("solver.step_size");
    let method = interface.find("solver.method");
    let mut choices: Vec<Option<(String, f64)>> = methods(interface).into_iter().map(Some).collect();
    if choices.is_empty() {
        choices.push(None);
    }
    let mut list = Vec::new();
    for choice in choices {
        let starts: Vec<(u32, f64)> = method.zip(choice.as_ref().map(|(_, number)| *number)).into_iter().collect();
        let with = |reference: u32, value: f64| starts.iter().copied().chain([(reference, value)]).collect();
        let name = choice.map(|(name, _)| name);
        if let Some(reference) = step_size.filter(|_| name.as_deref() == Some(BY_STEP)) {
            list.extend(steps_per_turn(quick).into_iter().rev().map(|per_turn| {
                let size = if per_turn > 0.0 { turn / per_turn } else { 0.0 };
                let starts = with(reference, size);
                Setting { method: name.clone(), step_size: Some(size), starts, ..scene.clone() }
            }));
        } else if let Some(reference) = tolerance {
            list.extend(tolerances(quick).into_iter().rev().map(|value| {
                let starts = with(reference, value);
                Setting { method: name.clone(), tolerance: Some(value), starts, ..scene.clone() }
            }));
        } else if name.is_some() {
            list.push(Setting { method: name, starts: starts.clone(), ..scene.clone() });
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::super::run_up::Signal;
    use super::*;
    use camdrive::drives::variable::{Causality, Variability, real};
    use camdrive::drives::{Description, settings, unit};

    fn variable(name: &str, kind: Kind) -> Description {
        Description {
            name: name.to_owned(),
            key: name.to_owned(),
            text: String::new(),
            kind,
            causality: Causality::Parameter,
            variability: Variability::Fixed,
            state: false,
            derivative_of: None,
            dependencies: vec![],
            initial_dependencies: vec![],
        }
    }

    fn interface(variables: Vec<Description>) -> Interface {
        Interface { variables, outputs: vec![], inputs: vec![], derivatives: 0 }
    }

    #[test]
    fn a_drive_without_dials_is_compared_over_communication_steps() {
        let grid = Grid::new(1e-3, 100);
        let list = settings(&interface(vec![]), grid, 0.1, false);
        assert_eq!(list.len(), 8);
        assert_eq!((list[0].grid, list[0].starts.len(), list[0].is_default()), (grid, 0, true));
        let mut driven = interface(vec![]);
        (driven.inputs, driven.derivatives) = (vec![(0, Signal::Angle)], 8);
        let list = settings(&driven, grid, 0.1, false);
        assert_eq!((list.len(), whole(&list)), (16, 8));
        assert_eq!((list[8].inputs, list[8].grid), (Some(Inputs::Derivatives), grid));
    }

    #[test]
    fn every_dial_that_the_drive_declares_is_turned() {
        let number = || real(&unit::NUMBER);
        let drive = interface(vec![
            variable("solver.tolerance", number()),
            variable("solver.method", Kind::Enumeration(&settings::METHOD)),
            variable("solver.step_size", number()),
        ]);
        let list = settings(&drive, Grid::new(1e-3, 100), 0.32, false);
        // Adaptive: 13 tolerances, 7 more communication steps of two of them; fixed_cost: 9 steps and 7 more.
        assert_eq!(list.len(), 13 + 2 * 7 + 9 + 7);
        assert_eq!((list[0].method.as_deref(), list[0].tolerance), (Some("adaptive"), Some(0.0)));
        assert_eq!(list[0].starts, [(1, 1.0), (0, 0.0)]);
        assert_eq!((whole(&list), defaults(&drive)), (0, vec![(1, 1.0), (0, 0.0), (2, 0.0)]));
        let coarsest = list.iter().filter_map(|s| s.step_size).fold(0.0, f64::max);
        assert!((coarsest - 0.02).abs() < 1e-15);
        assert!(list.iter().all(|s| s.tolerance.is_none() || s.step_size.is_none()));
    }
}
