//! The keys of scenes and tasks, each declared once with unit, range, default, meaning and other names. The readers use them, the
//! [reference](super::reference) makes its tables from them, and the [JSON Schema](super::schema) lets editors complete them.

use super::limits::{ANY, LIFT, Limits, NOT_NEGATIVE, POSITIVE, within};
use super::units;
use camdrive::drives::limits::{FASTEST, LARGEST_ANGLE};
use camdrive::drives::parameter::Parameters;
use camdrive::drives::parametric::law::CrankLaw;
use camdrive::drives::rigid_machine::linkage::ParameterKind;
use camdrive::drives::rigid_machine::{Kloss, LAG, RigidMachine};
use camdrive::drives::settings::{COARSEST_TOLERANCE, LONGEST_STEP_SIZE};
use camdrive::drives::shaft::cam_drive::LARGEST_START;
use camdrive::drives::unit::{self, Quantity};
use camdrive::drives::{backlash, elastic_output, elastic_shaft};
use camdrive::motion::fourier::HIGHEST_HARMONIC;
use camdrive::motion::plan::{INFLECTION, LEAST_MOTION};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A table of a scene or a task.
pub struct KeyTable {
    /// The title in the reference.
    pub title: &'static str,
    /// The keys, in the order of the reference.
    pub keys: &'static [Key],
    /// A further table whose keys belong to this one.
    pub with: Option<&'static KeyTable>,
}

/// A key of a table.
#[derive(Clone, Copy)]
pub struct Key {
    /// The key.
    pub key: &'static str,
    /// Its meaning, in Markdown.
    pub meaning: &'static str,
    /// The kinds of values that it takes.
    pub values: [Value; 3],
    /// The default.
    pub usual: Usual,
    /// Names that people write by mistake.
    pub also: &'static [&'static str],
    /// Removed names of a choice, each with its replacement.
    pub gone: &'static [(&'static str, &'static str)],
    /// The models with this key; empty for all.
    pub models: &'static [&'static str],
}

