//! The parameters of a motion law: one list for names, values and setting them.

use super::parameter::{LawParameter, ParameterKind};
use super::plan::LEAST_MOTION;
use super::{Cycle, CyclePlan, MotionLaw, StandardLaw};
use std::f64::consts::TAU;

impl MotionLaw {
    /// The parameters of the law: `a[0]` … `a[K]`, `b[1]` … `b[K]` of a Fourier series, stroke, angles and laws of a cycle, the
    /// scale of a table, the given values of a plan's points.
    pub fn parameters(&self) -> Vec<LawParameter> {
        use ParameterKind::*;
        match self {
            MotionLaw::Fourier(series) => {
                let coefficient = |letter: char, kind: &str, k: usize| {
                    let text = format!("{kind} coefficient of harmonic {k} of the position function");
                    LawParameter::new(format!("{letter}[{k}]"), text, Length)
                };
                let cosines = (0..=series.order()).map(|k| coefficient('a', "Cosine", k));
                cosines.chain((1..=series.order()).map(|k| coefficient('b', "Sine", k))).collect()
            }
            MotionLaw::Cycle(cycle) => {
                let motion = Angle { min: LEAST_MOTION, max: TAU };
                let mut list = vec![
                    LawParameter::new("stroke", "Lift from the lower to the upper dwell", Length),
                    LawParameter::new("lower", "Position in the lower dwell", Length),
                    LawParameter::new("rise_start", "Angle at which the rise starts", Angle { min: -TAU, max: TAU }),
                    LawParameter::new("rise", "Angle of the rise", motion),
                    LawParameter::new("upper_dwell", "Angle of the upper dwell", Angle { min: 0.0, max: TAU }),
                    LawParameter::new("return", "Angle of the return; the lower dwell is the rest of the turn", motion),
                    LawParameter::new("rise_law", "Law of the rise", Law),
                    LawParameter::new("return_law", "Law of the return", Law),
                ];
                let names = [("rise_inflection", "rise"), ("return_inflection", "return")];
                let given =
                    names.into_iter().zip(cycle.plan().inflections).filter(|(_, inflection)| inflection.is_some());
                list.extend(given.map(|((name, of), _)| {
                    let text =
                        format!("Inflection of the {of}, where the acceleration changes sign, as part of its angle");
                    LawParameter::new(name, text, Inflection)
                }));
                list
            }
            MotionLaw::Plan(plan) => plan.parameters(),
            MotionLaw::Table(_) => vec![LawParameter::new("scale", "Factor of the lifts of the table", Factor)],
            MotionLaw::Crank(_) => {
                let text = "Angle of the first mechanism's input link at shaft angle 0";
                vec![LawParameter::new("offset", text, Angle { min: -TAU, max: TAU })]
            }
            MotionLaw::Polyline(_) => vec![LawParameter::new("scale", "Factor of the values of the points", Factor)],
        }
    }

    /// The value of parameter `index` of [`MotionLaw::parameters`]; 0 beyond the list.
    pub fn parameter(&self, index: usize) -> f64 {
        match self {
            MotionLaw::Fourier(series) => series.coefficient(index).unwrap_or(0.0),
            MotionLaw::Cycle(cycle) => {
                let plan = cycle.plan();
                match index {
                    0 => plan.stroke,
                    1 => plan.lower,
                    2 => plan.rise_start,
                    3 => plan.rise_angle,
                    4 => plan.upper_dwell,
                    5 => plan.return_angle,
                    6 => plan.rise_law.number() as f64,
                    7 => plan.return_law.number() as f64,
                    _ => plan.inflections.into_iter().flatten().nth(index - 8).unwrap_or(0.0),
                }
            }
            MotionLaw::Table(table) => table.scale,
            MotionLaw::Crank(crank) => crank.offset,
            MotionLaw::Polyline(lines) => lines.scale(),
            MotionLaw::Plan(plan) => plan.parameter(index),
        }
    }

