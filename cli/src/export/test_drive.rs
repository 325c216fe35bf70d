//! A drive for tests of the export: a first-order lag T ẋ = u − x, with one variable of every kind.

use camdrive::drives::parameter::parameters;
use camdrive::drives::rigid_machine;
use camdrive::drives::settings::Settings;
use camdrive::drives::variable::{Enumeration, Kind, real};
use camdrive::drives::{AnyDrive, Curve, Drive, EventLog, Experiment, Fault, List, Seed, Text, unit};
use camdrive::numerics::taylor::Series;
use camdrive_design::resource::{Described, Resource};
use serde::{Deserialize, Serialize};

pub static COLOUR: Enumeration =
    Enumeration { name: "Colour", items: &[("red", "Like a rose"), ("blue", "Like the sky & the sea")] };

parameters! {
    /// Of the lag.
    Parameters of Lag.parameters, "lag" {
        /// Time constant
        t = "T", "T", TIME in [1e-9, 1e9] about 0.5, Tunable;
    }
}

#[derive(Clone, Serialize, Deserialize)]
pub struct Lag {
    parameters: Parameters,
    u: f64,
    x: f64,
    on: f64,
    colour: f64,
    events: EventLog,
}

impl From<Lag> for AnyDrive {
    fn from(lag: Lag) -> Self {
        AnyDrive::new(lag)
    }
}

/// The lag for the exporter.
pub fn lag() -> Described {
    Described::of(Lag::new(Parameters { t: 2.0 }).unwrap())
}

/// A name and a scene; the scene is a flywheel, since files know no lag.
pub fn resource(name: &str) -> Resource {
    let flywheel = rigid_machine::Scene {
        loads: vec![Default::default()],
        inertia: rigid_machine::InertiaFunction { constant: 1.0, varying: None },
        followers: Vec::new(),
        motor: rigid_machine::Motor::None,
        phi_start: 0.0,
        w_start: 0.0,
        start: rigid_machine::MachineStart::Given,
        solver: Settings::default(),
    };
    Resource::new(name, flywheel)
}

impl Drive for Lag {
    type Scene = Parameters;
    const MODEL: &'static str = "Lag";

    fn new(parameters: Parameters) -> Result<Self, Fault> {
        Ok(Lag { parameters, u: 0.0, x: 0.0, on: 1.0, colour: 2.0, events: EventLog::default() })
    }

    fn variables(&self) -> List<Self> {
        let mut list = List::<Self>::default();
        list.input("u", "Demand <u>", real(&unit::ANGLE), |d, _| d.u, |d, _, _, value| d.u = value);
        list.group::<Parameters>();
        list.parameter("on", "Switch", Kind::Boolean, |d, _| d.on, |d, _, value| d.on = value);
        list.parameter("colour", "Paint", Kind::Enumeration(&COLOUR), |d, _| d.colour, |d, _, value| d.colour = value);
        list.output("x", "Position", real(&unit::ANGLE), |d, seed, _| match seed {
            Seed::Time => Series::from_derivatives(d.x, d.rate(), -d.rate() / d.parameters.t),
            known => Series([d.x, known.of("x"), 0.0]),
        })
        .state()
        .depends(&["x"]);
        list.output("der(x)", "Velocity", real(&unit::ANGULAR_VELOCITY), |d, seed, _| match seed {
            Seed::Time => Series::from_derivatives(
                d.rate(),
                -d.rate() / d.parameters.t,
                d.rate() / (d.parameters.t * d.parameters.t),
            ),
            known => Series([d.rate(), (known.of("u") - known.of("x")) / d.parameters.t, 0.0]),
        })
        .at(1)
        .depends(&["x", "u"])
        .depends_initially(&[&["u", "T"]]);
        list.discrete_output("count", "Steps", Kind::Integer { min: 0, max: i32::MAX }).at(2);
        list.local("solver.steps", "Steps", real(&unit::NUMBER)).at(3);
        list
    }

    fn text(&self) -> Text {
        Text::new(include_str!("test_drive.toml"), &[("on", self.on != 0.0)])
    }

    fn curves(&self) -> Vec<Curve> {
        Curve::of_law(&camdrive::motion::MotionLaw::Fourier(camdrive::motion::Fourier::new(
            vec![0.0, 0.02, 0.004],
            vec![],
        )))
    }

    fn experiment(&self) -> Experiment {
        Experiment { stop: 1.0, step: 1e-3, tolerance: 1e-6 }
    }

    fn start(&mut self, _: f64) -> Result<(), Fault> {
        self.x = 0.0;
        Ok(())
    }

    fn apply(&mut self, _: f64) -> Result<(), Fault> {
        Ok(())
    }

    fn advance(&mut self, _: f64, step: f64) -> Result<(), Fault> {
        self.x = self.u + (self.x - self.u) * (-step / self.parameters.t).exp();
        Ok(())
    }

    fn evaluate(&self, values: &mut [f64]) {
        values.copy_from_slice(&[self.x, self.rate(), 0.0, 0.0]);
    }

    fn request_tolerance(&mut self, _: f64) {}

    fn is_finite(&self) -> bool {
        self.x.is_finite()
    }

    fn events(&mut self) -> &mut EventLog {
        &mut self.events
    }
}

impl Lag {
    fn rate(&self) -> f64 {
        (self.u - self.x) / self.parameters.t
    }
}

/// The section "A new drive" of ARCHITECTURE.md shows this drive line by line.
#[test]
fn the_page_on_new_drives_shows_this_one() {
    let page = include_str!("../../../ARCHITECTURE.md");
    let (_, section) = page.split_once("## A new drive").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let code: Vec<&str> = include_str!("test_drive.rs").lines().collect();
    let mut blocks = 0;
    for block in section.split("```rust\n").skip(1) {
        let lines: Vec<&str> = block.split("```").next().unwrap().lines().collect();
        assert!(code.windows(lines.len()).any(|window| window == lines), "no longer so:\n{}", lines.join("\n"));
        blocks += 1;
    }
    assert!(blocks >= 4);
}

/// x = u (1 − exp(−t/T)), whatever the communication step.
#[test]
fn the_lag_follows_its_demand() {
    for steps in [1, 7, 100] {
        let mut drive = lag();
        drive.set_up(0.0, None);
        drive.set(0, 0.5).unwrap();
        drive.start().unwrap();
        for i in 0..steps {
            let step = 3.0 / f64::from(steps);
            drive.advance(f64::from(i) * step, step).unwrap();
        }
        let exact = 0.5 * (1.0 - (-1.5f64).exp());
        assert!((drive.get(4).unwrap() - exact).abs() < 1e-15);
        assert!((drive.get(5).unwrap() - (0.5 - exact) / 2.0).abs() < 1e-15);
    }
}
