//! The report as CSV, with all digits, SI and rad.

use super::borders::borders;
use super::passage::Figures;
use super::{Report, figures};
use crate::text::{csv, full, full_or_empty};
use camdrive::drives::Fault;

/// All passages of all laws, one line each for formula and model, SI and rad.
pub fn passages_csv(report: &Report) -> Result<String, Fault> {
    let head = "law,passage,from,by,U3_m,K,mu,release_rad,tau1,time_s,angle_rad,impulse_N_s,loss_J,vibration_m,max_q_m,\
                max_force_N,then,release_after_tau,quasi_static_error,truncation_error,spacing_rad,vibration_left,fault";
    let rows = report.laws.iter().flat_map(|study| {
        study.passages.iter().enumerate().flat_map(move |(i, passage)| {
            [("formula", passage.formula), ("model", passage.model)].into_iter().map(move |(by, figures)| {
                let f = |value: fn(&Figures) -> Option<f64>| full_or_empty(figures.as_ref().and_then(value));
                vec![
                    study.law.clone(),
                    (i + 1).to_string(),
                    passage.from.to_string(),
                    by.to_owned(),
                    full_or_empty(passage.crossing.map(|c| c.jerk)),
                    full_or_empty(passage.k),
                    full(report.machine.mu),
                    f(|f| Some(f.release)),
                    f(|f| Some(f.tau)),
                    f(|f| Some(f.time)),
                    f(|f| Some(f.angle)),
                    f(|f| Some(f.impulse)),
                    f(|f| Some(f.loss)),
                    f(|f| Some(f.vibration)),
                    f(|f| f.elongation),
                    f(|f| f.force),
                    figures.map_or(String::new(), |f| f.sequel.name().to_owned()),
                    f(|f| f.release_after),
                    full_or_empty(passage.quasi_static),
                    full_or_empty(passage.truncation),
                    full(passage.spacing),
                    full(passage.left),
                    passage.fault.clone().unwrap_or_default(),
                ]
            })
        })
    });
    csv(head, rows)
}

/// Deformation and force over the natural period after each impact.
pub fn after_impact_csv(report: &Report) -> Result<String, Fault> {
    let head = "law,passage,tau,q_over_s_formula,q_over_s_model,force_over_cs_formula,force_over_cs_model";
    let rows = report.laws.iter().flat_map(|study| {
        study.passages.iter().enumerate().flat_map(move |(i, passage)| {
            passage.course.iter().map(move |point| {
                let values = [point.q[0], point.q[1], point.force[0], point.force[1]].map(full_or_empty);
                [vec![study.law.clone(), (i + 1).to_string(), full(point.tau)], values.to_vec()].concat()
            })
        })
    });
    csv(head, rows)
}

/// τ₁ over K for the mass ratios of the diagram.
pub fn passage_time_csv(report: &Report) -> Result<String, Fault> {
    let curves = figures::passage_times(report).into_iter();
    let row = |mu: String, [k, tau]: [f64; 2]| vec![mu, full(k), full(tau)];
    csv("mu,K,tau1", curves.flat_map(|(mu, points)| points.into_iter().map(move |point| row(mu.clone(), point))))
}

/// The borders of the map of multiple impacts.
pub fn map_csv(report: &Report) -> Result<String, Fault> {
    let (mu, k) = figures::extent(report);
    let rows = borders(mu, k[1]).into_iter().flat_map(|border| {
        let name = border.band.map_or("elastic".to_owned(), |n| format!("immediate {n}"));
        border.points.into_iter().map(move |p| vec![name.clone(), full(p.mu), full(p.k), full(p.tau)])
    });
    csv("border,mu,K,tau1", rows)
}
