//! The exchange between coupled FMUs from one communication point to the next, H later.
//!
//! | [`Exchange`] | order of the parts | an input over the step |
//! |---|---|---|
//! | `Held` | any | u(t) |
//! | `Extrapolated` | any | u(t) + u̇(t) s, u̇ an output derivative |
//! | `GaussSeidel` | drives before the shaft that moves them | u(t + H) of a part that has stepped, else u(t) |
//! | `Interpolated`, `EffectiveInertia` | shafts before the drives on them | the cubic through u and u̇ at both ends of a part that has stepped, else u(t) + u̇(t) s |
//!
//! A motion φ, φ̇, φ̈ is one signal: a drive gets the values at t and, if it is interpolated, the derivatives a⁽¹⁾, a⁽²⁾ of φ̈
//! with which φ and φ̇ meet the shaft's at t + H,
//!
//! φ + φ̇ H + φ̈ H²/2 + a⁽¹⁾ H³/6 + a⁽²⁾ H⁴/24 = φ(t + H),   φ̇ + φ̈ H + a⁽¹⁾ H²/2 + a⁽²⁾ H³/6 = φ̇(t + H).
//!
//! If all parts can restore their states, a step may be repeated: every part then takes all courses from the round before. With
//! loads on springs the order of the error rises by one to the cubic's, 4. With a rigid load it stays 2, with an error that
//! gets smaller with each repetition. For a load of κ times the inertia of the shaft, whose torque is a signal, repeated steps
//! are stable up to κ = 0.41 (once), 0.83 (twice), 0.58 (three times), 0.90, 0.68, 0.93; unrepeated ones up to 1.
//!
//! The inertia J of a load that the shaft includes in its own is J + J′ Δ + ½ J″ Δ² over the angle Δ, with its own derivative.
//! J″ is the value at t; for a drive that has stepped it is the one with which J, and so the energy of the load, meets its
//! value at t + H.
//!
//! For an FMU of another maker φ, φ̇, φ̈ are three inputs like any others: if it takes derivatives, it gets them for all three.
//! An FMU that refuses orders above 1 gets the straight line with the mean of each input over the step.
//!
//! After a step, a part that takes no derivatives of its inputs still has the inputs of t, and an FMU of another maker perhaps
//! the ends of lines: both get the inputs of t + H before their outputs are read. A torque that depends on φ̈ at once gives an
//! equation for φ̈, affine with the factor −κ, which is solved as such.
//!
//! Values are in coherent SI units, whatever the units of the FMUs.
//!
//! An output that an FMU declares as discrete, such as the mean over the last step `tau_mean`, is constant over a step. The
//! error of the torque over a step is its polynomial's, so held inputs have the order 1, extrapolated ones 2. It is the
//! difference in energy between shaft and drives, ∫ (τ of the shaft − τ of the drive) φ̇ dt, the [`Residual`].

use super::stability::Exchange;
use crate::host::{Host, ModelDescription, Unit, Variable};
use camdrive::drives::Fault;
use camdrive::drives::variable::{Kind, Variability};

/// An input = `factor` · output + `offset`. A port is a part and an index of its variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// The output.
    pub from: (usize, usize),
    /// The input.
    pub to: (usize, usize),
    /// In the units of both variables.
    pub factor: f64,
    /// In the unit of the input.
    pub offset: f64,
}

/// The difference in energy between shaft and drive (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// The parts: the shaft, the drive.
    pub parts: [usize; 2],
    /// Σ ∫ (τ of the shaft − τ of the drive) φ̇ dt.
    pub sum: f64,
    /// Σ of the magnitudes over the steps.
    pub gross: f64,
    /// Σ ∫ |τ φ̇| dt: the exchanged energy.
    pub exchanged: f64,
    /// The largest magnitude of a step, and when the step began (s).
    pub largest: [f64; 2],
    /// The order of `gross` in the step; 0 if the torque has impulses, for which it has no order.
    pub order: u32,
}

/// The work between a shaft and drives on it, whose torques reach it by connections or by way of other parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Balance {
    /// The part of the shaft.
    pub shaft: usize,
    /// The parts of the drives.
    pub drives: Vec<usize>,
    /// The parts that the torques pass.
    pub by: Vec<usize>,
    /// The energy that the drives take and the shaft gives, ∫ τ φ̇ dt on each side, in magnitudes of the steps (J).
    pub work: [f64; 2],
    /// Σ of the products of both, and of the squares of the first one (J²): their ratio is the share of the work that the shaft
    /// gives.
    products: [f64; 2],
    /// The index of the wire of φ̇ and the source of the torque, for each torque of the drives.
    taken: Vec<((usize, usize), usize)>,
    /// The wires of the torques on the shaft.
    given: Vec<usize>,
    /// The source of φ̇ of the shaft.
    speed: usize,
}

impl Balance {
    /// The share of the drives' work that the shaft gives; None if they take none.
    pub fn part(&self) -> Option<f64> {
        let [both, own] = self.products;
        (own > 0.0).then_some(both / own)
    }
}

/// An output with its first derivative (1/s), read at both ends of the step.
#[derive(Clone, Copy, Debug, Default)]
struct Source {
    ends: [[f64; 2]; 2],
}

/// The outputs of a part that others need.
#[derive(Debug, Default)]
struct Outputs {
    /// The sources of the Reals are the first ones of the part, from here on.
    first: usize,
    references: Vec<u32>,
    orders: Vec<i32>,
    values: Vec<f64>,
    /// The references of all of them.
    units: Vec<Unit>,
    /// True if the FMU provides their derivatives.
    derivatives: bool,
    /// The indices of the outputs of other types.
    others: Vec<usize>,
}

