//! The keys of scenes and tasks, each declared once: unit, range, default, meaning and other names. From here the readers take
//! them, the [reference](super::reference) its tables, and editors their completion by the [JSON Schema](super::schema).

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
    /// As the reference calls it.
    pub title: &'static str,
    /// Its keys, in the order of the reference.
    pub keys: &'static [Key],
    /// The table whose keys it has besides.
    pub with: Option<&'static KeyTable>,
}

/// A key of a table.
#[derive(Clone, Copy)]
pub struct Key {
    /// The key.
    pub key: &'static str,
    /// Its meaning, in Markdown.
    pub meaning: &'static str,
    /// The kinds of values that it admits.
    pub values: [Value; 3],
    /// The value where it is left out.
    pub usual: Usual,
    /// Names that people write for it by mistake.
    pub also: &'static [&'static str],
    /// Names of a choice that it no longer has, and what to write instead.
    pub gone: &'static [(&'static str, &'static str)],
    /// The models that have it; none for all.
    pub models: &'static [&'static str],
}

/// A kind of value.
#[derive(Clone, Copy)]
pub enum Value {
    /// None more.
    Nothing,
    /// A number, or a string with a unit.
    Real(Dimension, Limits),
    /// A word that stands where else a quantity does.
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
    /// A list of whatever the named variables take.
    Values,
    /// true or false.
    Flag,
    /// One of several names, the first of each list the usual one.
    Choice(&'static [&'static [&'static str]]),
    /// A table.
    Table(&'static KeyTable),
    /// A list of tables.
    Tables(&'static KeyTable),
    /// Tables with names that the user gives.
    Named(&'static KeyTable),
    /// Variables with their values.
    Variables,
}

/// The quantity of a number.
#[derive(Clone, Copy)]
pub enum Dimension {
    /// The same everywhere.
    Fixed(&'static Quantity),
    /// Of what moves along a line, and of what turns.
    Motion(&'static Quantity, &'static Quantity),
    /// The quantity of the section, U of a law, per radⁿ.
    Own(i32),
    /// One that depends on another key, as the meaning says.
    Other,
}

/// The value of a key that is left out.
#[derive(Clone, Copy)]
pub enum Usual {
    /// Nothing.
    Nothing,
    /// It must be there.
    Required,
    /// This number.
    Number(f64),
    /// This name.
    Name(&'static str),
    /// As the text says.
    Said(&'static str),
}

impl KeyTable {
    /// All keys, with those of the table behind it.
    pub fn all(&'static self) -> impl Iterator<Item = &'static Key> {
        std::iter::successors(Some(self), |table| table.with).flat_map(|table| table.keys)
    }

    /// The declaration of a key; the reader asks for declared ones only.
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

/// Of what moves along a line, or turns.
const fn moved(line: &'static Quantity, turn: &'static Quantity, limits: Limits) -> Key {
    value(Value::Real(Dimension::Motion(line, turn), limits))
}

/// One of these names.
const fn choice(names: &'static [&'static [&'static str]]) -> Key {
    value(Value::Choice(names))
}

/// Of the section's own quantity per radⁿ.
const fn own(n: i32, limits: Limits) -> Key {
    value(Value::Real(Dimension::Own(n), limits))
}

/// The `which`-th of a group of parameters of a drive.
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

    const fn said(self, text: &'static str) -> Self {
        Key { usual: Usual::Said(text), ..self }
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

    /// Another kind of value that it admits.
    const fn and(mut self, value: Value) -> Self {
        let next = if matches!(self.values[1], Value::Nothing) { 1 } else { 2 };
        self.values[next] = value;
        self
    }
}

/// Of a quantity that another key decides.
const fn other(limits: Limits) -> Key {
    value(Value::Real(Dimension::Other, limits))
}

macro_rules! tables {
    ($($(#[$doc:meta])* $table:ident $title:literal $(with $with:ident)? {
        $($(#[doc = $text:literal])+ $key:literal: $value:expr;)*
    })*) => {
        $($(#[$doc])* pub static $table: KeyTable = KeyTable {
            title: $title,
            keys: &[$(Key { key: $key, meaning: concat!($($text),+), ..$value }),*],
            with: tables!(@with $($with)?),
        };)*
    };
    (@with) => { None };
    (@with $with:ident) => { Some(&$with) };
}

const ELASTIC: &str = "ElasticCamDrive";
const BACKLASH: &str = "BacklashDrive";
const MACHINE: &str = "RigidMachine";
/// The model that has a machine or a drive.
pub const TRAIN: &str = "DriveTrain";
const PARAMETRIC: &str = "ParametricDrive";

/// Young's modulus (Pa) and Poisson's ratio of steel.
const STEEL: [f64; 2] = [210e9, 0.3];
/// α of teeth (rad), DIN 867.
const TOOTH_ANGLE: f64 = PI / 9.0;
/// The most harmonics of a profile: the source advises against more than nine, and cams of sixty-four can be made.
const MOST_HARMONICS: u32 = 64;
/// The highest harmonic of the stiffness that a scene may ask for; beyond it the whole function is cheaper.
const HIGHEST_OF_CRANK: u32 = 256;
/// The most samples of a study, and values of a series.
const MOST_RUNS: u32 = camdrive_design::study::plan::MOST_ROWS as u32;
/// The value of `ddU` where the laws beside a turning point decide it.
pub const FREE: &str = "free";

/// Angles of a cycle.
const REST_OF_TURN: &str = "one of four may be left out: the rest of the turn";
/// Lengths that fix the size of a cam.
const SIZE: &str = "one of these";
/// What replaces the sum of the squared errors, and the largest error, at points of a range.
const SQUARES: &str = "write `least_squares` without `points`: it looks at all angles";
const LARGEST: &str = "write `chebyshev` without `points`: it looks at all angles";
const THIS_OR_FREQUENCY: &str = "this or `natural_frequency`";

tables! {
    /// A scene.
    SCENE "every scene" {
        /// name of the FMU, its modelIdentifier: a C identifier of at most 24 characters, no device of Windows (`CON`, `COM1` …)
        "name": value(Value::Text).required().also(&["title"]);
        /// one sentence for the importer
        "description": value(Value::Text).said("a sentence about the model");
        /// the drive
        "model": choice(&[&["ElasticCamDrive"], &["BacklashDrive"], &["RigidMachine"], &["ParametricDrive"], &["DriveTrain"]]).required().also(&["type"]);
        /// the motion law U(φ)
        "cam": value(Value::Table(&LAW)).required().of(&[ELASTIC, BACKLASH]);
        /// the cam as a body, for `camdrive cam`
        "geometry": value(Value::Table(&GEOMETRY)).of(&[ELASTIC, BACKLASH]);
        /// what acts on the follower, of a ParametricDrive on the mass
        "load": value(Value::Table(&LOAD)).and(Value::Table(&PARAMETRIC_LOAD)).of(&[ELASTIC, BACKLASH, PARAMETRIC]);
        /// what bears the loads, for `camdrive forces`
        "forces": value(Value::Table(&FORCES)).of(&[ELASTIC, BACKLASH]);
        /// the motion of the cam shaft
        "drive": value(Value::Table(&DRIVE)).required().of(&[ELASTIC, BACKLASH, PARAMETRIC, TRAIN]);
        /// the elastic member
        "elasticity": value(Value::Table(&ELASTICITY)).required().of(&[ELASTIC]);
        /// the clearance
        "backlash": value(Value::Table(&CLEARANCE)).required().of(&[BACKLASH]);
        /// a parallel-crank drive
        "crank": value(Value::Table(&PARALLEL_CRANK)).said("this or `coefficients`").of(&[PARAMETRIC]);
        /// the coefficients of the equation
        "coefficients": value(Value::Table(&COEFFICIENTS)).said("this or `crank`").of(&[PARAMETRIC]);
        /// the shaft with its inertia
        "machine": value(Value::Table(&MACHINE_TABLE)).required().of(&[MACHINE, TRAIN]);
        /// the motor on the shaft
        "motor": value(Value::Table(&MOTOR)).of(&[MACHINE, TRAIN]);
        /// the tools on the shaft
        "follower": value(Value::Tables(&FOLLOWER)).of(&[MACHINE, TRAIN]).also(&["followers"]);
        /// names of the units that load the shaft, "NAME.tau" being the input of each instead of the only input "tau"
        "torques": value(Value::Texts).of(&[MACHINE, TRAIN]);
        /// inertia that other units and the shaft exchange
        "coupling": value(Value::Table(&EXCHANGE));
        /// where the motion begins
        "start": value(Value::Table(&START));
        /// how the FMU integrates
        "solver": value(Value::Table(&SOLVER));
    }

    /// `[solver]`.
    SOLVER "`[solver]`" {
        /// relative tolerance, 0 for the documented default of the model; only where it has an effect: a drive in closed form and a
        /// BacklashDrive at constant speed have none
        "tolerance": real(&unit::NUMBER, within(0.0, COARSEST_TOLERANCE)).or(0.0).also(&["tol"]);
        /// how internal steps are chosen: `adaptive` (the tolerance) or `fixed_cost` (equal steps of equal cost, for real-time
        /// hosts); only where the drive has the choice: nonlinear elastic shaft, elastic shaft and parametric drive on inputs, rigid
        /// machine whose motor is `none`, `kloss` or `input` without transmission and which has no loads
        "method": choice(&[&["adaptive"], &["fixed_cost"]]).usually("adaptive");
        /// internal step of `fixed_cost`, 0 for the documented default of the model
        "step_size": real(&unit::TIME, within(0.0, LONGEST_STEP_SIZE)).or(0.0);
    }

    /// `[coupling]`.
    EXCHANGE "`[coupling]`" {
        /// of a drive: the outputs J_load, dJ_load and tau_rest tell its torque tau = J_load φ̈ + ½ dJ_load φ̇² + tau_rest apart, with the
        /// inertia of what follows the shaft without slip (`m_roller` of an elastic output, m1 in contact, rigid followers); of a
        /// RigidMachine with the motor `none`, `kloss` or `input`, no transmission and no loads of its own: it has the inputs J_load,
        /// dJ_load and tau_rest instead of tau, of the only load (`true`) or of those in a list of names from `torques`
        "inertia": value(Value::Flag).and(Value::Texts);
    }

    /// `[drive]`.
    DRIVE "`[drive]`" {
        /// `constant` speed; `input`: the FMU has the inputs phi, w, a; `speed`: it has the input w alone and integrates phi
        "mode": choice(&[&["constant", "constant_speed"], &["input", "inputs"], &["speed"]]).usually("constant");
        /// angular velocity, for `constant`
        "speed": real(&unit::ANGULAR_VELOCITY, within(-FASTEST, FASTEST)).said("required").also(&["w", "rpm", "n"]);
        /// angle at the start, for `constant` and `speed`
        "phi_start": real(&unit::ANGLE, within(-LARGEST_ANGLE, LARGEST_ANGLE)).or(0.0).also(&["phi"]);
    }

    /// `[start]`, of all models together.
    START "`[start]`" {
        /// of cam drives `at_rest` relative to the cam, `given`, `steady_state`, or `equilibrium`, where the loads balance the
        /// spring, with a clearance only where they press m1 to a flank; of a RigidMachine `given` or `steady_state`; of a DriveTrain all but `given`
        "mode": choice(&[&["at_rest"], &["given"], &["steady_state", "periodic"], &["equilibrium"]]).said("`at_rest`, of a RigidMachine `given`");
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
        "J": parameter::<elastic_shaft::Parameters>(1).said("required").also(&["inertia"]);
        /// stiffness
        "c": parameter::<elastic_output::Parameters>(1).and(parameter::<elastic_shaft::Parameters>(2).values[0])
            .said(THIS_OR_FREQUENCY).also(&["stiffness", "k"]);
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
        /// working mass; with `s = "inf"` it may be 0 or left out, without `c` and `b`
        "m2": real(&unit::MASS, NOT_NEGATIVE).and(parameter::<backlash::Parameters>(1).values[0]).said("required").also(&["mass"]);
        /// stiffness between them
        "c": parameter::<backlash::Parameters>(2).said(THIS_OR_FREQUENCY).also(&["stiffness", "k"]);
        /// ω = √(c/m2), of the working mass while m1 is in contact
        "natural_frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE);
        /// damping between them
        "b": parameter::<backlash::Parameters>(3).also(&["damping", "d"]);
        /// D = b / (2 m2 ω), instead of `b`
        "damping_ratio": real(&unit::NUMBER, NOT_NEGATIVE).also(&["D"]);
        /// clearance, above 0 with loads; `"inf"`: there is no flank B, the follower may leave its cam, and a spring, gravity or a
        /// force of its load has to bring it back
        "s": parameter::<backlash::Parameters>(4).and(Value::Word("inf")).also(&["clearance"]);
        /// coefficient of restitution
        "e": parameter::<backlash::Parameters>(5).also(&["restitution"]);
    }

    /// A motion law.
    LAW "`[cam]`, and all other laws" {
        /// the kind of law
        "law": choice(&[&["fourier", "hs", "harmonic_series"], &["cycle", "standard_laws"], &["table", "points", "linear"], &["plan"], &["contour"]]).said("required; of loads `table`").also(&["type", "kind"]);
        /// `fourier`: the list [a₀, a₁, a₂ …] of at most 257
        "a": value(Value::Reals(Dimension::Own(0))).said("required").also(&["cos"]);
        /// `fourier`: the list [b₁, b₂ …] of at most 256: there is no b₀
        "b": value(Value::Reals(Dimension::Own(0))).also(&["sin"]);
        /// `fourier`, `table`: by which all values, then pure numbers, are multiplied; not 0
        "scale": own(0, ANY);
        /// `cycle`: lift from the lower to the upper dwell
        "stroke": own(0, LIFT).said("required").also(&["lift"]);
        /// `cycle`: U in the lower dwell
        "lower": own(0, LIFT).or(0.0);
        /// `cycle`: the law of the rise
        "rise_law": choice(&[&["simple_sine", "harmonic", "simple_harmonic"], &["inclined_sine", "bestehorn", "bestehorn_sine", "cycloidal"], &["polynomial_345", "poly345", "3-4-5", "polynomial_5"], &["polynomial_4567", "poly4567", "4-5-6-7", "polynomial_7"], &["modified_sine", "modsine"], &["modified_trapezoid", "modtrap", "modified_trapezoidal"]]).said("required");
        /// `cycle`: the law of the return
        "return_law": choice(&[&["simple_sine", "harmonic", "simple_harmonic"], &["inclined_sine", "bestehorn", "bestehorn_sine", "cycloidal"], &["polynomial_345", "poly345", "3-4-5", "polynomial_5"], &["polynomial_4567", "poly4567", "4-5-6-7", "polynomial_7"], &["modified_sine", "modsine"], &["modified_trapezoid", "modtrap", "modified_trapezoidal"]]).said("as `rise_law`");
        /// `cycle`: angle at which the rise starts
        "rise_start": real(&unit::ANGLE, within(-TAU, TAU)).or(0.0);
        /// `cycle`: angle of the rise; the four angles make 2π together
        "rise": real(&unit::ANGLE, within(LEAST_MOTION, TAU)).said(REST_OF_TURN);
        /// `cycle`: angle of the upper dwell
        "upper_dwell": real(&unit::ANGLE, within(0.0, TAU)).said(REST_OF_TURN).also(&["dwell"]);
        /// `cycle`: angle of the return
        "return": real(&unit::ANGLE, within(LEAST_MOTION, TAU)).said(REST_OF_TURN);
        /// `cycle`: angle of the lower dwell
        "lower_dwell": real(&unit::ANGLE, within(0.0, TAU)).said(REST_OF_TURN);
        /// `cycle`: where the acceleration of the rise changes sign, as part of its angle; a parameter of the FMU only where it is
        /// given
        "rise_inflection": real(&unit::NUMBER, within(INFLECTION[0], INFLECTION[1])).said("0.5").also(&["lambda"]);
        /// `cycle`: the same of the return
        "return_inflection": real(&unit::NUMBER, within(INFLECTION[0], INFLECTION[1])).said("0.5");
        /// `plan`: 2 to 100 points, ascending within one turn; the last may repeat the first one turn later
        "point": value(Value::Tables(&POINT)).said("required");
        /// `table`, `contour`: path from the folder of the scene
        "file": value(Value::Text).said("this or `points`").also(&["path", "csv"]);
        /// `table`: the points themselves, `[["0 deg", 0], ["90 deg", "20 mm"], …]`
        "points": value(Value::Pairs);
        /// `table`, `contour`: unit of the angles
        "angle_unit": value(Value::Text).said("`rad`, or that of `turn`; of a contour that of the heading");
        /// `table`: unit of the values
        "lift_unit": value(Value::Text).said("the coherent SI unit");
        /// `table`, `contour`: column of the angles, its number from 1 or its heading
        "angle_column": value(Value::Count(1, 1000)).and(Value::Text).said("1; of a contour 2");
        /// `table`: the distance of the angles where the file has none, only a value in each line; the first is at 0
        "angle_step": other(POSITIVE);
        /// `table`: column of the values
        "lift_column": value(Value::Count(1, 1000)).and(Value::Text).said("2");
        /// `contour`: unit of x and y, or of r
        "length_unit": value(Value::Text).said("that of the heading, or m").also(&["unit"]);
        /// `contour`: column of x, its number from 1 or its heading
        "x_column": value(Value::Count(1, 1000)).and(Value::Text).said("with the heading x, or 1");
        /// `contour`: column of y
        "y_column": value(Value::Count(1, 1000)).and(Value::Text).said("with the heading y, or 2");
        /// `contour`: instead of x and y the column of the distance from the centre of the cam, with that of the angle
        "r_column": value(Value::Count(1, 1000)).and(Value::Text).said("with the heading r, or 1");
        /// `table`: what one turn of the cam is in the column of the angles: `"720 deg"` of a crank, `4096` steps (a number without
        /// unit counts in the column as it stands), `"0.25 s"`, `"314 mm"`
        "turn": other(POSITIVE).said("2π rad");
        /// `table`: the part of the turn, as `turn` in the column of the angles, after which the law repeats: the table has one of
        /// several equal lobes; a whole part of the turn
        "period": other(POSITIVE).said("the turn");
        /// `table`: outside of the table the cam rests at the level of its first and last row
        "outside": choice(&[&["rest"]]).said("the table covers the turn or `period`");
        /// `table`: U between the points, see below
        "interpolation": choice(&[&["spline", "quintic_spline"], &["derivatives"], &["fourier"], &["linear"], &["monotone", "pchip"]])
            .said("`spline`; of forces, torques, inertia and coefficients `monotone`");
        /// `table`, `fourier`: the highest harmonic, at most half the number of points, and of points at unequal distances half a turn
        /// over the widest gap
        "harmonics": value(Value::Count(1, HIGHEST_HARMONIC as u32)).said("required");
        /// `table`, `contour`: standard deviation of the noise to remove from the lifts, or, as a length, from the points of the contour (of errors
        /// within ±δ it is δ/√3), or `"estimate"`
        "noise": own(0, POSITIVE).and(Value::Word("estimate"));
        /// `table`: wrong rows are left out, and a note names them
        "outliers": choice(&[&["drop"]]).said("wrong rows are refused");
    }

    /// `[[cam.point]]`.
    POINT "`[[cam.point]]`" {
        /// angle, at least 1e-3 beyond the point before
        "phi": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).required().also(&["angle"]);
        /// position
        "U": own(0, LIFT).required().also(&["u"]);
        /// velocity dU/dφ
        "dU": own(1, ANY).said("that of a `straight` segment beside the point, else 0").also(&["velocity"]);
        /// d²U/dφ², or `"free"` at a turning point: the laws and inflections on both sides determine one common value
        "ddU": own(2, ANY).and(Value::Word(FREE)).said("0").also(&["acceleration"]);
        /// d³U/dφ³, for a polynomial of degree 7
        "dddU": own(3, ANY).said("not prescribed").also(&["jerk"]);
        /// the law that leads to the point: a standard law as of a cycle, or one of plans
        "law": choice(&[&["simple_sine", "harmonic", "simple_harmonic"], &["inclined_sine", "bestehorn", "bestehorn_sine", "cycloidal"], &["polynomial_345", "poly345", "3-4-5", "polynomial_5"], &["polynomial_4567", "poly4567", "4-5-6-7", "polynomial_7"], &["modified_sine", "modsine"], &["modified_trapezoid", "modtrap", "modified_trapezoidal"], &["polynomial_6"], &["sine"], &["cosines"], &["straight"]]).said("see below").also(&["type", "kind"]);
        /// where the acceleration changes sign on the way to the point, as part of the angle; of `polynomial_6` 0.4 to 0.6
        "inflection": real(&unit::NUMBER, within(INFLECTION[0], INFLECTION[1])).said("0.5, or as `ddU` beside it requires").also(&["lambda"]);
    }

    /// `[geometry]`.
    GEOMETRY "`[geometry]`" {
        /// `lever`: oscillating roller lever; `translating`: roller on a slide; `flat`: flat-faced tappet on a slide
        "follower": choice(&[&["lever", "roller_lever", "oscillating", "rocker"], &["translating", "slider"], &["flat", "flat_faced"]]).required().also(&["type", "kind"]);
        /// radius of the roller
        "roller_radius": real(&unit::LENGTH, POSITIVE).said("required but of a flat face").also(&["roller"]);
        /// `inner`: disc, the roller runs on it; `outer`: ring, the roller runs in it; `groove`: both; `conjugate`: two discs F and
        /// P with a roller each
        "contour": choice(&[&["inner", "disc"], &["outer", "ring"], &["groove"], &["conjugate", "double"]]).usually("inner").also(&["cut"]);
        /// sense in which the cam turns while φ grows
        "rotation": choice(&[&["counterclockwise", "ccw", "left"], &["clockwise", "cw", "right"]]).usually("counterclockwise").also(&["sense", "direction"]);
        /// least radius of the inner contour, of a flat face its least height
        "base_radius": real(&unit::LENGTH, POSITIVE).said(SIZE).also(&["base_circle"]);
        /// least distance of the roller's centre from the cam's
        "prime_radius": real(&unit::LENGTH, POSITIVE).said(SIZE).also(&["prime_circle"]);
        /// of a lever: between arm and line pivot–cam centre where U = 0
        "start_angle": real(&unit::ANGLE, within(0.0, PI)).said(SIZE);
        /// of a translating follower: y of the roller's centre, or of the flat face, where U = 0
        "start_height": real(&unit::LENGTH, ANY).said(SIZE);
        /// of a lever: pivot to cam centre
        "pivot_distance": real(&unit::LENGTH, POSITIVE).said("required").also(&["pivot", "centre_distance", "center_distance"]);
        /// of a lever: pivot to roller's centre
        "arm_length": real(&unit::LENGTH, POSITIVE).said("required").also(&["arm", "lever_length"]);
        /// of a lever: travel of the tool per radian by which the arm moves away from the centre of the cam, negative where the tool
        /// moves the other way; where the law is the angle of a lever, radians of the law per radian of the arm; not 0
        "transmission": moved(&unit::LENGTH, &unit::NUMBER, ANY).said("`arm_length`; 1 for an angle");
        /// of a lever: side of the roller, seen from the centre of the cam towards the pivot
        "side": choice(&[&["left"], &["right"]]).usually("left");
        /// of a translating follower: x of its line
        "offset": real(&unit::LENGTH, ANY).or(0.0).also(&["eccentricity"]);
        /// for `conjugate`
        "second_roller_radius": real(&unit::LENGTH, POSITIVE).said("`roller_radius`");
        /// for `conjugate`, lever: between both arms, the line pivot–cam centre between them
        "second_arm_angle": real(&unit::ANGLE, within(0.0, 2.0 * PI)).said("required");
        /// for `conjugate`, lever
        "second_arm_length": real(&unit::LENGTH, POSITIVE).said("`arm_length`");
        /// for `conjugate`, translating: between both rollers' centres
        "roller_distance": real(&unit::LENGTH, POSITIVE).said("required");
        /// admissible pressure angle
        "max_pressure_angle": real(&unit::ANGLE, within(0.0, PI / 2.0)).said("45°, translating 30°").also(&["pressure_angle"]);
        /// of the tool that cuts or grinds concave parts; for a flat face that whose path is drawn
        "cutter_radius": real(&unit::LENGTH, NOT_NEGATIVE).said("`roller_radius`; of a flat face no path");
        /// of shaft and hub, into which a disc must not be cut
        "hub_radius": real(&unit::LENGTH, NOT_NEGATIVE).or(0.0);
    }

    /// `[load]`.
    LOAD "`[load]`" with ROLLER {
        /// P over the angle of the machine, negative for a resistance: a value, or a law
        "process": moved(&unit::FORCE, &unit::TORQUE, ANY).and(Value::Table(&LAW)).also(&["load"]);
        /// whether F is an input of the FMU
        "input": value(Value::Flag);
        /// the same but `process` and `input` for the mass on the cam's side: m1 of a backlash, `m_roller` of an elasticity
        "roller": value(Value::Table(&ROLLER)).also(&["mass"]);
    }

    /// `[load]` of a ParametricDrive.
    PARAMETRIC_LOAD "`[load]` of a ParametricDrive" with LOAD {
        /// of a crank: the list [a₀, a₁, a₂ …] of f(φ), the torque on the driven side, positive in the sense of φ
        "a": value(Value::Reals(Dimension::Own(0)));
        /// of a crank: the list [b₁, b₂ …]
        "b": value(Value::Reals(Dimension::Own(0)));
        /// of a crank: by which all coefficients, then pure numbers, are multiplied; not 0
        "scale": own(0, ANY);
    }

    /// `[load.roller]`.
    ROLLER "`[load]` and `[load.roller]`" {
        /// g; a tool that turns is taken as balanced
        "gravity": real(&unit::ACCELERATION, NOT_NEGATIVE).also(&["g"]);
        /// α: direction of gravity from that in which the tool moves for growing y; with mechanisms a list with an angle for each,
        /// from the x axis of its frame, of a rack from the direction of the tool: their links have weight too
        "gravity_angle": real(&unit::ANGLE, within(-TAU, TAU)).and(Value::Reals(Dimension::Fixed(&unit::ANGLE)))
            .said("180°, the weight presses on the cam; -90° for each mechanism");
        /// F₀
        "force": moved(&unit::FORCE, &unit::TORQUE, ANY).also(&["F0", "constant"]);
        /// the return spring
        "spring": value(Value::Table(&SPRING)).also(&["c"]);
        /// b to the ground
        "damping": moved(&unit::DAMPING, &unit::ROTATIONAL_DAMPING, NOT_NEGATIVE).also(&["b", "d"]);
    }

    /// `spring` of a load.
    SPRING "`spring`" {
        /// F_v, its force against the sense of y where y = `at`
        "preload": moved(&unit::FORCE, &unit::TORQUE, NOT_NEGATIVE).or(0.0).also(&["F_v"]);
        /// its stiffness c
        "c": moved(&unit::STIFFNESS, &unit::ROTATIONAL_STIFFNESS, NOT_NEGATIVE).or(0.0).also(&["stiffness"]);
        /// y₀
        "at": moved(&unit::LENGTH, &unit::ANGLE, ANY).said("the least y of the turn").also(&["y0"]);
    }

    /// `[forces]`.
    FORCES "`[forces]`" {
        /// moment of inertia of what turns with the lever, about its pivot
        "lever_J": real(&unit::INERTIA, NOT_NEGATIVE).or(0.0).also(&["J"]);
        /// pitch radius of the output wheel of a gear pair, for the force on its teeth; not needed for a rack
        "tooth_radius": real(&unit::LENGTH, POSITIVE).said("no tooth force");
        /// pressure angle of the teeth
        "tooth_angle": real(&unit::ANGLE, within(0.0, 0.25 * TAU - 0.01)).or(TOOTH_ANGLE);
        /// width of the contact of roller and cam, for the Hertzian pressure of a cylindrical roller; for cams with a geometry
        "roller_width": real(&unit::LENGTH, POSITIVE).said("no pressure").also(&["width"]);
        /// modulus of elasticity of the cam
        "E_cam": real(&units::PRESSURE, POSITIVE).or(STEEL[0]).also(&["E"]);
        /// of the roller
        "E_roller": real(&units::PRESSURE, POSITIVE).or(STEEL[0]);
        /// Poisson's ratio of the cam
        "nu_cam": real(&unit::NUMBER, within(0.0, 0.5)).or(STEEL[1]).also(&["nu"]);
        /// of the roller
        "nu_roller": real(&unit::NUMBER, within(0.0, 0.5)).or(STEEL[1]);
    }

    /// `[machine]`.
    MACHINE_TABLE "`[machine]`" {
        /// constant part of the moment of inertia
        "J0": real(&unit::INERTIA, POSITIVE).required().also(&["inertia"]);
        /// an addition that varies with φ: a law
        "J": value(Value::Table(&LAW));
        /// what brakes the shaft itself
        "load": value(Value::Table(&SHAFT_LOAD));
    }

    /// `[machine.load]`.
    SHAFT_LOAD "`[machine.load]`" {
        /// M_L over φ against the sense of φ: a value, or a law
        "torque": real(&unit::TORQUE, ANY).and(Value::Table(&LAW)).also(&["M"]);
        /// b_L: a torque b_L φ̇ against the motion
        "friction": real(&unit::ROTATIONAL_DAMPING, NOT_NEGATIVE).also(&["b", "damping"]);
        /// of a DriveTrain: whether the FMU has the input tau, positive brakes
        "input": value(Value::Flag);
    }

    /// `[[follower]]`.
    FOLLOWER "`[[follower]]`" {
        /// mass of a tool that moves along a line; with mechanisms it may be 0
        "m": real(&unit::MASS, NOT_NEGATIVE).said("required").also(&["mass"]);
        /// moment of inertia of a tool that turns, instead of `m`: its cam's law then is an angle
        "J": real(&unit::INERTIA, NOT_NEGATIVE).also(&["inertia"]);
        /// the law of the cam, of the lever before mechanisms
        "cam": value(Value::Table(&LAW)).said("required");
        /// instead of `cam`, with mechanisms: the law of the tool's position; that of the lever follows by inverse kinematics, to
        /// 1e-9 of the largest acceleration of the tool or better (`camdrive check` shows the error): a Fourier series for a
        /// Fourier series, else pieces of degree 5 that keep dwells and jumps of the acceleration
        "tool": value(Value::Table(&LAW));
        /// for `tool`: angle of the lever near which its motion begins, where two of its positions give the same position of the
        /// tool
        "lever_start": dimension(ParameterKind::Angle).or(0.0);
        /// instead of `cam`: the input link of the first mechanism turns with the shaft, at φ + `offset`; the tool must be where it
        /// was after each turn of the shaft
        "crank": value(Value::Table(&CRANK));
        /// the mechanisms between lever and tool, in this order
        "linkage": value(Value::Tables(&LINKAGE)).also(&["links", "mechanism", "mechanisms"]);
        /// of a DriveTrain: the elastic member instead of `m`
        "elasticity": value(Value::Table(&ELASTICITY));
        /// of a DriveTrain: the clearance instead of `m`
        "backlash": value(Value::Table(&CLEARANCE));
        /// as beside a cam
        "load": value(Value::Table(&LOAD));
        /// as beside a cam
        "geometry": value(Value::Table(&GEOMETRY));
        /// as beside a cam
        "forces": value(Value::Table(&FORCES));
    }

    /// `[follower.crank]`.
    CRANK "`[follower.crank]`" {
        /// angle of the input link where that of the shaft is 0
        "offset": real(&unit::ANGLE, within(-TAU, TAU)).or(0.0).also(&["e"]);
    }

    /// `[[follower.linkage]]`.
    LINKAGE "`[[follower.linkage]]`" {
        /// `four_bar`, `slider_crank` or `gear` (gear pair, belt, rack and pinion)
        "kind": choice(&[&["four_bar", "four-bar", "fourbar"], &["slider_crank", "slider-crank", "crank_slider"], &["gear", "belt", "rack"]]).required().also(&["type"]);
        /// the mechanism's own input angle where its drive is at 0
        "input_offset": dimension(ParameterKind::Angle).or(0.0);
        /// the mechanism's own output where what it drives is at 0
        "output_offset": moved(&unit::LENGTH, &unit::ANGLE, within(-1e4, 1e4)).or(0.0);
        /// sign of the root, that is which of its two positions the mechanism has
        "branch": choice(&[&["plus", "+"], &["minus", "-"]]).usually("plus").also(&["mode"]);
        /// g of a `four_bar`
        "ground": dimension(ParameterKind::Length).said("required").also(&["frame", "g"]);
        /// link a of a `four_bar`
        "input": value(Value::Table(&LINK)).said("required").also(&["a"]);
        /// link b of a `four_bar`
        "coupler": value(Value::Table(&LINK)).said("required").also(&["b"]);
        /// link c of a `four_bar`
        "output": value(Value::Table(&LINK)).said("required").also(&["c", "rocker"]);
        /// link r of a `slider_crank`
        "crank": value(Value::Table(&LINK)).said("required").also(&["r"]);
        /// link l of a `slider_crank`
        "rod": value(Value::Table(&LINK)).said("required").also(&["l", "connecting_rod"]);
        /// e of a `slider_crank`
        "offset": dimension(ParameterKind::Coordinate).or(0.0).also(&["e"]);
        /// mass of the slider of a `slider_crank` without the tool
        "slider_m": dimension(ParameterKind::Mass).or(0.0);
        /// i of a `gear` whose output turns; not 0
        "ratio": dimension(ParameterKind::Ratio).said("this or `radius`");
        /// i of a `gear` whose output moves along a line; only as the last mechanism; not 0
        "radius": dimension(ParameterKind::Radius);
        /// moment of inertia of what turns with the input of a `gear`
        "J": dimension(ParameterKind::Inertia).or(0.0).also(&["inertia"]);
    }

    /// A link.
    LINK "a link" {
        /// distance of the joints
        "length": dimension(ParameterKind::Length).required();
        /// mass
        "m": dimension(ParameterKind::Mass).or(0.0).also(&["mass"]);
        /// moment of inertia about the centre of mass
        "J": dimension(ParameterKind::Inertia).said("that of a slender bar, `m`·`length`²/12").also(&["inertia"]);
        /// centre of mass from the first joint along the line to the second
        "x": dimension(ParameterKind::Coordinate).said("in the middle");
        /// centre of mass to the left of this line
        "y": dimension(ParameterKind::Coordinate).or(0.0);
    }

    /// `[motor]`.
    MOTOR "`[motor]`" {
        /// `none`; `input`: the torque is an input; `constant`; `table`: a torque over the speed; `kloss`: asynchronous motor;
        /// `servo`: speed control with limited torque
        "kind": choice(&[&["none"], &["kloss", "asynchronous", "induction"], &["input", "torque"], &["constant"], &["table"], &["servo"]]).required().also(&["type"]);
        /// of `constant`
        "torque": real(&unit::TORQUE, within(-1e12, 1e12)).said("required").also(&["M"]);
        /// of `table`: 2 to 200 pairs of a speed and a torque, speeds ascending; monotone cubic between them, constant beyond them
        "points": value(Value::Pairs).said("this or `file`");
        /// of `table`: a file of the points
        "file": value(Value::Text).also(&["path", "csv"]);
        /// of a file: unit of the speeds
        "speed_unit": value(Value::Text).said("`rad/s`");
        /// of a file: unit of the torques
        "torque_unit": value(Value::Text).said("`N.m`");
        /// of a file: column of the speeds, its number from 1 or its heading
        "speed_column": value(Value::Count(1, 1000)).and(Value::Text).said("1");
        /// of a file: column of the torques
        "torque_column": value(Value::Count(1, 1000)).and(Value::Text).said("2");
        /// of `kloss`: breakdown torque
        "M_k": parameter::<Kloss>(0).said("required");
        /// of `kloss`: breakdown slip
        "s_k": parameter::<Kloss>(1).said("required");
        /// of `kloss`: synchronous speed, at least 1e-100 in size
        "w_s": parameter::<Kloss>(2).said("required").also(&["speed"]);
        /// of `kloss`: electrical time constant of the torque; a DriveTrain starts with the torque of its speed, a RigidMachine with
        /// 0, or `motor.M_start` of its FMU
        "lag": real(&unit::TIME, within(LAG[0], LAG[1])).said("none: the torque follows at once").also(&["time_constant", "dynamics"]);
        /// of `servo`: torque per deviation of the speed
        "K_p": real(&unit::ROTATIONAL_DAMPING, POSITIVE).said("required");
        /// of `servo`: torque per integral of the deviation
        "K_i": real(&unit::ROTATIONAL_STIFFNESS, NOT_NEGATIVE).or(0.0);
        /// of `servo`: rate by which the integral follows a limited torque
        "K_aw": real(&unit::RATE, NOT_NEGATIVE).said("`K_i`/`K_p`");
        /// of `servo`: largest torque
        "M_max": real(&unit::TORQUE, POSITIVE).said("required").also(&["limit"]);
        /// of `servo`: speed to keep: a value, `"input"`, or a table
        "w_ref": real(&unit::ANGULAR_VELOCITY, within(-FASTEST, FASTEST)).and(Value::Word("input")).and(Value::Table(&REFERENCE))
            .said("required").also(&["reference"]);
        /// of `servo`: gain of a position loop on top, for which w_ref is integrated, or φ_ref is an input too
        "K_v": real(&unit::RATE, POSITIVE);
        /// speed of the rotor over that of the shaft; negative where it turns the other way; not 0
        "ratio": real(&unit::NUMBER, within(-1e6, 1e6)).or(1.0).also(&["i"]);
        /// moment of inertia of the rotor, above 0 before a coupling or belt
        "J": real(&unit::INERTIA, NOT_NEGATIVE).or(0.0).also(&["inertia"]);
        /// of a DriveTrain: an elastic coupling between rotor and shaft
        "coupling": value(Value::Table(&COUPLING));
        /// of a DriveTrain, instead of a coupling: a belt, c = 2 EA/length · radius², linear up to the torque 2 · preload · radius
        /// that `check` prints
        "belt": value(Value::Table(&BELT));
    }

    /// `motor.w_ref`.
    REFERENCE "`motor.w_ref` as a table" with SERIES {
        /// frequency of a series over time
        "frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE).said("this or `ramp`").also(&["w", "nu"]);
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
        /// EA of each of both strands
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
        /// what q is: `rotation` (an angle) or `translation` (a length); it decides the units below
        "coordinate": choice(&[&["rotation", "angle"], &["translation", "length"]]).usually("rotation");
        /// m(φ): a number, a series `{ scale, a, b }` or another law, above 0 at every φ
        "m": moved(&unit::MASS, &unit::INERTIA, ANY).and(Value::Table(&LAW)).required().also(&["mass"]);
        /// c(φ)
        "c": moved(&unit::STIFFNESS, &unit::ROTATIONAL_STIFFNESS, ANY).and(Value::Table(&LAW)).required().also(&["stiffness", "k"]);
        /// b(φ)
        "b": moved(&unit::DAMPING, &unit::ROTATIONAL_DAMPING, ANY).and(Value::Table(&LAW)).said("0").also(&["damping", "d"]);
        /// D = b / (2 √(m c)) with the means of m and c, instead of `b`
        "damping_ratio": real(&unit::NUMBER, NOT_NEGATIVE).also(&["D"]);
        /// f(φ)
        "f": moved(&unit::FORCE, &unit::TORQUE, ANY).and(Value::Table(&LAW));
    }

    /// A series.
    SERIES "a series" {
        /// the list [a₀, a₁, a₂ …] of at most 257
        "a": value(Value::Reals(Dimension::Own(0))).said("required").also(&["cos"]);
        /// the list [b₁, b₂ …] of at most 256
        "b": value(Value::Reals(Dimension::Own(0))).also(&["sin"]);
        /// by which all coefficients, then pure numbers, are multiplied; not 0
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
        /// by which the second crank runs ahead
        "angle": real(&unit::ANGLE, within(-TAU, TAU)).or(FRAC_PI_2).also(&["offset"]);
        /// highest harmonic of c_T
        "harmonics": value(Value::Count(0, HIGHEST_OF_CRANK)).said("all: the closed form of c_T");
    }

    /// A study.
    STUDY "a study" {
        /// the scene, the system (TOML, .ssp) or the FMU of which it runs variants; the path counts from the folder of the study
        "scene": value(Value::Text).required();
        /// what is measured of outputs: `max |q|`, `rms force`, `count impacts` …
        "measures": value(Value::Texts).required().also(&["measure"]);
        /// how long it is measured
        "time": real(&unit::TIME, POSITIVE).said("this or `turns`");
        /// how many turns of the shaft it is measured
        "turns": real(&unit::NUMBER, POSITIVE).said("this or `time`");
        /// how long the drive runs before measuring begins: a time, or with `turns` a number of turns
        "settle": other(NOT_NEGATIVE).or(0.0);
        /// communication step of a system or an FMU
        "step": real(&unit::TIME, POSITIVE).said("that of the system or the FMU").also(&["step_size"]);
        /// error of an output between two points of the motion of a scene, relative to its largest magnitude
        "accuracy": real(&unit::NUMBER, within(1e-12, 1e-2)).or(1e-6).also(&["tolerance"]);
        /// a quantity that varies, or several; all listed ones are combined with each other
        "vary": value(Value::Tables(&VARY)).required();
        /// number of samples of all quantities that have a distribution
        "runs": value(Value::Count(1, MOST_RUNS)).also(&["samples"]);
        /// how they are drawn
        "design": choice(&[&["latin_hypercube", "lhs"], &["random", "monte_carlo"]]).usually("latin_hypercube");
        /// seed of the random numbers
        "seed": value(Value::Count(0, u32::MAX)).or(1.0);
    }

    /// `[[vary]]`.
    VARY "`[[vary]]`" {
        /// a variable of the FMU (`drive.w`, `cam.a[3]`), or a key of the scene (`elasticity.natural_frequency`,
        /// `follower[1].m`); of a system behind its part: `pusher.m`, `pusher.elasticity.natural_frequency`
        "name": value(Value::Text).said("this, `names` or `file`");
        /// several: with `values` they vary together, with a distribution each by itself
        "names": value(Value::Texts);
        /// a CSV file whose headings are such names, with a unit in brackets where cells have it: `drive.w [rpm]`
        "file": value(Value::Text);
        /// the values, each as it is written in a scene, or a single one; with `names` a list for each run
        "values": value(Value::Values).also(&["value"]);
        /// first value of a series, or the lower end of an even distribution
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
        /// names the SSP and its parameter set: as in a scene
        "name": value(Value::Text).required().also(&["title"]);
        /// end of the default experiment
        "stop": real(&unit::TIME, POSITIVE).required().also(&["stop_time", "time"]);
        /// communication step
        "step": real(&unit::TIME, POSITIVE).required().also(&["step_size", "h"]);
        /// what the parts tell each other at a communication point: `held`, values of the beginning of the step, as usual masters
        /// have it; `interpolated`, the machine first with extrapolated torque, then the drives, whose motion meets that of the machine
        /// at both ends of the step; `effective_inertia`, the same, and the machine takes the inertia of rigid loads for its own
        "exchange": choice(&[&["interpolated"], &["held", "jacobi"], &["effective_inertia"]]).usually("interpolated").gone(&[
            ("extrapolated", "write `interpolated`; `camdrive system --study` still compares them"),
            ("gauss_seidel", "write `interpolated`; `camdrive system --study` still compares them"),
        ]);
        /// how often `camdrive run` repeats an interpolated step with what the parts tell at its end; without it once, where the
        /// scenes of all parts are known, κ is at most 0.2 and the step is stable then
        "repeat": value(Value::Count(0, 10));
        /// the parts, each a table with a name of its own, `[part.machine]`: a C identifier of at most 24 characters
        "part": value(Value::Named(&PART)).required().also(&["parts"]);
        /// connections beside those of the shafts
        "connection": value(Value::Tables(&CONNECTION)).also(&["connections"]);
    }

    /// `[part.NAME]`.
    PART "`[part.NAME]`" {
        /// a scene; path from the folder of the system
        "scene": value(Value::Text).said("this or `fmu`");
        /// an FMU for Co-Simulation by FMI 2.0, of any tool
        "fmu": value(Value::Text).said("this or `scene`");
        /// the part on whose shaft this one sits: phi, w, a come from there, its torque goes there
        "shaft": value(Value::Text).also(&["on"]);
        /// i: its speed over that of the shaft, 1e-6 to 1e6, or negative; its torque acts i times on the shaft
        "ratio": real(&unit::NUMBER, ANY).or(1.0).also(&["i"]);
        /// its angle where that of the shaft is 0
        "offset": real(&unit::ANGLE, ANY).or(0.0).also(&["phase"]);
        /// parameters and inputs of its FMU that are set before the start: { w_start = "300 rpm" }; where the unit of an FMU is not SI, with a unit
        "start": value(Value::Variables);
    }

    /// `[[connection]]`.
    CONNECTION "`[[connection]]`" {
        /// an output, `part.variable`
        "from": value(Value::Text).required().also(&["source"]);
        /// an input; one that takes another unit of the same dimension gets the value in its own
        "to": value(Value::Text).required().also(&["target"]);
        /// by which the value is multiplied, not 0; of Reals only
        "factor": real(&unit::NUMBER, ANY).or(1.0).also(&["scale"]);
        /// what is added to it: a number in SI, or a text with its unit, which it must have where that of the input is not SI; of Reals only
        "offset": value(Value::Real(Dimension::Other, ANY)).or(0.0);
    }

    /// A task.
    TASK "a task" with TASK_LAW {
        /// names the files and the scene: as in a scene
        "name": value(Value::Text).required().also(&["title"]);
        /// one sentence
        "description": value(Value::Text);
        /// what is minimised
        "objective": choice(&[&["least_squares", "S1"], &["chebyshev", "S3", "minimax"], &["chebyshev_sum", "S5"], &["peak_acceleration"], &["mean_square_acceleration"], &["longest_dwell"], &["fewest_harmonics"], &["peak_torque", "torque"], &["shaft_torque"]]).required().also(&["goal", "criterion"]).gone(&[
            ("discrete_least_squares", SQUARES), ("S2", SQUARES), ("discrete_chebyshev", LARGEST), ("S4", LARGEST),
        ]);
        /// w₁ of the errors in U′ (rad; of sums of squares rad²); where it is given, the derivative of U in a range counts as
        /// prescribed
        "dU_weight": other(NOT_NEGATIVE).said("1 where U′ is prescribed");
        /// w₂ of the errors in U″ (rad²; of sums of squares rad⁴); likewise
        "ddU_weight": other(NOT_NEGATIVE).said("1 where U″ is prescribed");
        /// a length of which all U of the task are multiples
        "scale": real(&unit::LENGTH, POSITIVE).said("none: lengths").also(&["stroke"]);
        /// a scene whose `[cam]` is replaced; path from the folder of the task
        "scene": value(Value::Text);
        /// ε: Σ ∫ (e₀² + w₁ e₁² + w₂ e₂²) dφ ≤ ε over all ranges and dwells together, with their weights: a length squared over an
        /// angle, `"0.01 mm2.rad"`, `"0.5 mm2.deg"`, or without the angle `"0.01 mm2"`; with `scale` a number, `"1e-5 rad"` or `1e-5`;
        /// of the accelerations as objective
        "integral_tolerance": other(POSITIVE);
        /// of `longest_dwell`: the only `[[dwell]]` that grows, counted from 1
        "longest": value(Value::Count(1, 1000)).said("all, by one factor");
        /// of `peak_torque` and `shaft_torque`: number of starts of the search
        "starts": value(Value::Count(1, 1000)).or(8.0);
        /// seed of their random numbers
        "seed": value(Value::Count(0, u32::MAX)).or(1.0);
        /// several laws in one task, up to five
        "law": value(Value::Tables(&TASK_LAW)).also(&["laws"]);
        /// a bound of a sum of several laws
        "restriction": value(Value::Tables(&RESTRICTION)).also(&["restrictions"]);
        /// a distance that two tools keep
        "clearance": value(Value::Tables(&TOOL_CLEARANCE)).also(&["clearances"]);
        /// an elastic output member between cam and mass
        "elasticity": value(Value::Table(&TASK_ELASTICITY));
        /// of `shaft_torque`: the input shaft
        "shaft": value(Value::Table(&SHAFT));
    }

    /// `[[law]]` of a task.
    TASK_LAW "`[[law]]`" {
        /// the highest harmonic K
        "harmonics": value(Value::Count(1, MOST_HARMONICS)).said("required").also(&["K"]);
        /// symmetry of U: `none`, `even` (cosines only), `half_wave` (odd harmonics and the mean a₀: U(φ + 180°) − a₀ = −(U(φ) −
        /// a₀)), `even_half_wave` (both)
        "symmetry": choice(&[&["none"], &["even"], &["half_wave"], &["even_half_wave"]]).usually("none");
        /// of one of several laws: its name
        "name": value(Value::Text).said("required");
        /// of one of several laws: the weight of its errors
        "weight": real(&unit::NUMBER, POSITIVE).or(1.0);
        /// a prescribed motion
        "range": value(Value::Tables(&RANGE)).also(&["ranges"]);
        /// a prescribed rest
        "dwell": value(Value::Tables(&DWELL)).also(&["dwells"]);
        /// a prescribed point
        "point": value(Value::Tables(&TASK_POINT)).also(&["point_condition"]);
        /// a bound of U or of a derivative
        "bound": value(Value::Tables(&BOUND)).also(&["bounds"]);
    }

    /// What a range and a dwell have in common.
    EITHER "`[[range]]` and `[[dwell]]`" {
        /// first angle
        "from": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).said("required").also(&["start"]);
        /// last angle
        "to": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).said("required").also(&["end"]);
        /// weight in sums and maxima
        "weight": real(&unit::NUMBER, POSITIVE).or(1.0);
        /// the error of U must not exceed it, with any objective
        "tolerance": own(0, POSITIVE).also(&["tol"]);
        /// the same of U′
        "dU_tolerance": own(1, POSITIVE);
        /// the same of U″
        "ddU_tolerance": own(2, POSITIVE);
    }

    /// `[[range]]`.
    RANGE "`[[range]]`" with EITHER {
        /// U there: a number, or the list of the coefficients of a polynomial in φ − `from`
        "U": own(0, ANY).and(Value::Reals(Dimension::Own(0))).said("at least one of U, dU, ddU, target").also(&["u"]);
        /// U′ there
        "dU": own(1, ANY).and(Value::Reals(Dimension::Own(1))).also(&["U1"]);
        /// U″ there
        "ddU": own(2, ANY).and(Value::Reals(Dimension::Own(2))).also(&["U2"]);
        /// instead of `U`: a motion law as in `[cam]` of a scene over the turn. A table, whose angles without `period` are those of
        /// the turn, covers all of it, or, as a spline without `noise`, at least from `from` to `to`: a measured flank needs no rest
        /// of the turn
        "target": value(Value::Table(&TARGET));
    }

    /// `[range.target]`.
    TARGET "`target`" with LAW {
        /// angle to which the 360° of the law are mapped, from `from` on
        "period": real(&unit::ANGLE, within(1e-6, TAU));
    }

    /// `[[dwell]]`.
    DWELL "`[[dwell]]`" with EITHER {
        /// the middle of the rest, with `width` instead of `from` and `to`
        "centre": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).also(&["center"]);
        /// its angle
        "width": real(&unit::ANGLE, within(1e-6, TAU));
        /// where the follower rests
        "U": own(0, ANY).required().also(&["u"]);
    }

    /// `[[point]]` of a task.
    TASK_POINT "`[[point]]`" {
        /// angle
        "phi": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).required();
        /// U there, exactly
        "U": own(0, ANY).said("at least one of U, dU, ddU, dddU").also(&["u"]);
        /// U′ there
        "dU": own(1, ANY).also(&["U1"]);
        /// U″ there
        "ddU": own(2, ANY).also(&["U2"]);
        /// U‴ there
        "dddU": own(3, ANY).also(&["U3"]);
        /// makes it a point that is approximated, with this weight (of the square in sums, of the error in maxima)
        "weight": real(&unit::NUMBER, POSITIVE).said("holds exactly");
    }

    /// `[[bound]]`.
    BOUND "`[[bound]]`" {
        /// what is bounded
        "of": choice(&[&["U"], &["dU"], &["ddU"], &["dddU"]]).required();
        /// the lower bound, in the unit of what is bounded, or the list of the coefficients of a polynomial in φ − `from`
        "min": other(ANY).and(Value::Reals(Dimension::Other)).said("at least one of min, max, limit");
        /// the upper bound, likewise
        "max": other(ANY).and(Value::Reals(Dimension::Other));
        /// both sides
        "limit": other(POSITIVE);
        /// a motion law as in a range; the bounds are relative to its derivative of this order
        "target": value(Value::Table(&TARGET));
        /// first angle
        "from": real(&unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU)).said("the whole turn").also(&["start"]);
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
        /// a law, whose tool moves on a straight line, counted from 1
        "a": value(Value::Count(1, 5)).or(1.0);
        /// another one
        "b": value(Value::Count(1, 5)).or(2.0);
        /// [x, y] from tool b to tool a where both U are 0
        "offset": value(Value::Reals(Dimension::Own(0))).required();
        /// direction in which tool a moves with U
        "direction_a": real(&unit::ANGLE, within(-TAU, TAU)).or(0.0);
        /// that of tool b
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
        "fastest": real(&unit::ANGULAR_VELOCITY, POSITIVE).said("as far as `tolerance` goes").also(&["speed"]);
        /// admissible deviation of the output
        "tolerance": own(0, POSITIVE).said("none; this or `fastest`").also(&["tol"]);
        /// `robust`: the least largest error over all angles and speeds (Chebyshev objectives); `recipe`: the motion is synthesised
        /// and inverted, with damping, at the most suitable speed; `none`: the profile is only analysed
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
        "c": parameter::<elastic_shaft::Parameters>(2).said(THIS_OR_FREQUENCY).also(&["stiffness"]);
        /// ω₀ = √(c/`J`): that of the cam while the follower rests (U′ = 0), for any profile; that of a scene includes the follower
        "natural_frequency": real(&unit::ANGULAR_VELOCITY, POSITIVE).also(&["w0"]);
        /// damping of the shaft
        "b": real(&unit::ROTATIONAL_DAMPING, POSITIVE).said("this or `damping_ratio`").also(&["damping"]);
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
