//! The report of a synthesis: text for a terminal, CSV, JSON.

use super::remarks::{degrees, rounded_down};
use super::shaft::ShaftGoal;
use super::shaft_study::Shafted;
use super::study::Study;
use super::{Norm, Objective, Task};
use crate::text::{Page, Table, csv, number};
use camdrive::drives::Fault;
use std::f64::consts::TAU;

/// Points of the profile in its CSV.
const POINTS: usize = 720;

/// The heading of [`Study::levels`].
pub(super) const LEVELS: &str = "Largest errors on the way";

impl Study {
    /// A length of the task: in its unit, and in m where that is another one.
    pub(super) fn length(&self, value: f64) -> String {
        if self.assignment.unit == 1.0 {
            return format!("{} m", number(value));
        }
        format!("{} ({} m)", number(value / self.assignment.unit), number(value))
    }

    /// The report; its tables for lines of `width` characters.
    pub fn text(&self, width: usize) -> String {
        let task = &self.assignment.task;
        let mut page = Page::new(&self.assignment.name, width);
        let mut line = |text: String| {
            page.lines([text]);
        };
        let objective = words(task);
        let alone = self.assignment.names.laws.is_empty();
        if alone {
            self.answer().into_iter().for_each(&mut line);
        }
        match self.elastic.as_ref().and_then(|behind| Some((behind, behind.objective?))) {
            Some((behind, value)) => {
                let [slowest, fastest] = behind.looked_at;
                line(format!(
                    "Objective {objective} of the output, at all speeds from η = {slowest:.4} to {fastest:.4}: {}; without \
                     elasticity the motion would have {}.",
                    self.length(value),
                    self.objective_value()
                ));
            }
            None if self.motion.series != self.cam => {
                line(format!("Objective {objective} of the motion without elasticity: {}.", self.objective_value()));
            }
            None if !alone => (),
            None => line(format!("Objective {objective}: {}.", self.objective_value())),
        }
        if self.assignment.unit != 1.0 {
            line(format!("Lengths are multiples of scale = {} m.", number(self.assignment.unit)));
        }
        for text in self.optima().into_iter().chain(self.limits()) {
            line(text);
        }
        line(format!(
            "Peaks of the cam: |U′| {}, |U″| {}, |U‴| {} per rad, rad², rad³.",
            self.length(self.peaks[1].value.abs()),
            self.length(self.peaks[2].value.abs()),
            self.length(self.peaks[3].value.abs())
        ));
        if let Some(cubics) = self.cubics {
            line(cubics.line(|error| self.length(error)));
        }
        page.table("Coefficients", &self.coefficients());
        if alone {
            page.table(LEVELS, &self.levels());
        }
        if !task.ranges.is_empty() {
            for (title, errors) in self.deviations() {
                page.table(&title, &self.deviation_table(errors));
            }
        }
        if self.rivals.len() > 1 || self.elastic.is_some() {
            page.table("Motion laws at this task", &self.laws());
        }
        if let Some(shaft) = &self.shaft {
            let fault = |(w, fault): &(f64, _)| format!("warning: at {} rpm: {fault}", number(w * 60.0 / TAU));
            page.table("Torque in the elastic shaft", &self.of_shaft(shaft)).lines(shaft.faults.iter().map(fault));
            page.lines([nonlinear(shaft)]);
        }
        page.lines(self.of_elasticity()).table("Resonances of the cam, kη = 1", &self.resonances()).text()
    }

    pub(super) fn objective_value(&self) -> String {
        let value = self.motion.objective;
        let unit = self.assignment.unit;
        let squared = |per: &str| match unit == 1.0 {
            true => format!("{} m²{per}", number(value)),
            false => format!("{} scale²{per}", number(value / unit.powi(2))),
        };
        match self.assignment.task.objective {
            Objective::MeanSquareAcceleration | Objective::PeakTorque => squared("/rad³"),
            Objective::ShaftTorque(goal) if !goal.relative => format!("{} N.m", number(value)),
            Objective::LeastSquares | Objective::DiscreteLeastSquares { .. } | Objective::ShaftTorque(_) => squared(""),
            Objective::Chebyshev | Objective::DiscreteChebyshev { .. } | Objective::ChebyshevSum
                if value <= self.motion.resolution =>
            {
                format!("below {}", self.length(self.motion.resolution))
            }
            _ => self.length(value),
        }
    }