/// The way an input follows its source.
#[derive(Clone, Copy, Debug, PartialEq)]
enum InputCourse {
    Signal,
    /// A value that is constant within a step, such as the mean over the last one.
    Discrete,
    /// φ or φ̇ of a motion; φ̈ has the course.
    Motion,
    /// φ̈ of a motion, with the sources of φ and φ̇.
    Acceleration([usize; 2]),
    /// dJ/dφ of a load, with the sources of its J, of φ and of φ̇, and the ratio of its angle to the source's.
    InertiaSlope([usize; 3], f64),
}

/// A connection with the data of a step.
#[derive(Clone, Debug)]
struct Wire {
    source: usize,
    /// The part of the source.
    from: usize,
    /// The index of the input, and its reference if it is a Real.
    to: usize,
    reference: Option<u32>,
    /// The type of the input.
    unit: Unit,
    /// The factor between SI values, with the offset.
    factor: f64,
    offset: f64,
    course: InputCourse,
    /// True if the part of the source provides derivatives; otherwise slopes are differences between two points.
    is_smooth: bool,
    /// Value and derivatives of the source at the beginning of the last step.
    taken: [f64; 4],
}

impl Wire {
    fn new(connection: &Connection, source: usize, from: (&Variable, &ModelDescription), to: &Variable) -> Self {
        let (output, input) = (&from.0.unit, &to.unit);
        let factor = connection.factor * input.factor / output.factor;
        Wire {
            source,
            from: connection.from.0,
            to: connection.to.1,
            reference: is_real(to).then_some(to.reference),
            unit: input.clone(),
            factor,
            offset: input.to_si(connection.offset) - factor * output.offset,
            course: course(from.0, to),
            is_smooth: from.1.capabilities.output_derivatives > 0,
            taken: [0.0; 4],
        }
    }

    /// The value of the input, in its unit, from the source's value.
    fn input(&self, source: f64) -> f64 {
        self.unit.of_si(self.factor * source + self.offset)
    }
}

/// A shaft and a drive on it, by the indices of their wires: φ̇ of the motion, and the torque back.
#[derive(Clone, Copy, Debug)]
struct Power {
    speed: usize,
    torque: usize,
}

/// The inputs of a part.
#[derive(Debug, Default)]
struct Inputs {
    wires: Vec<Wire>,
    /// True if the part takes derivatives.
    derivatives: bool,
    /// True if φ, φ̇ and φ̈ are one motion to it, whose course φ̈ has.
    is_joint: bool,
    /// True if it refused derivatives of a higher order than 1.
    is_linear: bool,
    references: Vec<u32>,
    values: Vec<f64>,
    of: Vec<u32>,
    orders: Vec<i32>,
    derived: Vec<f64>,
}

impl Inputs {
    /// True if its outputs at the end of a step belong to the inputs there.
    fn follows(&self) -> bool {
        self.derivatives && self.is_joint
    }

    /// Computes the courses of its wires over a step of this length (s).
    fn follow(&mut self, sources: &[Source], stepped: &[bool], exchange: Exchange, step: f64) {
        for wire in self.wires.iter_mut() {
            wire.taken = polynomial(wire, sources, exchange, stepped[wire.from], step);
        }
        if self.derivatives && !self.is_joint && !matches!(exchange, Exchange::Held | Exchange::GaussSeidel) {
            part_motions(&mut self.wires);
        }
    }
}

/// A shaft and its drives that do not follow their inputs; their torques may depend on its φ̈ at once.
#[derive(Debug)]
struct Loop {
    shaft: usize,
    /// The source of φ̈.
    acceleration: usize,
    drives: Vec<usize>,
}

/// Coupled FMUs.
pub struct Coupling {
    names: Vec<String>,
    parts: Vec<Host>,
    places: Vec<(usize, usize)>,
    exchange: Exchange,
    /// The parts in the order of their steps.
    order: Vec<usize>,
    sources: Vec<Source>,
    outputs: Vec<Outputs>,
    inputs: Vec<Inputs>,
    /// True for parts that have stepped.
    stepped: Vec<bool>,
    /// True for parts that move others.
    leads: Vec<bool>,
    powers: Vec<(usize, usize, Power)>,
    loops: Vec<Loop>,
    residuals: Vec<Residual>,
    balances: Vec<Balance>,
    /// The number of repetitions of a step.
    repeats: u32,
}

/// The most rounds for the start values; a loop of a factor up to 0.97 settles in them.
const ROUNDS: usize = 1000;

/// Start values have settled if none changes by more than this part of itself or, if a sum of almost nothing leaves its
/// rounding, of its unit; both are far below the error of any step.
const SETTLED: f64 = 1e-12;

/// Over a smaller angle (rad) the curvature of an inertia is the one at its beginning: rounding would exceed a ten-thousandth
/// of J.
const LEAST_TURN: f64 = 1e-6;

/// A variable of a part.
fn variable(parts: &[Host], (part, place): (usize, usize)) -> &Variable {
    &parts[part].description().variables[place]
}

