"""What every exported FMU must do, whatever its model: each test runs for each FMU of the folder."""

import math
import random
import re
import threading

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from conftest import FMUS, Package, all_fmus

NAMES = all_fmus()
pytestmark = pytest.mark.parametrize("name", NAMES)


def stimulate(unit, time):
    """Gives the inputs, where the FMU has any, a smooth motion, a constant motor torque and a small sine for whatever else."""
    move(unit, time)
    inputs = {name for name, variable in unit.package.variables.items() if variable.causality == "input"}
    others = {name: 0.1 * math.sin(3.0 * time) for name in inputs - {"phi", "w", "a", "M_an"}}
    unit.set(**others, **({"M_an": 1.0} if "M_an" in inputs else {}))


def move(unit, time):
    """Gives the inputs phi, w and a, or w alone, where the FMU has them, a motion that is the same polynomial in every step."""
    inputs = {name for name, variable in unit.package.variables.items() if variable.causality == "input"}
    w0, ramp = 6.0, 0.8
    if "phi" in inputs:
        unit.set(phi=w0 * time + ramp * time * time / 2, w=w0 + ramp * time, a=ramp)
    elif "w" in inputs:
        unit.set(w=w0 + ramp * time)
        unit.slave.setRealInputDerivatives([unit.package.variables["w"].valueReference], [1], [ramp])


def started(package, name="unit"):
    unit = package.unit(name)
    stimulate(unit, 0.0)
    return unit.initialise()


def run(unit, steps, size):
    for _ in range(steps):
        stimulate(unit, unit.time)
        unit.step(size)
    return np.array(unit.get(*unit.package.outputs()), dtype=float)


def step_size(package):
    return float(package.description.defaultExperiment.stepSize)


def test_fmpy_finds_nothing_to_complain_about(name):
    assert validate_fmu(str(FMUS / f"{name}.fmu")) == []


def test_names_units_and_identifiers_keep_the_rules(fmu, name):
    package = fmu(name)
    d = package.description
    assert d.fmiVersion == "2.0" and d.variableNamingConvention == "structured"
    identifier = d.coSimulation.modelIdentifier
    assert len(identifier) <= 24 and identifier.isidentifier() and identifier.isascii()
    for v in d.modelVariables:
        assert v.name.isascii() and len(v.name) <= 40 and v.name != "time"
        assert v.type != "String" and v.description
        if v.type == "Real":
            assert v.unit or v.declaredType, v.name
            assert v.quantity or v.declaredType, v.name
        if v.causality == "parameter" and v.type == "Real":
            assert v.min is not None and v.max is not None, v.name
    experiment = d.defaultExperiment
    count = float(experiment.stopTime) / float(experiment.stepSize)
    assert count.is_integer() and count <= 1000
    nanoseconds = float(experiment.stepSize) * 1e9
    assert abs(nanoseconds - round(nanoseconds)) < 1e-6


def test_what_is_named_a_derivative_is_marked_as_one(fmu, name):
    """der(x) is that of x, der(x,2) that of der(x)."""
    package = fmu(name)
    for v in package.description.modelVariables:
        if v.name.startswith("der("):
            base = v.name[4:-1]
            base = f"der({base[:-2]})" if base.endswith(",2") else base
            assert v.derivative is not None and v.derivative.name == base, v.name


def test_fmpy_simulates_it_as_it_is(name):
    result = fmpy.simulate_fmu(str(FMUS / f"{name}.fmu"))
    for column in result.dtype.names:
        assert np.all(np.isfinite(result[column].astype(float))), column


def test_two_interleaved_instances_do_not_know_of_each_other(fmu, name):
    package = fmu(name)
    size = step_size(package)
    with started(package, "alone") as alone:
        expected = run(alone, 20, size)
    with started(package, "first") as first, started(package, "second") as second:
        for _ in range(10):
            run(first, 2, size)
            run(second, 1, size)
        assert np.array_equal(np.array(first.get(*package.outputs()), dtype=float), expected)