    /// Optima from the starts of a search.
    fn optima(&self) -> Option<String> {
        let optima = &self.motion.optima;
        let best = optima.iter().copied().fold(f64::INFINITY, f64::min);
        // Local optima of equal height to four digits are one.
        let same = optima.iter().filter(|o| **o < best * (1.0 + 1e-4)).count();
        (!optima.is_empty()).then(|| {
            let worst = optima.iter().copied().fold(0.0, f64::max);
            format!(
                "This objective is not convex: the best local optimum of {} starts (seed {}); {same} of them led to it, \
                 the worst one to {} times its value. A better one may exist.",
                optima.len(),
                self.assignment.task.search.seed,
                number(worst / best)
            )
        })
    }

    /// The coefficients of the cam, and of the motion where that is another one.
    fn coefficients(&self) -> Table {
        let unit = self.assignment.unit;
        let full = |list: &[f64], k: usize| format!("{:.15}", list.get(k).copied().unwrap_or(0.0) / unit + 0.0);
        let differs = self.motion.series != self.cam;
        let head = if differs { "k  a  b  A of the motion  B of the motion" } else { "k  a  b" };
        let rows = (0..self.cam.a.len()).filter_map(|k| {
            let mut cells = vec![k.to_string(), full(&self.cam.a, k), full(&self.cam.b, k)];
            let mut sizes = vec![self.cam.a[k], self.cam.b[k]];
            if differs {
                let motion = &self.motion.series;
                cells.extend([full(&motion.a, k), full(&motion.b, k)]);
                sizes.extend([motion.a.get(k), motion.b.get(k)].into_iter().flatten());
            }
            sizes.iter().any(|c| *c != 0.0).then_some(cells)
        });
        Table::new(head, rows)
    }

    /// The longest dwells or the fewest harmonics, where these were asked for.
    pub(super) fn answer(&self) -> Option<String> {
        let (task, names) = (&self.assignment.task, &self.assignment.names);
        match self.asked {
            Objective::LongestDwell { dwells: [first, end], .. } => {
                let width =
                    |i: usize| format!("{}° (`{}`)", degrees(task.ranges[i].to - task.ranges[i].from), names.ranges[i]);
                Some(format!("Longest dwell: {}.", (first..end).map(width).collect::<Vec<_>>().join(", ")))
            }
            Objective::FewestHarmonics { .. } => {
                self.tried.last().map(|[harmonics, _]| format!("Fewest harmonics: {harmonics}."))
            }
            _ => None,
        }
    }

    /// Trials on the way to the longest dwell or to the fewest harmonics.
    pub(super) fn levels(&self) -> Table {
        let head = match self.asked {
            Objective::FewestHarmonics { .. } => "harmonics  least largest error",
            _ => "widths over those of the task  least largest error",
        };
        let mut tried = self.tried.clone();
        tried.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let error =
            |level: f64| if level.is_finite() { self.length(level) } else { "none keeps the bounds".to_owned() };
        let mut rows: Vec<_> = tried.into_iter().map(|[x, level]| vec![number(x), error(level)]).collect();
        // The last steps look alike.
        rows.dedup();
        Table::new(head, rows)
    }

    /// Whose deviations are told: of what is delivered, and of the motion where that is another one.
    fn deviations(&self) -> Vec<(String, &[[f64; 3]])> {
        let Some(behind) = &self.elastic else {
            return vec![("Largest deviations of the motion".to_owned(), &self.motion.errors)];
        };
        let [slowest, fastest] = behind.looked_at;
        let over = format!("Largest deviations of the output y from η = {slowest:.4} to {fastest:.4}");
        let mut list = vec![(over, &behind.over_speeds[..])];
        list.push(("Largest deviations of the cam, which is the output at rest (η = 0)".to_owned(), &behind.at_rest));
        if self.motion.series != self.cam {
            list.push(("Largest deviations of the motion without elasticity".to_owned(), &self.motion.errors));
        }
        list
    }