/// The outputs to read of each part, and the sources of connections in the order of reading.
fn outputs(parts: &[Host], connections: &[Connection]) -> (Vec<Outputs>, Vec<(usize, usize)>) {
    let (mut outputs, mut sources) = (Vec::new(), Vec::new());
    for part in 0..parts.len() {
        let mut used: Vec<usize> = connections.iter().filter(|c| c.from.0 == part).map(|c| c.from.1).collect();
        used.sort_unstable();
        used.dedup();
        // Reals first.
        used.sort_by_key(|place| !is_real(variable(parts, (part, *place))));
        let reals = used.iter().map(|place| variable(parts, (part, *place))).filter(|v| is_real(v));
        let references: Vec<u32> = reals.map(|v| v.reference).collect();
        outputs.push(Outputs {
            first: sources.len(),
            orders: vec![1; references.len()],
            values: vec![0.0; references.len()],
            references,
            units: used.iter().map(|place| variable(parts, (part, *place)).unit.clone()).collect(),
            derivatives: parts[part].description().capabilities.output_derivatives > 0,
            others: used.iter().copied().filter(|place| !is_real(variable(parts, (part, *place)))).collect(),
        });
        sources.extend(used.into_iter().map(|place| (part, place)));
    }
    (outputs, sources)
}

/// The inputs of a part, from these sources.
fn inputs_of(parts: &[Host], connections: &[Connection], sources: &[(usize, usize)], part: usize) -> Inputs {
    let own: Vec<&Connection> = connections.iter().filter(|c| c.to.0 == part).collect();
    let wires = own.iter().map(|c| {
        let source = sources.iter().position(|source| *source == c.from).unwrap_or_default();
        Wire::new(c, source, (variable(parts, c.from), parts[c.from.0].description()), variable(parts, c.to))
    });
    let mut inputs = Inputs { wires: wires.collect(), ..Inputs::default() };
    motions(&mut inputs.wires, |i| &variable(parts, own[i].to).about.name);
    inputs.derivatives = parts[part].description().capabilities.interpolates_inputs;
    inputs.is_joint = parts[part].is_own();
    // A step allocates nothing: φ̈ has two derivatives, a signal three.
    let room = inputs.wires.len();
    (inputs.references, inputs.values) = (Vec::with_capacity(room), Vec::with_capacity(room));
    (inputs.of, inputs.orders, inputs.derived) =
        (Vec::with_capacity(3 * room), Vec::with_capacity(3 * room), Vec::with_capacity(3 * room));
    inputs
}

impl Coupling {
    /// A system of these parts with their names, for faults; the connections lead from outputs to inputs. Each step is repeated
    /// `repeats` times.
    ///
    /// # Errors
    /// Shafts that move each other in a circle; parts that cannot repeat a step.
    pub fn new(
        parts: Vec<(String, Host)>,
        connections: &[Connection],
        exchange: Exchange,
        repeats: u32,
    ) -> Result<Self, Fault> {
        let (names, parts): (Vec<String>, Vec<Host>) = parts.into_iter().unzip();
        let count = parts.len();
        let cannot = |part: &usize| repeats > 0 && !parts[*part].description().capabilities.saves_states;
        if let Some(part) = (0..count).find(cannot) {
            let name = &names[part];
            return Err(Fault::new(format!(
                "part {name}: it cannot restore its state, so that no step can be repeated"
            ))
            .hint("repeat = 0"));
        }
        let variable = |of: (usize, usize)| variable(&parts, of);
        let (outputs, sources) = outputs(&parts, connections);
        let mut inputs: Vec<Inputs> = (0..count).map(|part| inputs_of(&parts, connections, &sources, part)).collect();
        inertias(&mut inputs, |source| &variable(sources[source]).about.name);
        let mut order = leaders_first(&inputs)?;
        if exchange == Exchange::GaussSeidel {
            order.reverse();
        }
        let powers: Vec<_> = (0..count).flat_map(|drive| powers(&inputs, &sources, &parts, drive)).collect();
        let is_torque = |port: (usize, usize)| is_torque(&variable(port).about.name);
        let balances = (0..count).flat_map(|shaft| balances(&inputs, &sources, shaft, is_torque)).collect();
        let loops = (0..count).filter_map(|shaft| loop_of(&inputs, shaft)).collect();
        let residual = |(shaft, drive, power): &(usize, usize, Power)| {
            let order = match (exchange, inputs[*shaft].wires[power.torque].course) {
                (_, InputCourse::Discrete) => 0,
                (Exchange::Held | Exchange::GaussSeidel, _) => 1,
                // Repeated steps have a higher order only with springs.
                _ => 2,
            };
            Residual { parts: [*shaft, *drive], order, ..Residual::default() }
        };
        let of_part = |part: usize| (0..parts[part].description().variables.len()).map(move |place| (part, place));
        Ok(Coupling {
            places: (0..count).flat_map(of_part).collect(),
            residuals: powers.iter().map(residual).collect(),
            sources: vec![Source::default(); sources.len()],
            stepped: vec![false; count],
            leads: (0..count)
                .map(|part| inputs.iter().flat_map(|of| &of.wires).any(|wire| moves(wire, part)))
                .collect(),
            names,
            parts,
            exchange,
            order,
            outputs,
            inputs,
            powers,
            loops,
            balances,
            repeats,
        })
    }

    /// True if something is connected to this variable of a part.
    pub fn is_connected(&self, part: usize, place: usize) -> bool {
        self.inputs[part].wires.iter().any(|wire| wire.to == place)
    }

    /// A system of one FMU without connections.
    ///
    /// # Errors
    /// The errors of [`Coupling::new`].
    pub fn alone(name: &str, host: Host) -> Result<Self, Fault> {
        Coupling::new(vec![(name.to_owned(), host)], &[], Exchange::Held, 0)
    }