def test_instances_in_threads_yield_the_same_bits(fmu, name):
    package = fmu(name)
    size = step_size(package)
    results = {}

    def work(number):
        with started(package, f"thread {number}") as unit:
            results[number] = run(unit, 20, size)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    for i in range(1, 4):
        assert np.array_equal(results[i], results[0])


def test_reset_is_complete(fmu, name):
    package = fmu(name)
    size = step_size(package)
    with started(package) as unit:
        expected = run(unit, 10, size)
        unit.slave.reset()
        stimulate(unit, 0.0)
        unit.initialise()
        assert np.array_equal(run(unit, 10, size), expected)


def test_a_saved_state_continues_bit_by_bit(fmu, name):
    package = fmu(name)
    size = step_size(package)
    with started(package) as unit:
        run(unit, 7, size)
        time = unit.time
        state = unit.slave.getFMUState()
        data = unit.slave.serializeFMUState(state)
        expected = run(unit, 9, size)
        unit.slave.setFMUState(state)
        unit.time = time
        assert np.array_equal(run(unit, 9, size), expected)
        unit.slave.freeFMUState(state)
        # The bytes restore another instance as well.
        with started(package, "other") as other:
            restored = other.slave.deserializeFMUState(data)
            other.slave.setFMUState(restored)
            other.time = time
            assert np.array_equal(run(other, 9, size), expected)
            other.slave.freeFMUState(restored)


def test_damaged_and_foreign_bytes_are_refused(fmu, name):
    package = fmu(name)
    with started(package) as unit:
        state = unit.slave.getFMUState()
        data = unit.slave.serializeFMUState(state)
        for damaged in (b"", data[:-1], data + b"x", data[:20] + bytes([data[20] ^ 1]) + data[21:], b"\0" * len(data)):
            with pytest.raises(FMICallException):
                unit.slave.deserializeFMUState(damaged)
        middle = len(data) // 2
        with pytest.raises(FMICallException):
            unit.slave.deserializeFMUState(data[:middle] + bytes([data[middle] ^ 255]) + data[middle + 1 :])
        run(unit, 2, step_size(package))


def test_output_derivatives_are_the_slopes_of_the_outputs(fmu, name):
    package = fmu(name)
    size = step_size(package)
    outputs = [v for v in package.description.modelVariables if v.causality == "output" and v.variability == "continuous"]
    references = [v.valueReference for v in outputs]
    with started(package) as unit:
        run(unit, 13, size)
        h = size * 1e-4
        stimulate(unit, unit.time)
        first = np.array(unit.slave.getRealOutputDerivatives(references, [1] * len(references)))
        second = np.array(unit.slave.getRealOutputDerivatives(references, [2] * len(references)))
        values = [np.array(unit.get(*[v.name for v in outputs]))]
        state = unit.slave.getFMUState()
        time = unit.time
        slopes = []
        for _ in range(2):
            unit.step(h)
            # A torque without input derivatives is held, and so it is in the derivatives of the outputs.
            move(unit, unit.time)
            values.append(np.array(unit.get(*[v.name for v in outputs])))
            slopes.append(np.array(unit.slave.getRealOutputDerivatives(references, [1] * len(references))))
        unit.slave.setFMUState(state)
        unit.time = time
        unit.slave.freeFMUState(state)
    scale = np.abs(first) + size * np.abs(second) + 1e-9 * np.abs(values[0]) / h + 1e-12
    difference = (-3 * values[0] + 4 * values[1] - values[2]) / (2 * h)
    assert np.all(np.abs(difference - first) <= 2e-3 * scale), [v.name for v in outputs]
    curvature = (slopes[0] - first) / h
    bound = np.abs(second) + np.abs(slopes[1] - 2 * slopes[0] + first) / h + 1e-6 * np.abs(first) / h + 1e-9
    assert np.all(np.abs(curvature - second) <= 5e-2 * bound), [v.name for v in outputs]