    fn deviation_table(&self, errors: &[[f64; 3]]) -> Table {
        let cell = |value: f64| if value.is_nan() { "–".to_owned() } else { self.length(value) };
        let rows = self.assignment.task.ranges.iter().zip(errors).enumerate();
        let rows = rows.map(|(i, (range, errors))| {
            let name = self.assignment.names.ranges.get(i).cloned().unwrap_or_else(|| (i + 1).to_string());
            let mut cells = vec![name, degrees(range.from), degrees(range.to)];
            cells.extend(errors.iter().map(|e| cell(*e)));
            cells
        });
        Table::new("range  from [deg]  to [deg]  |U − Ũ|  |U′ − Ũ′|  |U″ − Ũ″|", rows)
    }

    /// The laws with their figures.
    fn laws(&self) -> Table {
        let unit = self.assignment.unit;
        let reach = if self.elastic.is_some() { "  reaches η" } else { "" };
        let head = format!("law  max |U′|  max |U″|  max |U′U″|  harmonics  dwell error at rest{reach}");
        let rows = self.rivals.iter().enumerate().map(|(i, rival)| {
            let error =
                if i == 0 { number(self.assignment.task.largest_error(&rival.series) / unit) } else { "0".to_owned() };
            let mut cells = vec![
                rival.name.clone(),
                number(rival.peaks[0] / unit),
                number(rival.peaks[1] / unit),
                number(rival.torque / unit.powi(2)),
                rival.harmonics.to_string(),
                error,
            ];
            if let Some(behind) = &self.elastic {
                cells.push(behind.reaches[i].map_or("–".to_owned(), |eta| format!("{:.4}", rounded_down(eta))));
            }
            cells
        });
        Table::new(&head, rows)
    }

    /// The laws in front of an elastic shaft.
    fn of_shaft(&self, shaft: &Shafted) -> Table {
        let rpm = |w: f64| number(w * 60.0 / TAU);
        let goal = &shaft.goal;
        let head = format!(
            "law  max |M| at {} rpm [N.m]  over m Ω²  magnification there  largest over m Ω²  \
             1.5 times kinetostatic at [rpm]  2 times at [rpm]",
            rpm(goal.fastest)
        );
        let relative = |p: &[f64; 3]| p[1] / (goal.shaft.m * p[0] * p[0] * self.assignment.unit.powi(2));
        let rows = self.rivals.iter().zip(&shaft.laws).map(|(rival, law)| {
            let last = law.points.last().copied().unwrap_or([f64::NAN; 3]);
            let first = |limit: usize| match law.exceeded[limit] {
                None => format!("> {}", rpm(goal.fastest)),
                Some(w) if w <= goal.slowest => format!("≤ {}", rpm(w)),
                Some(w) => rpm(w),
            };
            vec![
                rival.name.clone(),
                number(last[1]),
                number(relative(&last)),
                number(last[2]),
                number(law.points.iter().map(relative).fold(0.0, f64::max)),
                first(0),
                first(1),
            ]
        });
        Table::new(&head, rows)
    }

    fn resonances(&self) -> Table {
        let given = self.assignment.elasticity.as_ref();
        let admissible = given.and_then(|g| g.amplitude);
        let limit = if admissible.is_some() { "  admissible" } else { "" };
        let list = self.elastic.iter().flat_map(|e| &e.resonances);
        let rows = list.map(|r| {
            let speed = given.map_or(0.0, |g| r.eta * g.w0 * 60.0 / TAU);
            let size = if r.amplitude.is_finite() { self.length(r.amplitude) } else { "unbounded".to_owned() };
            let mut cells = vec![r.harmonic.to_string(), format!("{:.4}", r.eta), number(speed), size];
            cells.extend(admissible.map(|a| if r.amplitude <= a { "yes" } else { "no" }.to_owned()));
            cells
        });
        Table::new(&format!("k  η  speed [rpm]  amplitude of q{limit}"), rows)
    }