    /// The name of a part.
    pub fn name(&self, part: usize) -> &str {
        &self.names[part]
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// The model description of a part.
    pub fn description(&self, part: usize) -> &ModelDescription {
        self.parts[part].description()
    }

    /// The part of a variable and its index there; variables are counted through all parts.
    pub fn place(&self, variable: usize) -> (usize, usize) {
        self.places[variable]
    }

    /// True if a part ended the simulation itself.
    pub fn has_ended(&self) -> bool {
        self.parts.iter().any(|part| part.has_ended())
    }

    /// The parts.
    pub fn parts(&mut self) -> &mut [Host] {
        &mut self.parts
    }

    /// The differences in energy between shafts and drives so far.
    pub fn residuals(&self) -> &[Residual] {
        &self.residuals
    }

    /// The work of drives and their shafts so far.
    pub fn balances(&self) -> &[Balance] {
        &self.balances
    }

    /// Begins the initialisation of all parts at `time` (s); their start values have been set, inputs may be.
    ///
    /// # Errors
    /// The faults of a part.
    pub fn begin(&mut self, time: f64, stop: Option<f64>) -> Result<(), Fault> {
        for part in 0..self.parts.len() {
            let host = &mut self.parts[part];
            let tolerance = host.description().experiment.tolerance;
            let begun = host.set_up(time, stop, tolerance).and_then(|()| host.enter_initialization());
            self.of(part, begun)?;
        }
        Ok(())
    }

    /// Ends the initialisation: values go round until they settle, so that each part begins with the others' values.
    ///
    /// # Errors
    /// The faults of a part, and values that do not settle.
    pub fn start(&mut self) -> Result<(), Fault> {
        let mut rounds = 0;
        loop {
            let settled = self.go_round()?;
            if settled {
                break;
            }
            rounds += 1;
            if rounds == ROUNDS {
                let message = format!("the start values of the connections do not settle in {ROUNDS} rounds");
                return Err(Fault::new(format!("{message}: a loop of inertias in which the loads exceed the shaft's"))
                    .hint("exchange = \"effective_inertia\" takes rigid loads out of the loop"));
            }
        }
        for part in 0..self.parts.len() {
            let ended = self.parts[part].exit_initialization();
            self.of(part, ended)?;
        }
        (0..self.parts.len()).try_for_each(|part| self.read(part))?;
        self.sources.iter_mut().for_each(|source| source.ends[0] = source.ends[1]);
        for balance in &mut self.balances {
            (balance.work, balance.products) = ([0.0; 2], [0.0; 2]);
        }
        for residual in &mut self.residuals {
            *residual = Residual { parts: residual.parts, order: residual.order, ..Residual::default() };
        }
        Ok(())
    }

    /// Each part takes the others' values and gives its own; returns whether all equal the round before.
    fn go_round(&mut self) -> Result<bool, Fault> {
        let mut settled = true;
        for at in 0..self.order.len() {
            let part = self.order[at];
            let Coupling { inputs, sources, parts, .. } = self;
            for wire in &inputs[part].wires {
                parts[part].set(wire.to, wire.input(sources[wire.source].ends[1][0]))?;
            }
            let Outputs { first, references, others, .. } = &self.outputs[part];
            let range = *first..*first + references.len() + others.len();
            self.sources[range.clone()].iter_mut().for_each(|source| source.ends[0] = source.ends[1]);
            self.read_values(part)?;
            settled &= self.sources[range].iter().all(|Source { ends: [[before, _], [after, _]] }| {
                (after - before).abs() <= SETTLED * after.abs().max(before.abs()).max(1.0)
            });
        }
        Ok(settled)
    }

    /// Steps from the communication point `time` to the point `step` later (s).
    ///
    /// # Errors
    /// The faults of a part.
    pub fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.stepped.fill(false);
        for round in 0..=self.repeats {
            if self.repeats > 0 {
                let again = |part: &mut Host| if round == 0 { part.save() } else { part.restore() };
                self.parts.iter_mut().try_for_each(again)?;
            }
            self.round(time, step)?;
        }
        self.weigh(time, step);
        self.balance(step);
        self.sources.iter_mut().for_each(|source| source.ends[0] = source.ends[1]);
        Ok(())
    }

    /// Ends the simulation of all parts and frees them; they are unusable afterwards. Returns the refusals of parts that still
    /// run, which do not affect the results.
    ///
    /// # Errors
    /// A part whose process is gone.
    pub fn end(&mut self) -> Result<Vec<Fault>, Fault> {
        let mut refusals = Vec::new();
        for part in 0..self.parts.len() {
            let host = &mut self.parts[part];
            let ended = host.terminate().and_then(|()| host.free());
            match self.of(part, ended) {
                Err(fault) if fault.is_loss => return Err(fault),
                ended => refusals.extend(ended.err()),
            }
        }
        Ok(refusals)
    }

    /// A result of a part; a fault gets its name.
    fn of<T>(&self, part: usize, result: Result<T, Fault>) -> Result<T, Fault> {
        let name = &self.names[part];
        result.map_err(|fault| if name.is_empty() { fault } else { fault.within(format_args!("part {name}")) })
    }