def test_dependencies_are_those_of_the_directional_derivatives(fmu, name):
    package = fmu(name)
    d = package.description
    states = {u.variable.derivative.name for u in d.derivatives}
    knowns = [v for v in d.modelVariables if v.name in states or (v.causality == "input" and v.type == "Real")]
    with started(package) as unit:
        run(unit, 3, step_size(package))
        stimulate(unit, unit.time)
        for unknown in d.outputs + d.derivatives:
            if unknown.variable.type != "Real" or unknown.variable.variability != "continuous":
                continue
            listed = {v.name for v in unknown.dependencies}
            for known in knowns:
                (value,) = unit.slave.getDirectionalDerivative(
                    [unknown.variable.valueReference], [known.valueReference], [1.0]
                )
                assert math.isfinite(value)
                if known.name not in listed:
                    assert value == 0.0, (unknown.variable.name, known.name)


def test_initial_unknowns_depend_on_what_they_list_and_by_these_derivatives(fmu, name):
    """Pairs at random: each parameter is moved a little before the start, and the start value compared."""
    package = fmu(name)
    dice = random.Random(name)
    unknowns = [u for u in package.description.initialUnknowns if u.variable.type == "Real"]
    knowns = [v for v in package.description.modelVariables if v.type == "Real" and v.causality in ("parameter", "input")]
    # A tolerance makes rounding errors; they have no derivative.
    knowns = [v for v in knowns if not v.name.startswith("solver.")]
    references = [u.variable.valueReference for u in unknowns]
    with package.unit() as unit:
        unit.slave.setupExperiment(startTime=0.0)
        unit.slave.enterInitializationMode()
        stimulate(unit, 0.3)
        for known in dice.sample(knowns, min(len(knowns), 12)):
            centre = unit.get(known.name)
            size = abs(centre) if centre and known.quantity != "Angle" else 0.01
            low, high = centre - 1e-5 * size, centre + 1e-5 * size
            low, high = max(low, float(known.min or low)), min(high, float(known.max or high))
            values = []
            for value in (low, high, centre):
                unit.set(**{known.name: value})
                values.append(np.array(unit.slave.getReal(references)))
            slopes = (values[1] - values[0]) / (high - low)
            # What the start makes of rounding is no dependence.
            noise = 1e-9 * np.abs(values[2]) + 1e-12
            chosen = dice.sample(range(len(unknowns)), min(len(unknowns), 6))
            derivatives = unit.slave.getDirectionalDerivative(
                [references[i] for i in chosen], [known.valueReference], [1.0]
            )
            for i, slope in zip(chosen, derivatives):
                pair = (unknowns[i].variable.name, known.name)
                if abs(values[1][i] - values[0][i]) > noise[i]:
                    assert known in unknowns[i].dependencies, pair
                assert abs(slope - slopes[i]) <= 1e-5 * abs(slope) + 1e-5 * noise[i] / 1e-9 / size, pair


def test_directional_derivatives_of_all_unknowns_come_in_one_call(fmu, name):
    """In step mode the unknowns are the Real outputs, discrete ones too, and the derivatives of the states."""
    package = fmu(name)
    d = package.description
    unknowns = [u.variable for u in d.outputs + d.derivatives if u.variable.type == "Real"]
    states = {u.variable.derivative.name for u in d.derivatives}
    knowns = [v for v in d.modelVariables if v.name in states or (v.causality == "input" and v.type == "Real")]
    references = [[v.valueReference for v in variables] for variables in (unknowns, knowns)]
    with started(package) as unit:
        for steps in range(3):
            run(unit, steps, step_size(package))
            stimulate(unit, unit.time)
            for direction in np.eye(len(knowns)):
                values = unit.slave.getDirectionalDerivative(*references, list(direction))
                assert len(values) == len(unknowns) and np.all(np.isfinite(values))