    /// All tables as CSV, with the endings of their file names.
    ///
    /// # Errors
    /// None in practice: the writer fills memory.
    pub fn csv(&self) -> Result<Vec<(String, String)>, Fault> {
        let mut files =
            vec![("profile.csv".to_owned(), self.profile_csv()?), ("laws.csv".to_owned(), self.laws_csv()?)];
        if let Some(behind) = &self.elastic {
            let curves = self.rivals.iter().zip(&behind.curves);
            let rows = curves.flat_map(|(rival, curve)| curve.iter().map(|point| (&rival.name, point)));
            files.push(("speed.csv".to_owned(), csv("law,eta,deviation_m", rows)?));
        }
        if let Some(shaft) = &self.shaft {
            let laws = self.rivals.iter().zip(&shaft.laws);
            let linear = laws.flat_map(|(rival, law)| law.points.iter().map(|point| (rival.name.as_str(), *point)));
            let rigid = shaft.goal.shaft.m * self.rivals[0].torque;
            let nonlinear = shaft.nonlinear.iter().filter_map(|at| {
                let torque = *at.torque.as_ref().ok()?;
                Some(("harmonic synthesis, nonlinear drive", [at.w, torque, torque / (rigid * at.w * at.w)]))
            });
            let rows = linear.chain(nonlinear);
            let head = "law,speed_rad_per_s,peak_torque_Nm,over_kinetostatic";
            files.push(("shaft.csv".to_owned(), csv(head, rows)?));
        }
        if !self.widths.is_empty() {
            let rows = self.widths.iter().flat_map(|curve| {
                curve
                    .points
                    .iter()
                    .map(|[width, chebyshev, squares]| (curve.order, width.to_degrees(), chebyshev, squares))
            });
            files.push(("dwell_width.csv".to_owned(), csv("harmonics,dwell_width_deg,chebyshev,least_squares", rows)?));
        }
        Ok(files)
    }

    fn profile_csv(&self) -> Result<String, Fault> {
        let envelope = if self.elastic.is_some() { ",least_output_deviation_m,largest_output_deviation_m" } else { "" };
        let head = format!("phi_deg,U_m,dU_m_per_rad,ddU_m_per_rad2,dddU_m_per_rad3,deviation_m{envelope}");
        let rows = (0..POINTS).map(|i| {
            let phi = TAU * i as f64 / POINTS as f64;
            let u = self.cam.at(phi).0;
            let prescribed = self.prescribed_at(phi);
            let ends = self.elastic.as_ref().map_or(Vec::new(), |behind| {
                let ends = behind.envelope(phi);
                ends.into_iter().map(|y| Some(y - prescribed?)).collect()
            });
            (phi.to_degrees(), [u[0], u[1], u[2], u[3]], prescribed.map(|target| u[0] - target), ends)
        });
        csv(&head, rows)
    }

    /// Ũ where U is prescribed.
    fn prescribed_at(&self, phi: f64) -> Option<f64> {
        self.assignment.task.ranges.iter().find_map(|range| {
            let target = range.prescribed[0].as_ref()?;
            let phi = range.from + (phi - range.from).rem_euclid(TAU);
            (phi <= range.to).then(|| target.at(phi - range.from))
        })
    }

    fn laws_csv(&self) -> Result<String, Fault> {
        let rows = self.rivals.iter().enumerate().map(|(i, rival)| {
            let reached = self.elastic.as_ref().and_then(|e| e.reaches[i]);
            (&rival.name, rival.peaks, rival.torque, rival.harmonics, reached)
        });
        csv("law,peak_dU_m,peak_ddU_m,peak_torque_m2,harmonics,reached_eta", rows)
    }