    /// One step of each part.
    fn round(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        for at in 0..self.order.len() {
            let part = self.order[at];
            let inputs = &mut self.inputs[part];
            inputs.follow(&self.sources, &self.stepped, self.exchange, step);
            let given = give(inputs, &mut self.parts[part], step);
            self.of(part, given)?;
            let interpolates = matches!(self.exchange, Exchange::Interpolated | Exchange::EffectiveInertia);
            if interpolates && self.leads[part] && !self.stepped[part] {
                // φ̈ with the torque of this step, not of the one before: otherwise loops of more than 0.13 of the inertia
                // grow.
                self.read_values(part)?;
                let Outputs { first, references, .. } = &self.outputs[part];
                let own = &mut self.sources[*first..*first + references.len()];
                own.iter_mut().for_each(|source| source.ends[0][0] = source.ends[1][0]);
            }
            let stepped = self.parts[part].do_step(time, step);
            self.of(part, stepped)?;
            self.read(part)?;
            self.stepped[part] = true;
            self.differences(part, step);
            if interpolates {
                self.stand(part, step)?;
            }
        }
        (0..self.parts.len()).try_for_each(|part| self.stand(part, step))?;
        (0..self.loops.len()).try_for_each(|at| self.meet(at, step))
    }

    /// Gives a part that does not follow its inputs the inputs of the end of the step, as far as known, and reads its outputs.
    fn stand(&mut self, part: usize, step: f64) -> Result<(), Fault> {
        if self.inputs[part].follows() || self.inputs[part].wires.is_empty() {
            return Ok(());
        }
        self.renew(part)?;
        self.differences(part, step);
        Ok(())
    }

    /// Gives a part the others' values at the end of the step, and reads its outputs.
    fn renew(&mut self, part: usize) -> Result<(), Fault> {
        let Coupling { inputs, sources, parts, stepped, .. } = self;
        for wire in inputs[part].wires.iter().filter(|wire| stepped[wire.from]) {
            parts[part].set(wire.to, wire.input(sources[wire.source].ends[1][0]))?;
        }
        let read = self.read_values(part);
        self.of(part, read)
    }

    /// Solves for φ̈ of a shaft and the torques on it at the end of a step: two rounds determine the affine function, and its
    /// fixed point is the solution.
    fn meet(&mut self, at: usize, step: f64) -> Result<(), Fault> {
        let acceleration = self.loops[at].acceleration;
        let mut told = [self.sources[acceleration].ends[1][0]; 3];
        for round in 1..=told.len() {
            for drive in 0..self.loops[at].drives.len() {
                self.renew(self.loops[at].drives[drive])?;
            }
            self.renew(self.loops[at].shaft)?;
            let own = &mut self.sources[acceleration].ends[1][0];
            if let Some(next) = told.get_mut(round) {
                *next = *own;
            }
            if round == 2 {
                let [first, second, third] = told;
                let met = first - (second - first) * (second - first) / (third - 2.0 * second + first);
                *own = if met.is_finite() { met } else { third };
            }
        }
        self.differences(self.loops[at].shaft, step);
        for drive in 0..self.loops[at].drives.len() {
            self.differences(self.loops[at].drives[drive], step);
        }
        Ok(())
    }

    /// Reads the outputs of a part with their derivatives.
    fn read(&mut self, part: usize) -> Result<(), Fault> {
        self.read_values(part)?;
        let Outputs { first, references, orders, values, units, derivatives, .. } = &mut self.outputs[part];
        if *derivatives && !references.is_empty() {
            self.parts[part].get_output_derivatives(references, orders, values)?;
            if values.iter().any(|value| !value.is_finite()) {
                // It declares derivatives and has none.
                *derivatives = false;
                let wires = self.inputs.iter_mut().flat_map(|inputs| &mut inputs.wires);
                wires.filter(|wire| wire.from == part).for_each(|wire| wire.is_smooth = false);
                return Ok(());
            }
            for ((source, value), unit) in self.sources[*first..].iter_mut().zip(values).zip(units) {
                source.ends[1][1] = unit.factor * *value;
            }
        }
        Ok(())
    }

    fn read_values(&mut self, part: usize) -> Result<(), Fault> {
        let Outputs { first, references, values, units, others, .. } = &mut self.outputs[part];
        if !references.is_empty() {
            self.parts[part].get_reals(references, values)?;
        }
        for ((source, value), unit) in self.sources[*first..].iter_mut().zip(values.iter()).zip(units) {
            source.ends[1][0] = unit.to_si(*value);
        }
        for (source, place) in self.sources[*first + references.len()..].iter_mut().zip(others.iter()) {
            source.ends[1][0] = self.parts[part].get(*place)?;
        }
        Ok(())
    }

    /// The slopes of the outputs of a part that does not provide them, at the end of a step of this length (s).
    fn differences(&mut self, part: usize, step: f64) {
        let Outputs { first, references, derivatives, .. } = &self.outputs[part];
        if *derivatives {
            return;
        }
        for source in &mut self.sources[*first..*first + references.len()] {
            source.ends[1][1] = (source.ends[1][0] - source.ends[0][0]) / step;
        }
    }