def test_messages_have_the_status_of_their_call(fmu, name):
    """Only a step warns beside fmi2OK, of inputs that jump: importers take another status of a step for its end."""
    package = fmu(name)
    inputs = [v.name for v in package.variables.values() if v.causality == "input" and v.type == "Real"]
    numbers = random.Random(3)

    def jump(unit):
        unit.set(**{name: numbers.uniform(-3.0, 3.0) for name in inputs})

    with package.unit() as unit:
        jump(unit)
        unit.initialise()
        for _ in range(20):
            jump(unit)
            unit.get(*package.outputs())
            assert all(status == 0 for status, _, _ in unit.log)
            unit.step(step_size(package))
            for status, category, _ in unit.log:
                assert (status, category) in [(0, "logEvents"), (0, "logSolver"), (1, "logStatusWarning")]
            unit.log.clear()
        unit.slave.terminate()
        unit.slave.reset()
        assert unit.log == []


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_no_parameter_takes_a_value_that_is_no_number(fmu, name, bad):
    package = fmu(name)
    with package.unit() as unit:
        for v in package.description.modelVariables:
            if v.type == "Real" and v.causality in ("parameter", "input"):
                with pytest.raises(FMICallException):
                    unit.slave.setReal([v.valueReference], [bad])
                assert v.name in unit.log[-1][2]
        stimulate(unit, 0.0)
        unit.initialise()
        run(unit, 2, step_size(package))


def test_values_outside_their_range_are_refused_with_the_range(fmu, name):
    package = fmu(name)
    with package.unit() as unit:
        for v in package.description.modelVariables:
            if v.type != "Real" or v.causality != "parameter":
                continue
            for value in (math.nextafter(float(v.min), -math.inf), math.nextafter(float(v.max), math.inf)):
                if math.isinf(value) or value == float(v.min) or value == float(v.max):
                    continue
                with pytest.raises(FMICallException):
                    unit.slave.setReal([v.valueReference], [value])
                assert v.name in unit.log[-1][2]


def test_wrong_references_and_types_are_errors(fmu, name):
    package = fmu(name)
    real = next(v for v in package.description.modelVariables if v.type == "Real")
    with started(package) as unit:
        for call in (
            lambda: unit.slave.getReal([123456]),
            lambda: unit.slave.getInteger([real.valueReference]),
            lambda: unit.slave.getBoolean([real.valueReference]),
            lambda: unit.slave.getString([real.valueReference]),
            lambda: unit.slave.setInteger([real.valueReference], [1]),
            lambda: unit.slave.getRealOutputDerivatives([123456], [1]),
            lambda: unit.slave.setRealInputDerivatives([123456], [1], [0.0]),
            lambda: unit.slave.getDirectionalDerivative([123456], [real.valueReference], [1.0]),
        ):
            before = len(unit.log)
            with pytest.raises(FMICallException):
                call()
            assert len(unit.log) == before + 1 and unit.log[-1][0] == 3


@pytest.mark.parametrize("size", [0.0, -1e-3, float("nan"), float("inf")])
def test_a_step_that_is_no_step_is_an_error(fmu, name, size):
    package = fmu(name)
    with started(package) as unit:
        with pytest.raises(FMICallException):
            unit.slave.doStep(0.0, size)
        assert unit.log[-1][0] == 3


def test_a_wrong_communication_point_is_an_error(fmu, name):
    package = fmu(name)
    size = step_size(package)
    with started(package) as unit:
        run(unit, 2, size)
        with pytest.raises(FMICallException):
            unit.slave.doStep(3.7 * size, size)
        assert "communication" in unit.log[-1][2]


def test_a_step_beyond_the_stop_time_is_an_error(fmu, name):
    package = fmu(name)
    size = step_size(package)
    with package.unit() as unit:
        stimulate(unit, 0.0)
        unit.initialise(stop_time=2.5 * size)
        run(unit, 2, size)
        with pytest.raises(FMICallException):
            unit.step(size)


def test_equal_steps_meet_the_stop_time_of_the_default_experiment(fmu, name):
    package = fmu(name)
    stop, size = float(package.description.defaultExperiment.stopTime), step_size(package)
    with package.unit() as unit:
        stimulate(unit, 0.0)
        unit.initialise(stop_time=stop)
        run(unit, round(stop / size), size)
        assert abs(unit.time - stop) <= 1e-9 * stop


