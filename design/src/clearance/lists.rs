//! The report as CSV, with all digits, SI and rad.

use super::borders::borders;
use super::table::FIGURES;
use super::{Report, figures};
use crate::text::csv;
use camdrive::drives::Fault;

/// All passages of all laws, one line each for formula and model.
pub fn passages_csv(report: &Report) -> Result<String, Fault> {
    let head = "law,passage,from,by,U3_m,K,mu,release_rad,tau1,time_s,angle_rad,impulse_N_s,loss_J,vibration_m,max_q_m,\
                max_force_N,then,release_after_tau,quasi_static_error,truncation_error,spacing_rad,vibration_left,fault";
    let rows = report.laws.iter().flat_map(|study| {
        study.passages.iter().zip(1..).flat_map(move |(passage, i)| {
            [("formula", passage.formula), ("model", passage.model)].into_iter().map(move |(by, figures)| {
                let passed = (&study.law, i, passage.from, by, passage.crossing.map(|c| c.jerk), passage.k);
                let found = (figures.map(|f| f.release), FIGURES.map(|(_, of)| of(figures.as_ref()?)));
                let then = (figures.map(|f| f.sequel.name()), figures.and_then(|f| f.release_after));
                let errors = (passage.quasi_static, passage.truncation);
                (passed, report.machine.mu, found, then, errors, passage.spacing, passage.left, &passage.fault)
            })
        })
    });
    csv(head, rows)
}

/// Deformation and force over the natural period after each impact.
pub fn after_impact_csv(report: &Report) -> Result<String, Fault> {
    let head = "law,passage,tau,q_over_s_formula,q_over_s_model,force_over_cs_formula,force_over_cs_model";
    let rows = report.laws.iter().flat_map(|study| {
        study.passages.iter().zip(1..).flat_map(move |(passage, i)| {
            passage.course.iter().map(move |point| (&study.law, i, point.tau, point.q, point.force))
        })
    });
    csv(head, rows)
}

/// τ₁ over K for the mass ratios of the diagram.
pub fn passage_time_csv(report: &Report) -> Result<String, Fault> {
    let curves = figures::passage_times(report).into_iter();
    csv("mu,K,tau1", curves.flat_map(|(mu, points)| points.into_iter().map(move |point| (mu.clone(), point))))
}

/// The borders of the map of multiple impacts.
pub fn map_csv(report: &Report) -> Result<String, Fault> {
    let (mu, k) = figures::extent(report);
    let rows = borders(mu, k[1]).into_iter().flat_map(|border| {
        let name = border.band.map_or("elastic".to_owned(), |n| format!("immediate {n}"));
        border.points.into_iter().map(move |p| (name.clone(), p.mu, p.k, p.tau))
    });
    csv("border,mu,K,tau1", rows)
}