    /// Adds a step to the balances.
    fn balance(&mut self, step: f64) {
        let Coupling { inputs, sources, balances, .. } = self;
        let over = |source: usize, is_held: bool| {
            let [start, end] = sources[source].ends;
            if is_held { [end[0]; 3] } else { [start[0], middle(start, end, step), end[0]] }
        };
        for balance in balances {
            // Simpson's rule; the wire is the first torque's.
            let work = |Wire { factor, offset, .. }: &Wire, wired: [f64; 3], other: [f64; 3]| -> f64 {
                let powers = wired.into_iter().zip(other).map(|(wired, other)| (factor * wired + offset) * other);
                powers.zip([1.0, 4.0, 1.0]).map(|(power, weight)| weight * step / 6.0 * power).sum()
            };
            let is_held = |torque: usize| {
                let mut wires = inputs.iter().flat_map(|of| &of.wires);
                wires.any(|wire| wire.source == torque && wire.course == InputCourse::Discrete)
            };
            let speeds = over(balance.speed, false);
            let of_drive = |&((drive, place), torque): &((usize, usize), usize)| {
                work(&inputs[drive].wires[place], speeds, over(torque, is_held(torque)))
            };
            let of_shaft = |place: &usize| {
                let wire = &inputs[balance.shaft].wires[*place];
                work(wire, over(wire.source, wire.course == InputCourse::Discrete), speeds)
            };
            let taken: f64 = balance.taken.iter().map(of_drive).sum();
            let given: f64 = balance.given.iter().map(of_shaft).sum();
            balance.work = [balance.work[0] + taken.abs(), balance.work[1] + given.abs()];
            balance.products = [balance.products[0] + taken * given, balance.products[1] + taken * taken];
        }
    }

    /// Adds a step to the residuals.
    fn weigh(&mut self, time: f64, step: f64) {
        let Coupling { inputs, sources, powers, residuals, .. } = self;
        for ((shaft, drive, power), residual) in powers.iter().zip(residuals) {
            let (torque, speed) = (&inputs[*shaft].wires[power.torque], &inputs[*drive].wires[power.speed]);
            let taken = torque.taken;
            let [[w0, a0], [w1, a1]] = sources[speed.source].ends;
            let [[own0, rate0], [own1, rate1]] = sources[torque.source].ends;
            let own = match torque.course {
                InputCourse::Discrete => [own1; 3],
                _ => [own0, middle([own0, rate0], [own1, rate1], step), own1],
            };
            let at = |s: f64| taken[0] + s * (taken[1] + s / 2.0 * (taken[2] + s / 3.0 * taken[3]));
            let speeds = [w0, middle([w0, a0], [w1, a1], step), w1];
            let mut sums = [0.0; 2];
            // Simpson's rule.
            for (((w, own), s), weight) in speeds.into_iter().zip(own).zip([0.0, step / 2.0, step]).zip([1.0, 4.0, 1.0])
            {
                let weight = weight * step / 6.0 * torque.factor;
                sums[0] += weight * (at(s) - own) * w;
                sums[1] += (weight * own * w).abs();
            }
            residual.sum += sums[0];
            residual.gross += sums[0].abs();
            residual.exchanged += sums[1];
            if sums[0].abs() > residual.largest[0] {
                residual.largest = [sums[0].abs(), time];
            }
        }
    }
}

/// Sets the inputs of a part to the courses of its wires over a step of this length (s).
fn give(inputs: &mut Inputs, part: &mut Host, step: f64) -> Result<(), Fault> {
    let Inputs { wires, derivatives, is_linear, references, values, of, orders, derived, .. } = inputs;
    [&mut *values, &mut *derived].into_iter().for_each(Vec::clear);
    [&mut *references, &mut *of].into_iter().for_each(Vec::clear);
    orders.clear();
    for wire in wires.iter() {
        let [value, mut rest @ ..] = wire.taken;
        if *is_linear {
            // The straight line of the same mean.
            rest = [2.0 / step * (mean(value, rest, step) - value), 0.0, 0.0];
        }
        let Some(reference) = wire.reference else {
            part.set(wire.to, wire.input(value))?;
            continue;
        };
        let start = match *derivatives || matches!(wire.course, InputCourse::Motion | InputCourse::Acceleration(_)) {
            true => value,
            // An input without derivatives takes the mean over the step.
            false => mean(value, rest, step),
        };
        references.push(reference);
        values.push(wire.input(start));
        for (order, rate) in (1..).zip(rest).filter(|(_, rate)| *derivatives && *rate != 0.0) {
            of.push(reference);
            orders.push(order);
            derived.push(wire.factor * rate / wire.unit.factor);
        }
    }
    if !references.is_empty() {
        part.set_reals(references, values)?;
    }
    if of.is_empty() {
        return Ok(());
    }
    match part.set_input_derivatives(of, orders, derived) {
        // The model description does not say which orders an FMU takes.
        Err(_) if orders.iter().any(|order| *order > 1) => {
            *is_linear = true;
            give(inputs, part, step)
        }
        given => given,
    }
}

/// Gives φ and φ̇ of each motion their derivatives, from φ̈ and its derivatives.
fn part_motions(wires: &mut [Wire]) {
    for at in 0..wires.len() {
        let InputCourse::Acceleration([phi, w]) = wires[at].course else { continue };
        let [a, first, second, _] = wires[at].taken;
        let is = |wire: &Wire, source: usize| wire.course == InputCourse::Motion && wire.source == source;
        let speed = wires.iter().find(|wire| is(wire, w)).map_or(0.0, |wire| wire.taken[0]);
        for wire in wires.iter_mut() {
            if is(wire, phi) {
                wire.taken[1..].copy_from_slice(&[speed, a, first]);
            } else if is(wire, w) {
                wire.taken[1..].copy_from_slice(&[a, first, second]);
            }
        }
    }
}

/// The mean of a polynomial with these derivatives over a step.
fn mean(value: f64, derivatives: [f64; 3], step: f64) -> f64 {
    let [first, second, third] = derivatives;
    value + step / 2.0 * (first + step / 3.0 * (second + step / 4.0 * third))
}