    /// Sets parameter `index`. [`MotionLaw::validate`] finds values that do not fit together.
    pub fn set_parameter(&mut self, index: usize, value: f64) {
        match self {
            MotionLaw::Fourier(series) => {
                if let Some(coefficient) = series.coefficient_mut(index) {
                    *coefficient = value;
                }
            }
            MotionLaw::Cycle(cycle) => {
                let mut plan: CyclePlan = *cycle.plan();
                match index {
                    0 => plan.stroke = value,
                    1 => plan.lower = value,
                    2 => plan.rise_start = value,
                    3 => plan.rise_angle = value,
                    4 => plan.upper_dwell = value,
                    5 => plan.return_angle = value,
                    6 => plan.rise_law = StandardLaw::from_number(value as usize),
                    7 => plan.return_law = StandardLaw::from_number(value as usize),
                    _ => {
                        if let Some(inflection) = plan.inflections.iter_mut().flatten().nth(index - 8) {
                            *inflection = value;
                        }
                    }
                }
                *cycle = Cycle::new(plan);
            }
            MotionLaw::Table(table) => table.scale = value,
            MotionLaw::Crank(crank) => crank.offset = value,
            MotionLaw::Polyline(lines) => lines.set_scale(value),
            MotionLaw::Plan(plan) => plan.set_parameter(index, value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::table::Points;
    use crate::motion::{Fourier, Polyline, Table};

    fn laws() -> [MotionLaw; 4] {
        let plan = CyclePlan {
            stroke: 0.04,
            lower: 0.01,
            rise_start: 0.5,
            rise_angle: 1.5,
            upper_dwell: 0.7,
            return_angle: 2.0,
            rise_law: StandardLaw::ModifiedTrapezoid,
            return_law: StandardLaw::ModifiedSine,
            inflections: [None; 2],
        };
        let points = Points { angles: vec![0.0, 1.5, 3.0, 4.5], lifts: vec![0.0, 0.1, 0.3, 0.2] };
        [
            MotionLaw::Fourier(Fourier::new(vec![0.1, 0.2, 0.3], vec![0.0, 0.4, 0.5])),
            MotionLaw::Cycle(Cycle::new(plan)),
            MotionLaw::Table(Table::new(points.clone()).unwrap()),
            MotionLaw::Polyline(Polyline::new(points).unwrap()),
        ]
    }

    #[test]
    fn what_is_set_is_read_and_changes_the_law() {
        for mut law in laws() {
            for (i, parameter) in law.parameters().into_iter().enumerate() {
                let before = law.clone();
                let value = if parameter.kind == ParameterKind::Law { 2.0 } else { law.parameter(i) + 0.01 };
                law.set_parameter(i, value);
                assert_eq!(law.parameter(i), value, "{}", parameter.name);
                let differs = (0..50).any(|k| law.at(0.1 * f64::from(k)) != before.at(0.1 * f64::from(k)));
                assert!(differs, "{}", parameter.name);
                assert_eq!(law.validate(), Ok(()));
            }
            // Setting gives the same as making anew.
            let json = serde_json::to_string(&law).unwrap();
            assert_eq!(serde_json::from_str::<MotionLaw>(&json).unwrap(), law, "{json}");
            let bytes = postcard::to_stdvec(&law).unwrap();
            assert_eq!(postcard::from_bytes::<MotionLaw>(&bytes).unwrap(), law);
        }
    }

    #[test]
    fn the_names_of_the_parameters() {
        let names = |law: &MotionLaw| law.parameters().into_iter().map(|p| p.name).collect::<Vec<_>>().join(" ");
        let [series, cycle, table, lines] = laws();
        assert_eq!(names(&series), "a[0] a[1] a[2] b[1] b[2]");
        assert_eq!(names(&cycle), "stroke lower rise_start rise upper_dwell return rise_law return_law");
        assert_eq!([names(&table), names(&lines)], ["scale"; 2]);
    }
}