def test_calls_out_of_order_are_errors(fmu, name):
    package = fmu(name)
    with package.unit() as unit:
        with pytest.raises(FMICallException):
            unit.slave.doStep(0.0, 1e-3)
    with started(package) as unit:
        with pytest.raises(FMICallException):
            unit.slave.enterInitializationMode()
    with started(package) as unit:
        for fixed in (v for v in package.description.modelVariables if v.causality == "parameter" and v.variability == "fixed" and v.type == "Real"):
            with pytest.raises(FMICallException):
                unit.slave.setReal([fixed.valueReference], [1e-8])
        run(unit, 2, step_size(package))
        unit.slave.terminate()
        with pytest.raises(FMICallException):
            unit.slave.doStep(unit.time, 1e-3)


def test_another_guid_or_kind_is_refused(fmu, name):
    package = fmu(name)
    unit = package.unit()
    unit.free()
    unit = Package.unit
    from fmpy.fmi2 import FMU2Slave

    slave = FMU2Slave(
        guid="{00000000-0000-0000-0000-000000000000}",
        unzipDirectory=str(package.folder),
        modelIdentifier=package.description.coSimulation.modelIdentifier,
        instanceName="wrong",
    )
    with pytest.raises(Exception, match="instantiate"):
        slave.instantiate()


def test_the_documentation_is_well_formed_and_offline(fmu, name):
    package = fmu(name)
    from lxml import etree

    text = (package.folder / "documentation" / "index.html").read_text(encoding="utf-8")
    tree = etree.fromstring(text.encode())
    formulas = ["".join(formula.itertext()) for formula in tree.iterfind(".//{*}p[@class='formula']")]
    assert formulas and len(set(formulas)) == len(formulas), formulas
    titles = {title.text: title for title in tree.iterfind(".//{*}h3")}
    platforms = [item.text.split(":")[0] for item in titles["Platforms"].getnext()]
    assert sorted(platforms) == sorted(folder.name for folder in (package.folder / "binaries").iterdir())
    assert len(titles["Left out"].getnext()) >= 1
    for attribute in ("src", "href"):
        for value in tree.xpath(f"//@{attribute}"):
            assert not value.startswith(("http:", "https:", "//")) or attribute == "href", value
    for v in package.description.modelVariables:
        assert v.name in text, v.name
    assert (package.folder / "model.png").read_bytes().startswith(b"\x89PNG")
    assert list((package.folder / "documentation" / "licenses").iterdir())


def names_in(text):
    """What reads like the name of a variable, whatever the number of its follower: words of the language have no such signs."""
    text = re.sub(r"der\((\w+)(,2)?\)", r"\1", text)  # A derivative of what is there needs no variable.
    words = [word.rstrip(".") for word in re.findall(r"[A-Za-z_][\w\[\].]*", text)]
    told = [word for word in words if re.search(r"[_.\d]", word) or word in ("tau", "psi", "phi", "w")]
    return {re.sub(r"\[\d+\]", "[1]", word) for word in told}


def ends_of(variables):
    """The names of variables, and how they end: `load.c` is one of `follower[2].load.c`."""
    parts = [re.sub(r"\[\d+\]", "[1]", v.name).split(".") for v in variables]
    return {".".join(name[i:]) for name in parts for i in range(len(name))}


@pytest.fixture(scope="module")
def known(fmu):
    return set().union(*(ends_of(fmu(name).description.modelVariables) for name in NAMES))


def test_sentences_name_variables_that_are_there(fmu, name, known):
    from lxml import etree

    package = fmu(name)
    own = ends_of(package.description.modelVariables)
    tree = etree.fromstring((package.folder / "documentation" / "index.html").read_bytes())
    for element in tree.iterfind(".//{*}*"):
        if element.tag.split("}")[1] not in ("p", "li", "td") or element.get("class") == "formula":
            continue
        sentence = "".join(element.itertext())
        # What a load has to offer that is an FMU of its own.
        other = {"tau_mean"} if "tau_mean of a" in sentence or "its tau_mean" in sentence else set()
        assert names_in(sentence) & known <= own | other, sentence