fn is_real(variable: &Variable) -> bool {
    matches!(variable.about.kind, Kind::Real { .. })
}

/// The way an input follows an output, except motions.
fn course(from: &Variable, to: &Variable) -> InputCourse {
    let is_discrete = !is_real(from) || !is_real(to) || from.about.variability == Variability::Discrete;
    if is_discrete { InputCourse::Discrete } else { InputCourse::Signal }
}

/// Two ratios that differ by a smaller part are equal: model descriptions have factors of units with a few digits only.
pub const SAME_RATIO: f64 = 1e-6;

/// Joins wires to the inputs φ, φ̇, φ̈ of one part: those named phi, w, a, after the same prefix, that come from one part with
/// one ratio.
fn motions<'a>(wires: &mut [Wire], name: impl Fn(usize) -> &'a String) {
    for a in 0..wires.len() {
        let Some(prefix) = name(a).strip_suffix('a').filter(|prefix| prefix.is_empty() || prefix.ends_with('.')) else {
            continue;
        };
        let find = |last: &str| {
            let is = |i: &usize| name(*i).strip_prefix(prefix) == Some(last);
            let ratio = wires[a].factor;
            let is_same = |other: f64| (other - ratio).abs() <= SAME_RATIO * ratio.abs();
            let fits = |i: &usize| wires[*i].from == wires[a].from && is_same(wires[*i].factor);
            (0..wires.len()).find(is).filter(fits)
        };
        if let (Some(phi), Some(w)) = (find("phi"), find("w")) {
            wires[a].course = InputCourse::Acceleration([wires[phi].source, wires[w].source]);
            wires[phi].course = InputCourse::Motion;
            wires[w].course = InputCourse::Motion;
        }
    }
}

/// Finds the sources of the slopes of inertias: the outputs dJ_load of drives that also have J_load.
fn inertias<'a>(inputs: &mut [Inputs], name: impl Fn(usize) -> &'a String) {
    let motion = |inputs: &[Inputs], drive: usize| {
        inputs[drive].wires.iter().find_map(|wire| match wire.course {
            InputCourse::Acceleration([phi, w]) => Some((phi, w, wire.factor)),
            _ => None,
        })
    };
    for shaft in 0..inputs.len() {
        for i in 0..inputs[shaft].wires.len() {
            let wires = &inputs[shaft].wires;
            let (from, own) = (wires[i].from, name(wires[i].source));
            let Some(prefix) = own.strip_suffix("dJ_load") else { continue };
            let is_inertia =
                |wire: &&Wire| wire.from == from && name(wire.source).strip_prefix(prefix) == Some("J_load");
            if let (Some(inertia), Some((phi, w, ratio))) = (wires.iter().find(is_inertia), motion(inputs, from)) {
                inputs[shaft].wires[i].course = InputCourse::InertiaSlope([inertia.source, phi, w], ratio);
            }
        }
    }
}

/// True if a part moves another by this wire.
fn moves(wire: &Wire, part: usize) -> bool {
    wire.from == part && matches!(wire.course, InputCourse::Acceleration(_))
}

/// The loop of a shaft, if any.
fn loop_of(inputs: &[Inputs], shaft: usize) -> Option<Loop> {
    let motion = |drive: &usize| inputs[*drive].wires.iter().find(|wire| moves(wire, shaft));
    let acts = |drive: usize| inputs[shaft].wires.iter().any(|wire| wire.from == drive);
    let drives = (0..inputs.len()).filter(|i| !inputs[*i].follows() && acts(*i) && motion(i).is_some());
    let drives: Vec<usize> = drives.collect();
    let acceleration = motion(drives.first()?)?.source;
    Some(Loop { shaft, acceleration, drives })
}

/// The parts, each before those that it moves; otherwise in their own order.
fn leaders_first(inputs: &[Inputs]) -> Result<Vec<usize>, Fault> {
    let mut order = Vec::new();
    while order.len() < inputs.len() {
        let is_free = |part: &usize| {
            let waits = |wire: &Wire| moves(wire, wire.from) && !order.contains(&wire.from);
            !order.contains(part) && !inputs[*part].wires.iter().any(waits)
        };
        let Some(next) = (0..inputs.len()).find(is_free) else {
            return Err(Fault::new("parts move each other in a circle".to_owned()));
        };
        order.push(next);
    }
    Ok(order)
}

/// True if a variable is the torque of a drive.
fn is_torque(name: &str) -> bool {
    matches!(name.rsplit('.').next(), Some("tau" | "tau_mean" | "tau_rest"))
}