    /// The result as JSON, in SI.
    pub(super) fn value(&self) -> serde_json::Value {
        let finite = |value: f64| value.is_finite().then_some(value);
        let list = |errors: &[[f64; 3]]| -> Vec<Vec<Option<f64>>> {
            errors.iter().map(|e| e.iter().map(|e| finite(*e)).collect()).collect()
        };
        let behind = self.elastic.as_ref().map(|behind| {
            serde_json::json!({
                "eta_opt": behind.optimum,
                "eta_reached": behind.reached,
                "largest_deviation": behind.worst.and_then(finite),
                "objective": behind.objective,
                "speeds_looked_at": behind.looked_at,
                "output_deviations": list(&behind.over_speeds),
                "deviations_at_rest": list(&behind.at_rest),
                "resonances": behind.resonances.iter().map(|r| serde_json::json!({
                    "harmonic": r.harmonic, "eta": r.eta, "amplitude": finite(r.amplitude),
                })).collect::<Vec<_>>(),
            })
        });
        serde_json::json!({
            "name": self.assignment.name,
            "objective": {
                "kind": words(&self.assignment.task),
                "value": self.motion.objective,
                "resolution": self.motion.resolution,
            },
            "uncertainty_of_coefficients": self.motion.uncertainty,
            "undetermined_coefficients": self.motion.undetermined,
            "cam": { "a": self.cam.a, "b": &self.cam.b[1..] },
            "motion": { "A": self.motion.series.a, "B": &self.motion.series.b[1..] },
            "excess_of_conditions": self.motion.excess,
            "deviations_of_the_motion": list(&self.motion.errors),
            "peaks": self.peaks.iter().map(|p| p.value.abs()).collect::<Vec<_>>(),
            "local_optima": self.motion.optima,
            "tried": self.tried.iter().map(|[number, level]| [finite(*number), finite(*level)]).collect::<Vec<_>>(),
            "error_of_the_cubics": self.cubics.map(|cubics| cubics.error),
            "elastic_output": behind,
            "shaft": self.shaft.as_ref().map(|shaft| serde_json::json!({
                "speed_of_magnification_1.5": shaft.laws[0].exceeded[0],
                "speed_of_magnification_2": shaft.laws[0].exceeded[1],
                "unstable_at": shaft.faults.iter().map(|(w, _)| w).collect::<Vec<_>>(),
                "nonlinear": shaft.nonlinear.iter().map(|at| serde_json::json!({
                    "speed": at.w, "linear_torque": finite(at.linear), "nonlinear_torque": at.torque.as_ref().ok(),
                })).collect::<Vec<_>>(),
            })),
        })
    }
}

/// The objective as the source calls it.
pub(super) fn words(task: &Task) -> &'static str {
    let at_points = task.ranges.iter().all(|range| range.from == range.to);
    match task.objective {
        Objective::LeastSquares if at_points => "S2 (sum of the squared errors at points)",
        Objective::Chebyshev if at_points => "S4 (largest error at points)",
        Objective::LeastSquares => "S1 (integral of the squared errors)",
        Objective::DiscreteLeastSquares { .. } => "S2 (sum of the squared errors at points)",
        Objective::Chebyshev => "S3 (largest error)",
        Objective::DiscreteChebyshev { .. } => "S4 (largest error at points)",
        Objective::ChebyshevSum => "S5 (largest sum of the errors)",
        Objective::PeakAcceleration => "peak of |U″|",
        Objective::MeanSquareAcceleration => "∫U″² dφ over the turn",
        Objective::LongestDwell { .. } => "longest dwell",
        Objective::FewestHarmonics { .. } => "fewest harmonics",
        Objective::PeakTorque => "peak of |U′U″|",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Peak, relative: true, .. }) => "largest shaft torque over m Ω²",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Rms, relative: true, .. }) => "mean shaft torque over m Ω²",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Peak, .. }) => "largest shaft torque",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Rms, .. }) => "root mean square of the shaft torque",
    }
}

/// How far the torque of the nonlinear drive is from that of the linear one.
fn nonlinear(shaft: &Shafted) -> String {
    let rpm = |w: f64| number(w * 60.0 / TAU);
    let mut lines = Vec::new();
    let differences = shaft.nonlinear.iter().filter_map(|at| Some((at, at.difference()?)));
    if let Some((at, difference)) = differences.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) {
        lines.push(format!(
            "The largest torque of the nonlinear drive differs by at most {:+.2} %: at {} rpm it is {} N.m instead of {} N.m.",
            100.0 * difference,
            rpm(at.w),
            number((1.0 + difference) * at.linear),
            number(at.linear)
        ));
    }
    let faults = shaft.nonlinear.iter().filter_map(|at| Some((at.w, at.torque.as_ref().err()?)));
    lines.extend(faults.map(|(w, fault)| format!("warning: at {} rpm, nonlinear: {fault}", rpm(w))));
    lines.join("\n")
}