/// A kind of value.
#[derive(Clone, Copy)]
pub enum Value {
    /// No further kind.
    Nothing,
    /// A number, or a string with a unit.
    Real(Dimension, Limits),
    /// A word in the place of a quantity.
    Word(&'static str),
    /// A list of numbers.
    Reals(Dimension),
    /// A list of pairs of numbers.
    Pairs,
    /// A whole number.
    Count(u32, u32),
    /// Any text.
    Text,
    /// A list of texts.
    Texts,
    /// A list of values of the named variables.
    Values,
    /// true or false.
    Flag,
    /// One of several names; the first name of each list is the usual one.
    Choice(&'static [&'static [&'static str]]),
    /// A table.
    Table(&'static KeyTable),
    /// A list of tables.
    Tables(&'static KeyTable),
    /// Tables with names from the user.
    Named(&'static KeyTable),
    /// Variables with their values.
    Variables,
}

/// The quantity of a number.
#[derive(Clone, Copy)]
pub enum Dimension {
    /// The same everywhere.
    Fixed(&'static Quantity),
    /// The first for motion along a line, the second for rotation.
    Motion(&'static Quantity, &'static Quantity),
    /// The quantity of the section, U of a law, per radⁿ.
    Own(i32),
    /// It depends on another key; the meaning explains it.
    Other,
}

/// The default of a key.
#[derive(Clone, Copy)]
pub enum Usual {
    /// No value.
    Nothing,
    /// The key is required.
    Required,
    /// This number.
    Number(f64),
    /// This name.
    Name(&'static str),
    /// This text describes it.
    Text(&'static str),
}

impl KeyTable {
    /// All keys, followed by the keys of the further table.
    pub fn all(&'static self) -> impl Iterator<Item = &'static Key> {
        std::iter::successors(Some(self), |table| table.with).flat_map(|table| table.keys)
    }

    /// The declaration of a key. The reader asks for declared keys only.
    pub fn key(&'static self, key: &str) -> &'static Key {
        self.all().find(|known| known.key == key).unwrap_or_else(|| panic!("{} has no key {key}", self.title))
    }
}

const fn value(value: Value) -> Key {
    let values = [value, Value::Nothing, Value::Nothing];
    Key { key: "", meaning: "", values, usual: Usual::Nothing, also: &[], gone: &[], models: &[] }
}

const fn real(quantity: &'static Quantity, limits: Limits) -> Key {
    value(Value::Real(Dimension::Fixed(quantity), limits))
}

/// A quantity along a line or about an axis.
const fn moved(line: &'static Quantity, turn: &'static Quantity, limits: Limits) -> Key {
    value(Value::Real(Dimension::Motion(line, turn), limits))
}

/// One of these names.
const fn choice(names: &'static [&'static [&'static str]]) -> Key {
    value(Value::Choice(names))
}

/// The section's own quantity per radⁿ.
const fn own(n: i32, limits: Limits) -> Key {
    value(Value::Real(Dimension::Own(n), limits))
}

/// The parameter of a drive at the index `which` of its group.
const fn parameter<P: Parameters>(which: usize) -> Key {
    let parameter = &P::TABLE[which];
    let key = real(parameter.quantity, within(parameter.range[0], parameter.range[1]));
    match parameter.default {
        Some(number) => key.or(number),
        None => key.required(),
    }
}

/// A dimension of a mechanism.
const fn dimension(kind: ParameterKind) -> Key {
    let [least, greatest] = kind.range();
    real(kind.quantity(), within(least, greatest))
}

impl Key {
    const fn required(self) -> Self {
        Key { usual: Usual::Required, ..self }
    }

    const fn or(self, number: f64) -> Self {
        Key { usual: Usual::Number(number), ..self }
    }

    const fn usually(self, name: &'static str) -> Self {
        Key { usual: Usual::Name(name), ..self }
    }

    const fn or_text(self, text: &'static str) -> Self {
        Key { usual: Usual::Text(text), ..self }
    }

    const fn also(self, also: &'static [&'static str]) -> Self {
        Key { also, ..self }
    }

    const fn gone(self, gone: &'static [(&'static str, &'static str)]) -> Self {
        Key { gone, ..self }
    }

    const fn of(self, models: &'static [&'static str]) -> Self {
        Key { models, ..self }
    }

    /// Another kind of value that it takes.
    const fn and(mut self, value: Value) -> Self {
        let next = if matches!(self.values[1], Value::Nothing) { 1 } else { 2 };
        self.values[next] = value;
        self
    }
}

/// A quantity that another key determines.
const fn other(limits: Limits) -> Key {
    value(Value::Real(Dimension::Other, limits))
}

/// The module of a page explains no keys: the page has their meanings.
const IN_BROWSER: bool = cfg!(target_arch = "wasm32");

macro_rules! tables {
    ($($(#[$doc:meta])* $table:ident $title:literal $(with $with:ident)? {
        $($(#[doc = $text:literal])+ $key:literal: $value:expr;)*
    })*) => {
        $($(#[$doc])* pub static $table: KeyTable = KeyTable {
            title: $title,
            keys: &[$(Key { key: $key, meaning: if IN_BROWSER { "" } else { concat!($($text),+) }, ..$value }),*],
            with: tables!(@with $($with)?),
        };)*
    };
    (@with) => { None };
    (@with $with:ident) => { Some(&$with) };
}

const ELASTIC: &str = "ElasticCamDrive";
const BACKLASH: &str = "BacklashDrive";
const MACHINE: &str = "RigidMachine";
/// The model with a machine or a drive.
pub const TRAIN: &str = "DriveTrain";
const PARAMETRIC: &str = "ParametricDrive";

/// Young's modulus (Pa) and Poisson's ratio of steel.
const STEEL: [f64; 2] = [210e9, 0.3];
/// α of teeth (rad), DIN 867.
const TOOTH_ANGLE: f64 = PI / 9.0;
/// The most harmonics of a profile. The source advises against more than nine; cams of sixty-four can be made.
const MOST_HARMONICS: u32 = 64;
/// The highest harmonic of the stiffness in a scene; beyond it the whole function is cheaper.
const HIGHEST_OF_CRANK: u32 = 256;
/// The most samples of a study and the most values of a series.
const MOST_RUNS: u32 = camdrive_design::study::plan::MOST_ROWS as u32;
/// The value of `ddU` if the laws on both sides of a turning point determine it.
pub const FREE: &str = "free";

/// Angles of a cycle.
const REST_OF_TURN: &str = "the rest of the turn; only one of the four may be left out";
/// Lengths that fix the size of a cam.
const SIZE: &str = "one of these";
/// What replaces the former objectives for points of a range: the sum of squared errors and the largest error.
const SQUARES: &str = "write `least_squares` without `points`: it looks at all angles";
const LARGEST: &str = "write `chebyshev` without `points`: it looks at all angles";
const THIS_OR_FREQUENCY: &str = "this or `natural_frequency`";

tables! {
    /// A scene.
    SCENE "every scene" {
        /// name of the FMU, its modelIdentifier: a C identifier of at most 24 characters, no device name of Windows
        /// (`CON`, `COM1` …)
        "name": value(Value::Text).required().also(&["title"]);
        /// one sentence for the importer
        "description": value(Value::Text).or_text("a sentence about the model");
        /// the drive
        "model": choice(&[&["ElasticCamDrive"], &["BacklashDrive"], &["RigidMachine"], &["ParametricDrive"], &["DriveTrain"]]).required().also(&["type"]);
        /// the motion law U(φ)
        "cam": value(Value::Table(&LAW)).required().of(&[ELASTIC, BACKLASH]);
        /// the cam as a body, for `camdrive cam`
        "geometry": value(Value::Table(&GEOMETRY)).of(&[ELASTIC, BACKLASH]);
        /// loads on the follower; for a ParametricDrive, on the mass
        "load": value(Value::Table(&LOAD)).and(Value::Table(&PARAMETRIC_LOAD)).of(&[ELASTIC, BACKLASH, PARAMETRIC]);
        /// dimensions of the parts that carry the loads, for `camdrive forces`
        "forces": value(Value::Table(&FORCES)).of(&[ELASTIC, BACKLASH]);
        /// the motion of the cam shaft
        "drive": value(Value::Table(&DRIVE)).required().of(&[ELASTIC, BACKLASH, PARAMETRIC, TRAIN]);
        /// the elastic member
        "elasticity": value(Value::Table(&ELASTICITY)).required().of(&[ELASTIC]);
        /// the clearance
        "backlash": value(Value::Table(&CLEARANCE)).required().of(&[BACKLASH]);
        /// a parallel-crank drive
        "crank": value(Value::Table(&PARALLEL_CRANK)).or_text("this or `coefficients`").of(&[PARAMETRIC]);
        /// the coefficients of the equation
        "coefficients": value(Value::Table(&COEFFICIENTS)).or_text("this or `crank`").of(&[PARAMETRIC]);
        /// the shaft with its inertia
        "machine": value(Value::Table(&MACHINE_TABLE)).required().of(&[MACHINE, TRAIN]);
        /// the motor on the shaft
        "motor": value(Value::Table(&MOTOR)).of(&[MACHINE, TRAIN]);
        /// the tools on the shaft
        "follower": value(Value::Tables(&FOLLOWER)).of(&[MACHINE, TRAIN]).also(&["followers"]);
        /// names of the units that load the shaft; each has the input "NAME.tau" instead of the only input "tau"
        "torques": value(Value::Texts).of(&[MACHINE, TRAIN]);
        /// inertia that other units and the shaft exchange
        "coupling": value(Value::Table(&EXCHANGE));
        /// where the motion starts
        "start": value(Value::Table(&START));
        /// how the FMU integrates
        "solver": value(Value::Table(&SOLVER));
    }

    /// `[solver]`.
    SOLVER "`[solver]`" {
        /// relative tolerance, 0 for the documented default of the model; not for a drive in closed form or a BacklashDrive at
        /// constant speed, where it would have no effect
        "tolerance": real(&unit::NUMBER, within(0.0, COARSEST_TOLERANCE)).or(0.0).also(&["tol"]);
        /// how internal steps are chosen: `adaptive` (by the tolerance) or `fixed_cost` (equal steps of equal cost, for real-time
        /// hosts). Drives with this choice: nonlinear elastic shaft; elastic shaft and parametric drive on inputs; rigid machine
        /// without transmission and loads whose motor is `none`, `kloss` or `input`
        "method": choice(&[&["adaptive"], &["fixed_cost"]]).usually("adaptive");
        /// internal step of `fixed_cost`, 0 for the documented default of the model
        "step_size": real(&unit::TIME, within(0.0, LONGEST_STEP_SIZE)).or(0.0);
    }

    /// `[coupling]`.
    EXCHANGE "`[coupling]`" {
        /// of a drive: the outputs J_load, dJ_load and tau_rest split its torque tau = J_load φ̈ + ½ dJ_load φ̇² + tau_rest; the
        /// inertia includes all parts that follow the shaft without slip (`m_roller` of an elastic output, m1 in contact, rigid
        /// followers). Of a RigidMachine with the motor `none`, `kloss` or `input`, without transmission and loads of its own: the
        /// inputs J_load, dJ_load and tau_rest replace tau, for the only load (`true`) or for a list of names from `torques`
        "inertia": value(Value::Flag).and(Value::Texts);
    }

    /// `[drive]`.
    DRIVE "`[drive]`" {
        /// `constant` speed; `input`: the FMU has the inputs phi, w, a; `speed`: it has the input w alone and integrates phi
        "mode": choice(&[&["constant", "constant_speed"], &["input", "inputs"], &["speed"]]).usually("constant");
        /// angular velocity, for `constant`
        "speed": real(&unit::ANGULAR_VELOCITY, within(-FASTEST, FASTEST)).or_text("required").also(&["w", "rpm", "n"]);
        /// angle at the start, for `constant` and `speed`
        "phi_start": real(&unit::ANGLE, within(-LARGEST_ANGLE, LARGEST_ANGLE)).or(0.0).also(&["phi"]);
    }

    /// `[start]`, of all models together.
    START "`[start]`" {
        /// of cam drives: `at_rest` relative to the cam, `given`, `steady_state`, or `equilibrium`, in which the loads balance the
        /// spring (with a clearance, only if they press m1 to a flank). Of a RigidMachine: `given` or `steady_state`. Of a
        /// DriveTrain: all except `given`
        "mode": choice(&[&["at_rest"], &["given"], &["steady_state", "periodic"], &["equilibrium"]]).or_text("`at_rest`, of a RigidMachine `given`");
        /// q at the start, for `given`
        "q": moved(&unit::LENGTH, &unit::ANGLE, within(-LARGEST_START[0], LARGEST_START[0])).or(0.0);
        /// q̇ at the start, for `given`
        "q_dot": moved(&unit::VELOCITY, &unit::ANGULAR_VELOCITY, within(-LARGEST_START[1], LARGEST_START[1])).or(0.0);
        /// angle of a machine's shaft at the start
        "phi_start": parameter::<RigidMachine>(0).also(&["phi"]);
        /// its angular velocity
        "w_start": parameter::<RigidMachine>(1).also(&["w", "speed"]);
    }

    /// `[elasticity]`.
    ELASTICITY "`[elasticity]`" {
        /// `output`: between cam and follower mass; `shaft`: between drive and cam
        "place": choice(&[&["output", "output_member"], &["shaft", "input_shaft"]]).required();
        /// mass of the follower
        "m": parameter::<elastic_output::Parameters>(0).and(parameter::<elastic_shaft::Parameters>(0).values[0]).also(&["mass"]);
        /// moment of inertia of the cam, for `shaft`
        "J": parameter::<elastic_shaft::Parameters>(1).or_text("required").also(&["inertia"]);
        /// stiffness
        "c": parameter::<elastic_output::Parameters>(1).and(parameter::<elastic_shaft::Parameters>(2).values[0])
            .or_text(THIS_OR_FREQUENCY).also(&["stiffness", "k"]);
        /// ω₀ = √(c/m), for `shaft` √(c/J̄) with J̄ = `J` + `m` · mean of U′²
        "natural_frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE);
        /// damping
        "b": parameter::<elastic_output::Parameters>(2).and(parameter::<elastic_shaft::Parameters>(3).values[0]).also(&["damping", "d"]);
        /// D = b / (2 m ω₀), for `shaft` b / (2 J̄ ω₀), instead of `b`
        "damping_ratio": real(&unit::NUMBER, NOT_NEGATIVE).also(&["D"]);
        /// mass on the cam's side of an elastic output
        "m_roller": real(&unit::MASS, within(0.0, 1e12)).or(0.0);
        /// for `shaft` of an ElasticCamDrive: the equation linearised in the twist
        "linear": value(Value::Flag);
    }

    /// `[backlash]`.
    CLEARANCE "`[backlash]`" {
        /// mass in the clearance
        "m1": parameter::<backlash::Parameters>(0);
        /// working mass; with `s = "inf"` you may set it to 0 or leave it out, without `c` and `b`
        "m2": real(&unit::MASS, NOT_NEGATIVE).and(parameter::<backlash::Parameters>(1).values[0]).or_text("required").also(&["mass"]);
        /// stiffness between them
        "c": parameter::<backlash::Parameters>(2).or_text(THIS_OR_FREQUENCY).also(&["stiffness", "k"]);
        /// ω = √(c/m2), of the working mass while m1 is in contact
        "natural_frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE);
        /// damping between them
        "b": parameter::<backlash::Parameters>(3).also(&["damping", "d"]);
        /// D = b / (2 m2 ω), instead of `b`
        "damping_ratio": real(&unit::NUMBER, NOT_NEGATIVE).also(&["D"]);
        /// clearance, above 0 with loads; `"inf"` removes flank B: the follower may lift off, and a spring, gravity or a force of
        /// its load must bring it back
        "s": parameter::<backlash::Parameters>(4).and(Value::Word("inf")).also(&["clearance"]);
        /// coefficient of restitution
        "e": parameter::<backlash::Parameters>(5).also(&["restitution"]);
    }

    /// A motion law.
    LAW "`[cam]`, and all other laws" {
        /// the kind of law
        "law": choice(&[&["fourier", "hs", "harmonic_series"], &["cycle", "standard_laws"], &["table", "points", "linear"], &["plan"], &["contour"]]).or_text("required; of loads `table`").also(&["type", "kind"]);
        /// `fourier`: the list [a₀, a₁, a₂ …] of at most 257
        "a": value(Value::Reals(Dimension::Own(0))).or_text("required").also(&["cos"]);
        /// `fourier`: the list [b₁, b₂ …] of at most 256, without b₀
        "b": value(Value::Reals(Dimension::Own(0))).also(&["sin"]);
        /// `fourier`, `table`: factor of all values, which then are pure numbers; not 0
        "scale": own(0, ANY);
        /// `cycle`: lift from the lower to the upper dwell
        "stroke": own(0, LIFT).or_text("required").also(&["lift"]);
        /// `cycle`: U in the lower dwell
        "lower": own(0, LIFT).or(0.0);
        /// `cycle`: the law of the rise
        "rise_law": choice(&[&["simple_sine", "harmonic", "simple_harmonic"], &["inclined_sine", "bestehorn", "bestehorn_sine", "cycloidal"], &["polynomial_345", "poly345", "3-4-5", "polynomial_5"], &["polynomial_4567", "poly4567", "4-5-6-7", "polynomial_7"], &["modified_sine", "modsine"], &["modified_trapezoid", "modtrap", "modified_trapezoidal"]]).or_text("required");
        /// `cycle`: the law of the return
        "return_law": choice(&[&["simple_sine", "harmonic", "simple_harmonic"], &["inclined_sine", "bestehorn", "bestehorn_sine", "cycloidal"], &["polynomial_345", "poly345", "3-4-5", "polynomial_5"], &["polynomial_4567", "poly4567", "4-5-6-7", "polynomial_7"], &["modified_sine", "modsine"], &["modified_trapezoid", "modtrap", "modified_trapezoidal"]]).or_text("as `rise_law`");
        /// `cycle`: angle at which the rise starts
        "rise_start": real(&unit::ANGLE, within(-TAU, TAU)).or(0.0);
        /// `cycle`: angle of the rise; the four angles make 2π together
        "rise": real(&unit::ANGLE, within(LEAST_MOTION, TAU)).or_text(REST_OF_TURN);
        /// `cycle`: angle of the upper dwell
        "upper_dwell": real(&unit::ANGLE, within(0.0, TAU)).or_text(REST_OF_TURN).also(&["dwell"]);
        /// `cycle`: angle of the return
        "return": real(&unit::ANGLE, within(LEAST_MOTION, TAU)).or_text(REST_OF_TURN);
        /// `cycle`: angle of the lower dwell
        "lower_dwell": real(&unit::ANGLE, within(0.0, TAU)).or_text(REST_OF_TURN);
        /// `cycle`: where the acceleration of the rise changes sign, as a fraction of its angle; a parameter of the FMU only if the
        /// scene has this key
        "rise_inflection": real(&unit::NUMBER, within(INFLECTION[0], INFLECTION[1])).or_text("0.5").also(&["lambda"]);
        /// `cycle`: the same of the return
        "return_inflection": real(&unit::NUMBER, within(INFLECTION[0], INFLECTION[1])).or_text("0.5");
        /// `plan`: 2 to 100 points, ascending within one turn; the last may repeat the first one turn later
        "point": value(Value::Tables(&POINT)).or_text("required");
        /// `table`, `contour`: path from the folder of the scene
        "file": value(Value::Text).or_text("this or `points`").also(&["path", "csv"]);
        /// `table`: the points themselves, `[["0 deg", 0], ["90 deg", "20 mm"], …]`
        "points": value(Value::Pairs);
        /// `table`, `contour`: unit of the angles
        "angle_unit": value(Value::Text).or_text("`rad`, or the unit of `turn`; of a contour the heading's unit");
        /// `table`: unit of the values
        "lift_unit": value(Value::Text).or_text("the coherent SI unit");
        /// `table`, `contour`: column of the angles, its number from 1 or its heading
        "angle_column": value(Value::Count(1, 1000)).and(Value::Text).or_text("1; of a contour 2");
        /// `table`: the distance of the angles in a file with one value per line and no angles; the first angle is 0
        "angle_step": other(POSITIVE);
        /// `table`: column of the values
        "lift_column": value(Value::Count(1, 1000)).and(Value::Text).or_text("2");
        /// `contour`: unit of x and y, or of r
        "length_unit": value(Value::Text).or_text("the heading's unit, or m").also(&["unit"]);
        /// `contour`: column of x, its number from 1 or its heading
        "x_column": value(Value::Count(1, 1000)).and(Value::Text).or_text("with the heading x, or 1");
        /// `contour`: column of y
        "y_column": value(Value::Count(1, 1000)).and(Value::Text).or_text("with the heading y, or 2");
        /// `contour`: column of the distance from the cam's centre, instead of x and y, with the column of the angle
        "r_column": value(Value::Count(1, 1000)).and(Value::Text).or_text("with the heading r, or 1");
        /// `table`: one turn of the cam in the column of the angles: `"720 deg"` of a crank, `4096` steps (a number without unit
        /// counts in the column's own unit), `"0.25 s"`, `"314 mm"`
        "turn": other(POSITIVE).or_text("2π rad");
        /// `table`: the angle after which the law repeats, written as `turn`, for a table of one of several equal lobes; a whole
        /// fraction of the turn
        "period": other(POSITIVE).or_text("the turn");
        /// `table`: outside of the table the cam rests at the level of its first and last row
        "outside": choice(&[&["rest"]]).or_text("the table covers the turn or `period`");
        /// `table`: U between the points, see below
        "interpolation": choice(&[&["spline", "quintic_spline"], &["derivatives"], &["fourier"], &["linear"], &["monotone", "pchip"]])
            .or_text("`spline`; of forces, torques, inertia and coefficients `monotone`");
        /// `table`, `fourier`: the highest harmonic, at most half the number of points; at unequal distances at most half a turn
        /// over the widest gap
        "harmonics": value(Value::Count(1, HIGHEST_HARMONIC as u32)).or_text("required");
        /// `table`, `contour`: standard deviation of the noise to remove from the lifts, or, as a length, from the points of the
        /// contour (δ/√3 for errors within ±δ), or `"estimate"`
        "noise": own(0, POSITIVE).and(Value::Word("estimate"));
        /// `table`: leaves out wrong rows, and a note names them
        "outliers": choice(&[&["drop"]]).or_text("wrong rows are refused");
    }

    /// `[[cam.point]]`.
    POINT "`[[cam.point]]`" {
        /// angle, at least 1e-3 after the previous point
        "phi": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).required().also(&["angle"]);
        /// position
        "U": own(0, LIFT).required().also(&["u"]);
        /// velocity dU/dφ
        "dU": own(1, ANY).or_text("the slope of an adjacent `straight` segment, else 0").also(&["velocity"]);
        /// d²U/dφ², or `"free"` at a turning point: the laws and inflections on both sides determine one common value
        "ddU": own(2, ANY).and(Value::Word(FREE)).or_text("0").also(&["acceleration"]);
        /// d³U/dφ³, for a polynomial of degree 7
        "dddU": own(3, ANY).or_text("not prescribed").also(&["jerk"]);
        /// the law of the segment that ends at the point: a standard law as of a cycle, or one of plans
        "law": choice(&[&["simple_sine", "harmonic", "simple_harmonic"], &["inclined_sine", "bestehorn", "bestehorn_sine", "cycloidal"], &["polynomial_345", "poly345", "3-4-5", "polynomial_5"], &["polynomial_4567", "poly4567", "4-5-6-7", "polynomial_7"], &["modified_sine", "modsine"], &["modified_trapezoid", "modtrap", "modified_trapezoidal"], &["polynomial_6"], &["sine"], &["cosines"], &["straight"]]).or_text("see below").also(&["type", "kind"]);
        /// where the acceleration changes sign in the segment that ends at the point, as a fraction of its angle; of `polynomial_6`
        /// 0.4 to 0.6
        "inflection": real(&unit::NUMBER, within(INFLECTION[0], INFLECTION[1])).or_text("0.5, or as an adjacent `ddU` requires").also(&["lambda"]);
    }

    /// `[geometry]`.
    GEOMETRY "`[geometry]`" {
        /// `lever`: oscillating roller lever; `translating`: roller on a slide; `flat`: flat-faced tappet on a slide
        "follower": choice(&[&["lever", "roller_lever", "oscillating", "rocker"], &["translating", "slider"], &["flat", "flat_faced"]]).required().also(&["type", "kind"]);
        /// radius of the roller
        "roller_radius": real(&unit::LENGTH, POSITIVE).or_text("required except for a flat face").also(&["roller"]);
        /// `inner`: disc, the roller runs on it; `outer`: ring, the roller runs in it; `groove`: both; `conjugate`: two discs F and
        /// P with a roller each
        "contour": choice(&[&["inner", "disc"], &["outer", "ring"], &["groove"], &["conjugate", "double"]]).usually("inner").also(&["cut"]);
        /// sense in which the cam turns for growing φ
        "rotation": choice(&[&["counterclockwise", "ccw", "left"], &["clockwise", "cw", "right"]]).usually("counterclockwise").also(&["sense", "direction"]);
        /// least radius of the inner contour; of a flat face its least height
        "base_radius": real(&unit::LENGTH, POSITIVE).or_text(SIZE).also(&["base_circle"]);
        /// least distance of the roller's centre from the cam's centre
        "prime_radius": real(&unit::LENGTH, POSITIVE).or_text(SIZE).also(&["prime_circle"]);
        /// of a lever: angle between the arm and the line pivot–cam centre at U = 0
        "start_angle": real(&unit::ANGLE, within(0.0, PI)).or_text(SIZE);
        /// of a translating follower: y of the roller's centre, or of the flat face, at U = 0
        "start_height": real(&unit::LENGTH, ANY).or_text(SIZE);
        /// of a lever: pivot to cam centre
        "pivot_distance": real(&unit::LENGTH, POSITIVE).or_text("required").also(&["pivot", "centre_distance", "center_distance"]);
        /// of a lever: pivot to roller's centre
        "arm_length": real(&unit::LENGTH, POSITIVE).or_text("required").also(&["arm", "lever_length"]);
        /// of a lever: travel of the tool per radian by which the arm moves away from the centre of the cam, negative if the tool
        /// moves the other way. If the law is the angle of a lever: radians of the law per radian of the arm. Not 0
        "transmission": moved(&unit::LENGTH, &unit::NUMBER, ANY).or_text("`arm_length`; 1 for an angle");
        /// of a lever: side of the roller, seen from the centre of the cam towards the pivot
        "side": choice(&[&["left"], &["right"]]).usually("left");
        /// of a translating follower: x of its line
        "offset": real(&unit::LENGTH, ANY).or(0.0).also(&["eccentricity"]);
        /// for `conjugate`: radius of the second roller
        "second_roller_radius": real(&unit::LENGTH, POSITIVE).or_text("`roller_radius`");
        /// for `conjugate`, lever: angle between both arms, with the line pivot–cam centre between them
        "second_arm_angle": real(&unit::ANGLE, within(0.0, 2.0 * PI)).or_text("required");
        /// for `conjugate`, lever: length of the second arm
        "second_arm_length": real(&unit::LENGTH, POSITIVE).or_text("`arm_length`");
        /// for `conjugate`, translating: distance between both rollers' centres
        "roller_distance": real(&unit::LENGTH, POSITIVE).or_text("required");
        /// admissible pressure angle
        "max_pressure_angle": real(&unit::ANGLE, within(0.0, PI / 2.0)).or_text("45°, translating 30°").also(&["pressure_angle"]);
        /// radius of the tool that cuts or grinds concave parts; for a flat face, of the cutter whose path is drawn
        "cutter_radius": real(&unit::LENGTH, NOT_NEGATIVE).or_text("`roller_radius`; of a flat face no path");
        /// radius of shaft and hub; a disc must not be cut into them
        "hub_radius": real(&unit::LENGTH, NOT_NEGATIVE).or(0.0);
    }

    /// `[load]`.
    LOAD "`[load]`" with ROLLER {
        /// P over the angle of the machine, negative for a resistance: a value, or a law
        "process": moved(&unit::FORCE, &unit::TORQUE, ANY).and(Value::Table(&LAW)).also(&["load"]);
        /// whether F is an input of the FMU
        "input": value(Value::Flag);
        /// `gravity`, `force`, `spring` and `damping` on the mass on the cam's side: m1 of a backlash, `m_roller` of an elasticity
        "roller": value(Value::Table(&ROLLER)).also(&["mass"]);
    }

    /// `[load]` of a ParametricDrive.
    PARAMETRIC_LOAD "`[load]` of a ParametricDrive" with LOAD {
        /// of a crank: the list [a₀, a₁, a₂ …] of f(φ), the torque on the driven side, positive in the sense of φ
        "a": value(Value::Reals(Dimension::Own(0)));
        /// of a crank: the list [b₁, b₂ …]
        "b": value(Value::Reals(Dimension::Own(0)));
        /// of a crank: factor of all coefficients, which then are pure numbers; not 0
        "scale": own(0, ANY);
    }

    /// `[load.roller]`.
    ROLLER "`[load]` and `[load.roller]`" {
        /// g; a tool that turns counts as balanced
        "gravity": real(&unit::ACCELERATION, NOT_NEGATIVE).also(&["g"]);
        /// α: direction of gravity, from the direction in which the tool moves for growing y. With mechanisms: a list with an angle
        /// for each, from the x axis of its frame, of a rack from the direction of the tool, since their links have weight too
        "gravity_angle": real(&unit::ANGLE, within(-TAU, TAU)).and(Value::Reals(Dimension::Fixed(&unit::ANGLE)))
            .or_text("180°, the weight presses on the cam; -90° for each mechanism");
        /// F₀
        "force": moved(&unit::FORCE, &unit::TORQUE, ANY).also(&["F0", "constant"]);
        /// the return spring
        "spring": value(Value::Table(&SPRING)).also(&["c"]);
        /// b to the ground
        "damping": moved(&unit::DAMPING, &unit::ROTATIONAL_DAMPING, NOT_NEGATIVE).also(&["b", "d"]);
    }

    /// `spring` of a load.
    SPRING "`spring`" {
        /// F_v, its force against the sense of y at y = `at`
        "preload": moved(&unit::FORCE, &unit::TORQUE, NOT_NEGATIVE).or(0.0).also(&["F_v"]);
        /// its stiffness c
        "c": moved(&unit::STIFFNESS, &unit::ROTATIONAL_STIFFNESS, NOT_NEGATIVE).or(0.0).also(&["stiffness"]);
        /// y₀
        "at": moved(&unit::LENGTH, &unit::ANGLE, ANY).or_text("the least y of the turn").also(&["y0"]);
    }

    /// `[forces]`.
    FORCES "`[forces]`" {
        /// moment of inertia of the lever and all parts that turn with it, about its pivot
        "lever_J": real(&unit::INERTIA, NOT_NEGATIVE).or(0.0).also(&["J"]);
        /// pitch radius of the output wheel of a gear pair, for the force on its teeth; not needed for a rack
        "tooth_radius": real(&unit::LENGTH, POSITIVE).or_text("no tooth force");
        /// pressure angle of the teeth
        "tooth_angle": real(&unit::ANGLE, within(0.0, 0.25 * TAU - 0.01)).or(TOOTH_ANGLE);
        /// width of the contact between roller and cam, for the Hertzian pressure of a cylindrical roller; for cams with a geometry
        "roller_width": real(&unit::LENGTH, POSITIVE).or_text("no pressure").also(&["width"]);
        /// modulus of elasticity of the cam
        "E_cam": real(&units::PRESSURE, POSITIVE).or(STEEL[0]).also(&["E"]);
        /// modulus of elasticity of the roller
        "E_roller": real(&units::PRESSURE, POSITIVE).or(STEEL[0]);
        /// Poisson's ratio of the cam
        "nu_cam": real(&unit::NUMBER, within(0.0, 0.5)).or(STEEL[1]).also(&["nu"]);
        /// Poisson's ratio of the roller
        "nu_roller": real(&unit::NUMBER, within(0.0, 0.5)).or(STEEL[1]);
    }

    /// `[machine]`.
    MACHINE_TABLE "`[machine]`" {
        /// constant part of the moment of inertia
        "J0": real(&unit::INERTIA, POSITIVE).required().also(&["inertia"]);
        /// a part that varies with φ: a law
        "J": value(Value::Table(&LAW));
        /// loads of the shaft itself
        "load": value(Value::Table(&SHAFT_LOAD));
    }

    /// `[machine.load]`.
    SHAFT_LOAD "`[machine.load]`" {
        /// M_L over φ, against the sense of φ: a value, or a law
        "torque": real(&unit::TORQUE, ANY).and(Value::Table(&LAW)).also(&["M"]);
        /// b_L: a torque b_L φ̇ against the motion
        "friction": real(&unit::ROTATIONAL_DAMPING, NOT_NEGATIVE).also(&["b", "damping"]);
        /// of a DriveTrain: whether the FMU has the input tau; a positive value brakes
        "input": value(Value::Flag);
    }

    /// `[[follower]]`.
    FOLLOWER "`[[follower]]`" {
        /// mass of a tool that moves along a line; 0 is admitted with mechanisms
        "m": real(&unit::MASS, NOT_NEGATIVE).or_text("required").also(&["mass"]);
        /// moment of inertia of a tool that turns, instead of `m`; the law of its cam is then an angle
        "J": real(&unit::INERTIA, NOT_NEGATIVE).also(&["inertia"]);
        /// the law of the cam; with mechanisms, of the lever
        "cam": value(Value::Table(&LAW)).or_text("required");
        /// instead of `cam`, with mechanisms: the law of the tool's position. The law of the lever follows by inverse kinematics,
        /// to 1e-9 of the largest acceleration of the tool or better (`camdrive check` shows the error): a Fourier series for a
        /// Fourier series, else pieces of degree 5 that keep dwells and jumps of the acceleration
        "tool": value(Value::Table(&LAW));
        /// for `tool`: angle of the lever near which its motion starts, if two positions of the lever give the same position of the
        /// tool
        "lever_start": dimension(ParameterKind::Angle).or(0.0);
        /// instead of `cam`: the input link of the first mechanism turns with the shaft, at φ + `offset`; the tool must return to
        /// its position after each turn of the shaft
        "crank": value(Value::Table(&CRANK));
        /// the mechanisms between lever and tool, in this order
        "linkage": value(Value::Tables(&LINKAGE)).also(&["links", "mechanism", "mechanisms"]);
        /// of a DriveTrain: the elastic member instead of `m`
        "elasticity": value(Value::Table(&ELASTICITY));
        /// of a DriveTrain: the clearance instead of `m`
        "backlash": value(Value::Table(&CLEARANCE));
        /// as for a drive with one cam
        "load": value(Value::Table(&LOAD));
        /// as for a drive with one cam
        "geometry": value(Value::Table(&GEOMETRY));
        /// as for a drive with one cam
        "forces": value(Value::Table(&FORCES));
    }

    /// `[follower.crank]`.
    CRANK "`[follower.crank]`" {
        /// angle of the input link at the shaft angle 0
        "offset": real(&unit::ANGLE, within(-TAU, TAU)).or(0.0).also(&["e"]);
    }

    /// `[[follower.linkage]]`.
    LINKAGE "`[[follower.linkage]]`" {
        /// `four_bar`, `slider_crank` or `gear` (gear pair, belt, rack and pinion)
        "kind": choice(&[&["four_bar", "four-bar", "fourbar"], &["slider_crank", "slider-crank", "crank_slider"], &["gear", "belt", "rack"]]).required().also(&["type"]);
        /// the mechanism's own input angle at position 0 of its drive
        "input_offset": dimension(ParameterKind::Angle).or(0.0);
        /// the mechanism's own output at position 0 of the part it drives
        "output_offset": moved(&unit::LENGTH, &unit::ANGLE, within(-1e4, 1e4)).or(0.0);
        /// sign of the root: chooses one of the mechanism's two positions
        "branch": choice(&[&["plus", "+"], &["minus", "-"]]).usually("plus").also(&["mode"]);
        /// g of a `four_bar`
        "ground": dimension(ParameterKind::Length).or_text("required").also(&["frame", "g"]);
        /// link a of a `four_bar`
        "input": value(Value::Table(&LINK)).or_text("required").also(&["a"]);
        /// link b of a `four_bar`
        "coupler": value(Value::Table(&LINK)).or_text("required").also(&["b"]);
        /// link c of a `four_bar`
        "output": value(Value::Table(&LINK)).or_text("required").also(&["c", "rocker"]);
        /// link r of a `slider_crank`
        "crank": value(Value::Table(&LINK)).or_text("required").also(&["r"]);
        /// link l of a `slider_crank`
        "rod": value(Value::Table(&LINK)).or_text("required").also(&["l", "connecting_rod"]);
        /// e of a `slider_crank`
        "offset": dimension(ParameterKind::Coordinate).or(0.0).also(&["e"]);
        /// mass of the slider of a `slider_crank` without the tool
        "slider_m": dimension(ParameterKind::Mass).or(0.0);
        /// i of a `gear` whose output turns; not 0
        "ratio": dimension(ParameterKind::Ratio).or_text("this or `radius`");
        /// i of a `gear` whose output moves along a line; only as the last mechanism; not 0
        "radius": dimension(ParameterKind::Radius);
        /// moment of inertia of all parts that turn with the input of a `gear`
        "J": dimension(ParameterKind::Inertia).or(0.0).also(&["inertia"]);
    }

    /// A link.
    LINK "a link" {
        /// distance between the joints
        "length": dimension(ParameterKind::Length).required();
        /// mass
        "m": dimension(ParameterKind::Mass).or(0.0).also(&["mass"]);
        /// moment of inertia about the centre of mass
        "J": dimension(ParameterKind::Inertia).or_text("a slender bar's, `m`·`length`²/12").also(&["inertia"]);
        /// centre of mass from the first joint along the line to the second
        "x": dimension(ParameterKind::Coordinate).or_text("in the middle");
        /// centre of mass, to the left of this line
        "y": dimension(ParameterKind::Coordinate).or(0.0);
    }

    /// `[motor]`.
    MOTOR "`[motor]`" {
        /// `none`; `input`: the torque is an input; `constant`; `table`: a torque over the speed; `kloss`: asynchronous motor;
        /// `servo`: speed control with limited torque
        "kind": choice(&[&["none"], &["kloss", "asynchronous", "induction"], &["input", "torque"], &["constant"], &["table"], &["servo"]]).required().also(&["type"]);
        /// of `constant`: the torque
        "torque": real(&unit::TORQUE, within(-1e12, 1e12)).or_text("required").also(&["M"]);
        /// of `table`: 2 to 200 pairs of a speed and a torque, speeds ascending; monotone cubic between the points, constant
        /// outside
        "points": value(Value::Pairs).or_text("this or `file`");
        /// of `table`: a file with the points
        "file": value(Value::Text).also(&["path", "csv"]);
        /// of a file: unit of the speeds
        "speed_unit": value(Value::Text).or_text("`rad/s`");
        /// of a file: unit of the torques
        "torque_unit": value(Value::Text).or_text("`N.m`");
        /// of a file: column of the speeds, its number from 1 or its heading
        "speed_column": value(Value::Count(1, 1000)).and(Value::Text).or_text("1");
        /// of a file: column of the torques
        "torque_column": value(Value::Count(1, 1000)).and(Value::Text).or_text("2");
        /// of `kloss`: breakdown torque
        "M_k": parameter::<Kloss>(0).or_text("required");
        /// of `kloss`: breakdown slip
        "s_k": parameter::<Kloss>(1).or_text("required");
        /// of `kloss`: synchronous speed, at least 1e-100 in magnitude
        "w_s": parameter::<Kloss>(2).or_text("required").also(&["speed"]);
        /// of `kloss`: electrical time constant of the torque. A DriveTrain starts with the torque at its speed; a RigidMachine
        /// with 0 or with `motor.M_start` of its FMU
        "lag": real(&unit::TIME, within(LAG[0], LAG[1])).or_text("none: the torque follows at once").also(&["time_constant", "dynamics"]);
        /// of `servo`: torque per deviation of the speed
        "K_p": real(&unit::ROTATIONAL_DAMPING, POSITIVE).or_text("required");
        /// of `servo`: torque per integral of the deviation
        "K_i": real(&unit::ROTATIONAL_STIFFNESS, NOT_NEGATIVE).or(0.0);
        /// of `servo`: rate at which the integral follows a limited torque
        "K_aw": real(&unit::RATE, NOT_NEGATIVE).or_text("`K_i`/`K_p`");
        /// of `servo`: largest torque
        "M_max": real(&unit::TORQUE, POSITIVE).or_text("required").also(&["limit"]);
        /// of `servo`: speed to keep: a value, `"input"`, or a table
        "w_ref": real(&unit::ANGULAR_VELOCITY, within(-FASTEST, FASTEST)).and(Value::Word("input")).and(Value::Table(&REFERENCE))
            .or_text("required").also(&["reference"]);
        /// of `servo`: gain of a position loop on top; its φ_ref is the integral of w_ref, or an input too
        "K_v": real(&unit::RATE, POSITIVE);
        /// speed of the rotor over the speed of the shaft, negative for opposite senses; not 0
        "ratio": real(&unit::NUMBER, within(-1e6, 1e6)).or(1.0).also(&["i"]);
        /// moment of inertia of the rotor; above 0 with a coupling or belt
        "J": real(&unit::INERTIA, NOT_NEGATIVE).or(0.0).also(&["inertia"]);
        /// of a DriveTrain: an elastic coupling between rotor and shaft
        "coupling": value(Value::Table(&COUPLING));
        /// of a DriveTrain, instead of a coupling: a belt, c = 2 EA/length · radius², linear up to the torque 2 · preload · radius,
        /// which `check` prints
        "belt": value(Value::Table(&BELT));
    }

    /// `motor.w_ref`.
    REFERENCE "`motor.w_ref` as a table" with SERIES {
        /// frequency of a series over time
        "frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE).or_text("this or `ramp`").also(&["w", "nu"]);
        /// acceleration from rest, instead of a series
        "ramp": real(&unit::ANGULAR_ACCELERATION, within(-1e12, 1e12));
    }

    /// `[motor.coupling]`.
    COUPLING "`[motor.coupling]`" {
        /// stiffness at the shaft
        "c": real(&unit::ROTATIONAL_STIFFNESS, POSITIVE).required().also(&["stiffness"]);
        /// damping at the shaft
        "b": real(&unit::ROTATIONAL_DAMPING, NOT_NEGATIVE).or(0.0).also(&["damping"]);
    }

    /// `[motor.belt]`.
    BELT "`[motor.belt]`" {
        /// EA of each of the two strands
        "EA": real(&unit::FORCE, POSITIVE).required();
        /// preload of each strand
        "preload": real(&unit::FORCE, POSITIVE).required().also(&["F_v"]);
        /// length of a strand
        "length": real(&unit::LENGTH, POSITIVE).required().also(&["L"]);
        /// radius of the pulley on the shaft
        "radius": real(&unit::LENGTH, POSITIVE).required().also(&["r"]);
        /// damping at the shaft
        "b": real(&unit::ROTATIONAL_DAMPING, NOT_NEGATIVE).or(0.0).also(&["damping"]);
    }

    /// `[coefficients]`.
    COEFFICIENTS "`[coefficients]`" {
        /// `rotation` (q is an angle) or `translation` (q is a length); it determines the units below
        "coordinate": choice(&[&["rotation", "angle"], &["translation", "length"]]).usually("rotation");
        /// m(φ): a number, a series `{ scale, a, b }` or another law, above 0 at every φ
        "m": moved(&unit::MASS, &unit::INERTIA, ANY).and(Value::Table(&LAW)).required().also(&["mass"]);
        /// c(φ)
        "c": moved(&unit::STIFFNESS, &unit::ROTATIONAL_STIFFNESS, ANY).and(Value::Table(&LAW)).required().also(&["stiffness", "k"]);
        /// b(φ)
        "b": moved(&unit::DAMPING, &unit::ROTATIONAL_DAMPING, ANY).and(Value::Table(&LAW)).or_text("0").also(&["damping", "d"]);
        /// D = b / (2 √(m c)) with the means of m and c, instead of `b`
        "damping_ratio": real(&unit::NUMBER, NOT_NEGATIVE).also(&["D"]);
        /// f(φ)
        "f": moved(&unit::FORCE, &unit::TORQUE, ANY).and(Value::Table(&LAW));
    }

    /// A series.
    SERIES "a series" {
        /// the list [a₀, a₁, a₂ …] of at most 257
        "a": value(Value::Reals(Dimension::Own(0))).or_text("required").also(&["cos"]);
        /// the list [b₁, b₂ …] of at most 256
        "b": value(Value::Reals(Dimension::Own(0))).also(&["sin"]);
        /// factor of all coefficients, which then are pure numbers; not 0
        "scale": own(0, ANY);
    }

    /// `[crank]`.
    PARALLEL_CRANK "`[crank]`" {
        /// moment of inertia on the driven side
        "J": parameter::<CrankLaw>(0).also(&["inertia"]);
        /// torsional stiffness of the driving shaft
        "c_T1": parameter::<CrankLaw>(2).also(&["c"]);
        /// torsional stiffness of the driven shaft
        "c_T2": parameter::<CrankLaw>(3);
        /// longitudinal stiffness of a coupling rod
        "c_AB": parameter::<CrankLaw>(4);
        /// length of the cranks
        "R": parameter::<CrankLaw>(5).also(&["r"]);
        /// torsional damping between both sides
        "b_T": parameter::<CrankLaw>(1).also(&["b"]);
        /// D = b_T / (2 √(J c₀)), c₀ the mean of c_T, instead of `b_T`
        "damping_ratio": real(&unit::NUMBER, NOT_NEGATIVE).also(&["D"]);
        /// `own_shafts`: a second crank set with shafts of its own of the same stiffness; `shared_shafts`: on the same shafts
        "second": choice(&[&["none"], &["own_shafts"], &["shared_shafts"]]).usually("none").also(&["second_crank"]);
        /// angle by which the second crank runs ahead
        "angle": real(&unit::ANGLE, within(-TAU, TAU)).or(FRAC_PI_2).also(&["offset"]);
        /// highest harmonic of c_T
        "harmonics": value(Value::Count(0, HIGHEST_OF_CRANK)).or_text("all: the closed form of c_T");
    }

    /// A study.
    STUDY "a study" {
        /// the scene, the system (TOML, .ssp) or the FMU whose variants run; the path starts at the folder of the study
        "scene": value(Value::Text).required();
        /// measures of outputs: `max |q|`, `rms force`, `count impacts` …
        "measures": value(Value::Texts).required().also(&["measure"]);
        /// duration of the measurement
        "time": real(&unit::TIME, POSITIVE).or_text("this or `turns`");
        /// duration of the measurement in turns of the shaft
        "turns": real(&unit::NUMBER, POSITIVE).or_text("this or `time`");
        /// run-in before the measurement: a time, or with `turns` a number of turns
        "settle": other(NOT_NEGATIVE).or(0.0);
        /// communication step of a system or an FMU
        "step": real(&unit::TIME, POSITIVE).or_text("the step of the system or the FMU").also(&["step_size"]);
        /// error of an output between two points of the motion of a scene, relative to its largest magnitude
        "accuracy": real(&unit::NUMBER, within(1e-12, 1e-2)).or(1e-6).also(&["tolerance"]);
        /// a quantity that varies, or several; all entries are combined with each other
        "vary": value(Value::Tables(&VARY)).required();
        /// number of samples of all quantities with a distribution
        "runs": value(Value::Count(1, MOST_RUNS)).also(&["samples"]);
        /// how the samples are drawn
        "design": choice(&[&["latin_hypercube", "lhs"], &["random", "monte_carlo"]]).usually("latin_hypercube");
        /// seed of the random numbers
        "seed": value(Value::Count(0, u32::MAX)).or(1.0);
    }

    /// `[[vary]]`.
    VARY "`[[vary]]`" {
        /// a variable of the FMU (`drive.w`, `cam.a[3]`), or a key of the scene (`elasticity.natural_frequency`, `follower[1].m`);
        /// of a system after the name of the part: `pusher.m`, `pusher.elasticity.natural_frequency`
        "name": value(Value::Text).or_text("this, `names` or `file`");
        /// several names: with `values` they vary together, with a distribution each varies independently
        "names": value(Value::Texts);
        /// a CSV file with such names as headings; a unit in brackets applies to the column: `drive.w [rpm]`
        "file": value(Value::Text);
        /// the values, each written as in a scene, or a single one; with `names` a list for each run
        "values": value(Value::Values).also(&["value"]);
        /// first value of a series, or the lower end of a uniform distribution
        "from": value(Value::Real(Dimension::Other, ANY)).also(&["min"]);
        /// last value, or the upper end
        "to": value(Value::Real(Dimension::Other, ANY)).also(&["max"]);
        /// number of values from `from` to `to`; without it the quantity is sampled
        "count": value(Value::Count(1, MOST_RUNS)).also(&["n", "points"]);
        /// equal distances, or equal ratios
        "scale": choice(&[&["linear"], &["log", "logarithmic"]]).usually("linear");
        /// mean of a normal distribution
        "mean": value(Value::Real(Dimension::Other, ANY));
        /// its standard deviation
        "deviation": value(Value::Real(Dimension::Other, POSITIVE)).also(&["sigma", "std"]);
    }

    /// A system.
    SYSTEM "a system" {
        /// name of the SSP and its parameter set, with the same rules as in a scene
        "name": value(Value::Text).required().also(&["title"]);
        /// end of the default experiment
        "stop": real(&unit::TIME, POSITIVE).required().also(&["stop_time", "time"]);
        /// communication step
        "step": real(&unit::TIME, POSITIVE).required().also(&["step_size", "h"]);
        /// how the parts exchange values at a communication point: `held`, with values from the start of the step, as usual in
        /// masters; `interpolated`, the machine first with extrapolated torque, then the drives, which get the machine's motion at
        /// both ends of the step; `effective_inertia`, the same, and the machine adds the inertia of rigid loads to its own
        "exchange": choice(&[&["interpolated"], &["held", "jacobi"], &["effective_inertia"]]).usually("interpolated").gone(&[
            ("extrapolated", "write `interpolated`; `camdrive system --study` still compares them"),
            ("gauss_seidel", "write `interpolated`; `camdrive system --study` still compares them"),
        ]);
        /// how often `camdrive run` repeats an interpolated step with the values at its end. Without this key: once if the scenes
        /// of all parts are known, κ is at most 0.2 and the step is stable then
        "repeat": value(Value::Count(0, 10));
        /// the parts, each a table with a name of its own, `[part.machine]`: a C identifier of at most 24 characters
        "part": value(Value::Named(&PART)).required().also(&["parts"]);
        /// connections other than shafts
        "connection": value(Value::Tables(&CONNECTION)).also(&["connections"]);
    }

    /// `[part.NAME]`.
    PART "`[part.NAME]`" {
        /// a scene; path from the folder of the system
        "scene": value(Value::Text).or_text("this or `fmu`");
        /// an FMU for Co-Simulation (FMI 2.0), from any tool
        "fmu": value(Value::Text).or_text("this or `scene`");
        /// the part on whose shaft this one sits: phi, w, a come from there, its torque goes there
        "shaft": value(Value::Text).also(&["on"]);
        /// i: its speed over the shaft's speed, magnitude 1e-6 to 1e6; its torque acts i times on the shaft
        "ratio": real(&unit::NUMBER, ANY).or(1.0).also(&["i"]);
        /// its angle at the shaft angle 0
        "offset": real(&unit::ANGLE, ANY).or(0.0).also(&["phase"]);
        /// parameters and inputs of its FMU, set before the start: { w_start = "300 rpm" }; give a unit if the FMU's unit is not SI
        "start": value(Value::Variables);
    }

    /// `[[connection]]`.
    CONNECTION "`[[connection]]`" {
        /// an output, `part.variable`
        "from": value(Value::Text).required().also(&["source"]);
        /// an input; a value in another unit of the same dimension is converted
        "to": value(Value::Text).required().also(&["target"]);
        /// factor of the value, not 0; for Reals only
        "factor": real(&unit::NUMBER, ANY).or(1.0).also(&["scale"]);
        /// added to the value: a number in SI, or a text with its unit, required if the input's unit is not SI; for Reals only
        "offset": value(Value::Real(Dimension::Other, ANY)).or(0.0);
    }

    /// A task.
    TASK "a task" with TASK_LAW {
        /// names the files and the scene, with the same rules as in a scene
        "name": value(Value::Text).required().also(&["title"]);
        /// one sentence
        "description": value(Value::Text);
        /// what is minimised
        "objective": choice(&[&["least_squares", "S1"], &["chebyshev", "S3", "minimax"], &["chebyshev_sum", "S5"], &["peak_acceleration"], &["mean_square_acceleration"], &["longest_dwell"], &["fewest_harmonics"], &["peak_torque", "torque"], &["shaft_torque"]]).required().also(&["goal", "criterion"]).gone(&[
            ("discrete_least_squares", SQUARES), ("S2", SQUARES), ("discrete_chebyshev", LARGEST), ("S4", LARGEST),
        ]);
        /// w₁ of the errors in U′ (rad; rad² with sums of squares); with this key, the derivative of U in a range counts as
        /// prescribed
        "dU_weight": other(NOT_NEGATIVE).or_text("1 where U′ is prescribed");
        /// w₂ of the errors in U″ (rad²; rad⁴ with sums of squares); likewise
        "ddU_weight": other(NOT_NEGATIVE).or_text("1 where U″ is prescribed");
        /// a length; all U of the task are multiples of it
        "scale": real(&unit::LENGTH, POSITIVE).or_text("none: lengths").also(&["stroke"]);
        /// a scene whose `[cam]` is replaced; the path starts at the folder of the task
        "scene": value(Value::Text);
        /// ε: Σ ∫ (e₀² + w₁ e₁² + w₂ e₂²) dφ ≤ ε over all ranges and dwells together, with their weights: a length squared times an
        /// angle, `"0.01 mm2.rad"`, `"0.5 mm2.deg"`, or without the angle `"0.01 mm2"`; with `scale` a number, `"1e-5 rad"` or
        /// `1e-5`; for the accelerations as objective
        "integral_tolerance": other(POSITIVE);
        /// of `longest_dwell`: the only `[[dwell]]` that grows, counted from 1
        "longest": value(Value::Count(1, 1000)).or_text("all, by one factor");
        /// of `peak_torque` and `shaft_torque`: number of starting points of the search
        "starts": value(Value::Count(1, 1000)).or(8.0);
        /// seed of the random numbers for the starting points
        "seed": value(Value::Count(0, u32::MAX)).or(1.0);
        /// several laws in one task, up to five
        "law": value(Value::Tables(&TASK_LAW)).also(&["laws"]);
        /// a bound of a sum of several laws
        "restriction": value(Value::Tables(&RESTRICTION)).also(&["restrictions"]);
        /// a minimum distance between two tools
        "clearance": value(Value::Tables(&TOOL_CLEARANCE)).also(&["clearances"]);
        /// an elastic output member between cam and mass
        "elasticity": value(Value::Table(&TASK_ELASTICITY));
        /// of `shaft_torque`: the input shaft
        "shaft": value(Value::Table(&SHAFT));
    }

    /// `[[law]]` of a task.
    TASK_LAW "`[[law]]`" {
        /// the highest harmonic K
        "harmonics": value(Value::Count(1, MOST_HARMONICS)).or_text("required").also(&["K"]);
        /// symmetry of U: `none`, `even` (cosines only), `half_wave` (odd harmonics and the mean a₀: U(φ + 180°) − a₀ = −(U(φ) −
        /// a₀)), `even_half_wave` (both)
        "symmetry": choice(&[&["none"], &["even"], &["half_wave"], &["even_half_wave"]]).usually("none");
        /// name of the law, if the task has several
        "name": value(Value::Text).or_text("required");
        /// weight of the errors of the law, if the task has several
        "weight": real(&unit::NUMBER, POSITIVE).or(1.0);
        /// a prescribed motion
        "range": value(Value::Tables(&RANGE)).also(&["ranges"]);
        /// a prescribed dwell
        "dwell": value(Value::Tables(&DWELL)).also(&["dwells"]);
        /// a prescribed point
        "point": value(Value::Tables(&TASK_POINT)).also(&["point_condition"]);
        /// a bound of U or of a derivative
        "bound": value(Value::Tables(&BOUND)).also(&["bounds"]);
    }

    /// The keys common to a range and a dwell.
    EITHER "`[[range]]` and `[[dwell]]`" {
        /// first angle
        "from": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).or_text("required").also(&["start"]);
        /// last angle
        "to": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).or_text("required").also(&["end"]);
        /// weight in sums and maxima
        "weight": real(&unit::NUMBER, POSITIVE).or(1.0);
        /// largest admissible error of U, with any objective
        "tolerance": own(0, POSITIVE).also(&["tol"]);
        /// largest admissible error of U′
        "dU_tolerance": own(1, POSITIVE);
        /// largest admissible error of U″
        "ddU_tolerance": own(2, POSITIVE);
    }

    /// `[[range]]`.
    RANGE "`[[range]]`" with EITHER {
        /// U there: a number, or the list of the coefficients of a polynomial in φ − `from`
        "U": own(0, ANY).and(Value::Reals(Dimension::Own(0))).or_text("at least one of U, dU, ddU, target").also(&["u"]);
        /// U′ there
        "dU": own(1, ANY).and(Value::Reals(Dimension::Own(1))).also(&["U1"]);
        /// U″ there
        "ddU": own(2, ANY).and(Value::Reals(Dimension::Own(2))).also(&["U2"]);
        /// instead of `U`: a motion law as in `[cam]` of a scene, over the turn. A table must cover the turn or, as a spline without
        /// `noise`, at least `from` to `to`: a measured flank is enough. Without `period` its angles are the angles of the turn
        "target": value(Value::Table(&TARGET));
    }

    /// `[range.target]`.
    TARGET "`target`" with LAW {
        /// angle to which the 360° of the law are mapped, starting at `from`
        "period": real(&unit::ANGLE, within(1e-6, TAU));
    }

    /// `[[dwell]]`.
    DWELL "`[[dwell]]`" with EITHER {
        /// the middle of the dwell, with `width` instead of `from` and `to`
        "centre": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).also(&["center"]);
        /// the angle of the dwell
        "width": real(&unit::ANGLE, within(1e-6, TAU));
        /// the position in the dwell
        "U": own(0, ANY).required().also(&["u"]);
    }

    /// `[[point]]` of a task.
    TASK_POINT "`[[point]]`" {
        /// angle
        "phi": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).required();
        /// U there, exactly
        "U": own(0, ANY).or_text("at least one of U, dU, ddU, dddU").also(&["u"]);
        /// U′ there
        "dU": own(1, ANY).also(&["U1"]);
        /// U″ there
        "ddU": own(2, ANY).also(&["U2"]);
        /// U‴ there
        "dddU": own(3, ANY).also(&["U3"]);
        /// the point is approximated with this weight (of the square in sums, of the error in maxima)
        "weight": real(&unit::NUMBER, POSITIVE).or_text("holds exactly");
    }

    /// `[[bound]]`.
    BOUND "`[[bound]]`" {
        /// the bounded quantity
        "of": choice(&[&["U"], &["dU"], &["ddU"], &["dddU"]]).required();
        /// the lower bound, in the unit of the bounded quantity, or the list of the coefficients of a polynomial in φ − `from`
        "min": other(ANY).and(Value::Reals(Dimension::Other)).or_text("at least one of min, max, limit");
        /// the upper bound, likewise
        "max": other(ANY).and(Value::Reals(Dimension::Other));
        /// the same bound on both sides: −`limit` to `limit`
        "limit": other(POSITIVE);
        /// a motion law as in a range; the bounds are relative to its derivative of this order
        "target": value(Value::Table(&TARGET));
        /// first angle
        "from": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).or_text("the whole turn").also(&["start"]);
        /// last angle
        "to": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).also(&["end"]);
    }

    /// `[[restriction]]`.
    RESTRICTION "`[[restriction]]`" with BOUND {
        /// αⱼ, one for each law: Σ αⱼ Uⱼ⁽ⁿ⁾(φ) is bounded; not all 0
        "factors": value(Value::Reals(Dimension::Fixed(&unit::NUMBER))).required();
    }

    /// `[[clearance]]`.
    TOOL_CLEARANCE "`[[clearance]]`" {
        /// the law of a tool that moves on a straight line, counted from 1
        "a": value(Value::Count(1, 5)).or(1.0);
        /// the law of another tool
        "b": value(Value::Count(1, 5)).or(2.0);
        /// [x, y] from tool b to tool a when both U are 0
        "offset": value(Value::Reals(Dimension::Own(0))).required();
        /// direction in which tool a moves with U
        "direction_a": real(&unit::ANGLE, within(-TAU, TAU)).or(0.0);
        /// direction in which tool b moves with U
        "direction_b": real(&unit::ANGLE, within(-TAU, TAU)).or(FRAC_PI_2);
        /// the tools keep at least this distance over the whole turn
        "distance": own(0, POSITIVE).required();
    }

    /// `[elasticity]` of a task.
    TASK_ELASTICITY "`[elasticity]` of a task" {
        /// ω₀
        "natural_frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE).required().also(&["w0"]);
        /// δ
        "damping_ratio": real(&unit::NUMBER, within(0.0, 10.0)).or(0.0).also(&["D"]);
        /// least speed of the cam
        "slowest": real(&unit::ANGULAR_VELOCITY, NOT_NEGATIVE).or(0.0);
        /// largest speed, above `slowest`
        "fastest": real(&unit::ANGULAR_VELOCITY, POSITIVE).or_text("as far as `tolerance` goes").also(&["speed"]);
        /// admissible deviation of the output
        "tolerance": own(0, POSITIVE).or_text("none; this or `fastest`").also(&["tol"]);
        /// `robust`: minimises the largest error over all angles and speeds (Chebyshev objectives); `recipe`: synthesises the
        /// motion and inverts it, with damping, at the most suitable speed; `none`: only analyses the profile
        "method": choice(&[&["robust"], &["recipe"], &["none"]]).usually("robust");
        /// admissible amplitude of a resonance kη = 1
        "admissible_amplitude": own(0, POSITIVE);
    }

    /// `[shaft]` of a task.
    SHAFT "`[shaft]`" {
        /// mass of the follower
        "m": real(&unit::MASS, POSITIVE).required().also(&["mass"]);
        /// moment of inertia of the cam
        "J": parameter::<elastic_shaft::Parameters>(1).also(&["inertia"]);
        /// stiffness of the shaft
        "c": parameter::<elastic_shaft::Parameters>(2).or_text(THIS_OR_FREQUENCY).also(&["stiffness"]);
        /// ω₀ = √(c/`J`) of the cam while the follower is at rest (U′ = 0), for any profile; in a scene ω₀ includes the follower
        "natural_frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE).also(&["w0"]);
        /// damping of the shaft
        "b": real(&unit::ROTATIONAL_DAMPING, POSITIVE).or_text("this or `damping_ratio`").also(&["damping"]);
        /// b / (2 `J` ω₀) with the same ω₀
        "damping_ratio": real(&unit::NUMBER, POSITIVE).also(&["D"]);
        /// least speed
        "slowest": real(&unit::ANGULAR_VELOCITY, POSITIVE).required();
        /// largest speed, above `slowest`
        "fastest": real(&unit::ANGULAR_VELOCITY, POSITIVE).required().also(&["speed"]);
        /// `peak`: the largest torque over angles and speeds; `rms`: its root mean square
        "norm": choice(&[&["peak"], &["rms"]]).usually("peak");
        /// `over_speed_squared`: M/(m Ω²), all speeds count alike; `absolute`: M, the highest speeds count most
        "torque": choice(&[&["over_speed_squared"], &["absolute"]]).usually("over_speed_squared");
    }
}