/// The balances of a shaft: one for each drive whose torque acts on it, and one for all whose torques pass other parts.
fn balances(
    inputs: &[Inputs],
    sources: &[(usize, usize)],
    shaft: usize,
    is_torque: impl Fn((usize, usize)) -> bool,
) -> Vec<Balance> {
    let from = |part: usize| {
        let all = inputs.iter().enumerate().flat_map(|(to, of)| of.wires.iter().map(move |wire| (to, wire)));
        all.filter(move |(_, wire)| wire.from == part)
    };
    let speed = |drive: usize| {
        let wires = &inputs[drive].wires;
        let w = wires.iter().find_map(|wire| match wire.course {
            InputCourse::Acceleration([_, w]) if wire.from == shaft => Some(w),
            _ => None,
        })?;
        Some((w, wires.iter().position(|wire| wire.source == w)?))
    };
    let (mut all, mut passing) = (Vec::new(), Balance { shaft, ..Balance::default() });
    for drive in 0..inputs.len() {
        let Some((w, place)) = speed(drive) else { continue };
        let mut torques: Vec<usize> =
            (0..sources.len()).filter(|i| sources[*i].0 == drive && is_torque(sources[*i])).collect();
        let acts = |torque: &usize| inputs[shaft].wires.iter().any(|wire| wire.source == *torque);
        if torques.iter().any(acts) {
            torques.retain(acts);
            let on_shaft = |i: &usize| torques.contains(&inputs[shaft].wires[*i].source);
            let given = (0..inputs[shaft].wires.len()).filter(on_shaft).collect();
            let taken = torques.iter().map(|torque| ((drive, place), *torque)).collect();
            all.push(Balance { shaft, drives: vec![drive], taken, given, speed: w, ..Balance::default() });
            continue;
        }
        let mut open: Vec<usize> =
            from(drive).filter(|(_, wire)| torques.contains(&wire.source)).map(|of| of.0).collect();
        let (mut passed, mut reaches) = (Vec::new(), false);
        while let Some(part) = open.pop() {
            reaches |= part == shaft;
            if part != shaft && speed(part).is_none() && !passed.contains(&part) {
                passed.push(part);
                open.extend(from(part).map(|(to, _)| to));
            }
        }
        if reaches {
            passing.drives.push(drive);
            passing.taken.extend(torques.into_iter().map(|torque| ((drive, place), torque)));
            passing.speed = w;
            passing.by.extend(passed.into_iter().filter(|part| from(*part).any(|(to, _)| to == shaft)));
        }
    }
    passing.by.sort_unstable();
    passing.by.dedup();
    let wires = &inputs[shaft].wires;
    let is_of = |i: &usize| passing.by.contains(&wires[*i].from) && is_torque((shaft, wires[*i].to));
    passing.given = (0..wires.len()).filter(is_of).collect();
    all.extend((!passing.drives.is_empty()).then_some(passing));
    all
}

/// The torques that a drive gives back to its shafts: the outputs tau or tau_mean.
fn powers(inputs: &[Inputs], sources: &[(usize, usize)], parts: &[Host], drive: usize) -> Vec<(usize, usize, Power)> {
    let is_torque = |wire: &Wire| {
        let (part, place) = sources[wire.source];
        part == drive && is_torque(&parts[part].description().variables[place].about.name)
    };
    let motion = inputs[drive].wires.iter().find_map(|wire| match wire.course {
        InputCourse::Acceleration([_, w]) => {
            Some((wire.from, inputs[drive].wires.iter().position(|wire| wire.source == w)?))
        }
        _ => None,
    });
    motion.map_or(Vec::new(), |(shaft, speed)| {
        let torques = (0..inputs[shaft].wires.len()).filter(|i| is_torque(&inputs[shaft].wires[*i]));
        torques.map(|torque| (shaft, drive, Power { speed, torque })).collect()
    })
}

/// Value and derivatives of the source at the beginning of a step; `stepped`: the part of the source has taken this step.
fn polynomial(wire: &Wire, sources: &[Source], exchange: Exchange, stepped: bool, step: f64) -> [f64; 4] {
    let [[start, rate], [end, last]] = sources[wire.source].ends;
    let held = |value| [value, 0.0, 0.0, 0.0];
    let at_once = matches!(exchange, Exchange::Held | Exchange::Extrapolated);
    let latest = if stepped && !at_once { end } else { start };
    match (wire.course, exchange) {
        (InputCourse::Motion, _) => held(start),
        (InputCourse::Discrete, _) | (InputCourse::Signal, Exchange::GaussSeidel) => held(latest),
        (_, Exchange::Held | Exchange::GaussSeidel) => held(start),
        _ if at_once || !stepped => [start, rate, 0.0, 0.0],
        (InputCourse::Acceleration([phi, w]), _) => {
            let [[phi, _], [phi_end, _]] = sources[phi].ends;
            let [[w, _], [w_end, _]] = sources[w].ends;
            // The residual of φ and φ̇ without φ̈ (rad/s²).
            let angle = (phi_end - phi - step * (w + step / 2.0 * start)) / (step * step);
            let speed = (w_end - w - step * start) / step;
            [start, (24.0 * angle - 6.0 * speed) / step, (24.0 * speed - 72.0 * angle) / (step * step), 0.0]
        }
        (InputCourse::InertiaSlope([inertia, phi, w], ratio), _) => {
            let [[before, _], [after, _]] = sources[inertia].ends;
            let turned = ratio * (sources[phi].ends[1][0] - sources[phi].ends[0][0]);
            let second = 2.0 * (after - before - start * turned) / (turned * turned);
            let slope = if turned.abs() < LEAST_TURN { rate } else { second * ratio * sources[w].ends[0][0] };
            [start, slope, 0.0, 0.0]
        }
        (InputCourse::Signal, _) if !wire.is_smooth => [start, (end - start) / step, 0.0, 0.0],
        (InputCourse::Signal, _) => {
            let mean = (end - start) / step;
            let second = (6.0 * mean - 4.0 * rate - 2.0 * last) / step;
            [start, rate, second, 6.0 * (rate + last - 2.0 * mean) / (step * step)]
        }
    }
}

/// The cubic through values and slopes at both ends of a step, in its middle.
fn middle([start, rate]: [f64; 2], [end, last]: [f64; 2], step: f64) -> f64 {
    (start + end) / 2.0 + step * (rate - last) / 8.0
}
