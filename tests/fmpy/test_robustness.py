"""Careless importers: random calls, damaged states, instances made again and again; the files besides the model."""

import ast
import ctypes
import platform
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from urllib.parse import quote

import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

from conftest import FMUS, Package, all_fmus
from test_every_fmu import run, started, step_size, stimulate

pytestmark = pytest.mark.parametrize("name", all_fmus())

HERE = Path(__file__).resolve().parent
CALLS = 4000

# A random value is now and then one that no importer should pass.
NUMBERS = [0.0, -0.0, 1.0, -1.0, 1e-3, 1e-300, 1e300, float("nan"), float("inf"), -float("inf"), 3.7, 1e9]
INTEGERS = [0, 1, 2, 3, 4, -1, 7, 2**31 - 1, -(2**31)]


def numbers(dice):
    return dice.choice(NUMBERS) if dice.random() < 0.5 else dice.uniform(-1.0, 1.0)


def random_calls(path, seed):
    """Calls functions of the FMU in any order and state with any values; returns what was answered, by status.

    The values that come back with fmi2OK are finite; a communication step is at most a second, since a longer one
    is legal and only takes long.
    """
    with tempfile.TemporaryDirectory() as folder:
        return call_at_random(Package(Path(path), folder), random.Random(seed))


def call_at_random(package, dice):
    unit = package.unit("random 100 % é", logging=True)
    library = unit.slave
    references = [v.valueReference for v in package.description.modelVariables] * 3 + [4711, 2**32 - 1]
    structure = package.description
    continuous = [u.variable.valueReference for u in structure.outputs + structure.derivatives] + references[-2:]
    knowns = [v.valueReference for v in structure.modelVariables if v.causality == "input"]
    knowns += [u.variable.derivative.valueReference for u in structure.derivatives] + references[-2:]
    orders = [0, 1, 2, 3, 9, -1, 2**31 - 1]
    states, texts = [], []
    finite = []
    size = step_size(package)

    def some(pool=references):
        return [dice.choice(pool) for _ in range(dice.randint(0, 4))]

    def values(count, source=numbers):
        return [source(dice) for _ in range(count)]

    def integer(dice):
        return dice.choice(INTEGERS)

    def get(getter):
        finite.extend(getter(some()))

    def put(setter, source):
        chosen = some()
        setter(chosen, values(len(chosen), source))

    def input_derivatives():
        chosen = some()
        library.setRealInputDerivatives(chosen, [dice.choice(orders) for _ in chosen], values(len(chosen)))

    def output_derivatives():
        chosen = some()
        finite.extend(library.getRealOutputDerivatives(chosen, [dice.choice(orders) for _ in chosen]))

    def directional_derivatives():
        unknown, known = some(continuous), some(knowns)
        finite.extend(library.getDirectionalDerivative(unknown, known, values(len(known))))

    def step():
        right = dice.random() < 0.8
        point = unit.time if right else numbers(dice)
        length = dice.choice([size, size / 7, 10 * size, 1e-9]) if right else min(numbers(dice), 1.0)
        library.doStep(point, length)
        unit.time = point + length

    def begin():
        library.setupExperiment(dice.choice([None, 1e-4, numbers(dice)]), 0.0, dice.choice([None, 1.0, numbers(dice)]))
        unit.time = 0.0
        library.enterInitializationMode()
        if dice.random() < 0.8:
            library.exitInitializationMode()

    def save():
        states.append((library.getFMUState(), unit.time))
        texts.append(library.serializeFMUState(states[-1][0]))
        if len(states) > 5:
            library.freeFMUState(states.pop(0)[0])

    def restore():
        if states:
            state, unit.time = dice.choice(states)
            library.setFMUState(state)

    def damage():
        if texts:
            data = bytearray(dice.choice(texts))
            data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
            library.deserializeFMUState(bytes(data))
            raise AssertionError("a damaged state was accepted")

    def reset():
        library.reset()
        unit.time = 0.0

    def log():
        library.setDebugLogging(dice.random() < 0.5, dice.choice([[], ["logAll"], ["logEvents", "nonsense"]]))

    def status():
        kind = ctypes.c_int(dice.choice([0, 1, 2, 3, 9]))
        results = {"Real": ctypes.c_double, "String": ctypes.c_char_p, "Integer": ctypes.c_int, "Boolean": ctypes.c_int}
        which, result = dice.choice([*results.items(), ("", ctypes.c_int)])
        getattr(library, f"fmi2Get{which}Status")(library.component, kind, ctypes.byref(result()))

    calls = [
        (8, step), (6, begin), (3, reset), (1, library.terminate), (2, library.enterInitializationMode),
        (2, library.exitInitializationMode), (6, lambda: get(library.getReal)), (2, lambda: get(library.getInteger)),
        (2, lambda: get(library.getBoolean)), (6, lambda: put(library.setReal, numbers)),
        (3, lambda: put(library.setInteger, integer)), (2, lambda: put(library.setBoolean, integer)),
        (4, input_derivatives), (4, output_derivatives), (4, directional_derivatives), (2, save), (4, restore),
        (2, damage), (1, log), (2, status), (1, lambda: library.fmi2CancelStep(library.component)),
    ]
    weights, functions = zip(*calls)
    answers = {"ok": 0, "refused": 0}
    for _ in range(CALLS):
        finite.clear()
        before = len(unit.log)
        try:
            dice.choices(functions, weights)[0]()
            answers["ok"] += 1
        except FMICallException:
            answers["refused"] += 1
        # NaN and infinity differ from themselves when they are subtracted.
        assert all(value - value == 0.0 for value in finite), finite
        assert not any("internal error" in text for _, _, text in unit.log[before:]), unit.log[-1]
    unit.free()
    return answers


def test_random_calls_never_crash(name):
    # Its own process: a crash is to fail this test and not to end the run.
    program = f"from test_robustness import random_calls; print(random_calls({str(FMUS / (name + '.fmu'))!r}, 1))"
    done = subprocess.run([sys.executable, "-c", program], cwd=HERE, capture_output=True, text=True)
    assert done.returncode == 0, f"exit code {done.returncode}: {done.stderr[-2000:]}"
    answers = ast.literal_eval(done.stdout)
    assert answers["ok"] > CALLS / 10 and answers["refused"] > CALLS / 10, answers


def test_every_damaged_byte_of_a_state_is_found(fmu, name):
    package = fmu(name)
    with started(package) as unit:
        run(unit, 3, step_size(package))
        state = unit.slave.getFMUState()
        data = unit.slave.serializeFMUState(state)
        for place in range(len(data)):
            damaged = bytearray(data)
            damaged[place] ^= 0xFF
            with pytest.raises(FMICallException):
                unit.slave.deserializeFMUState(bytes(damaged))
        unit.slave.freeFMUState(state)


def test_instances_can_be_made_again_and_again(fmu, name):
    package = fmu(name)
    results = set()
    for number in range(5):
        with started(package, f"load {number}") as unit:
            run(unit, 3, step_size(package))
            results.add(tuple(unit.get(*package.outputs())))
    assert len(results) == 1


@pytest.mark.parametrize("prior", [True, False])
def test_a_step_does_not_depend_on_the_promise_about_states(fmu, name, prior):
    package = fmu(name)
    size = step_size(package)
    with started(package) as unit, started(package) as other:
        run(unit, 5, size)
        for _ in range(5):
            stimulate(other, other.time)
            other.slave.doStep(other.time, size, prior)
            other.time += size
        assert unit.get(*package.outputs()) == other.get(*package.outputs())


def test_a_coarse_tolerance_of_the_host_changes_nothing(fmu, name):
    package = fmu(name)
    size = step_size(package)
    results = []
    for tolerance in (None, 1e-4):
        with package.unit() as unit:
            stimulate(unit, 0.0)
            unit.initialise(tolerance=tolerance)
            run(unit, 20, size)
            results.append(unit.get(*package.outputs()))
    assert results[0] == results[1]


def test_resources_are_found_however_the_host_names_them(name, tmp_path):
    folder = tmp_path / "a folder é 100%"
    package = Package(FMUS / f"{name}.fmu", folder)
    log = []

    def logger(_environment, _instance, _status, category, message):
        log.append((category.decode(), message.decode()))

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(logger)
    with package.unit() as unit:

        def instantiate(location):
            guid = package.description.guid.encode()
            return unit.slave.fmi2Instantiate(b"host", 1, guid, location, ctypes.byref(callbacks), 0, 0)

        plain, coded = str(folder / "resources"), quote(str(folder / "resources"))
        for location in (None, "", f"file:{plain}", f"file://{plain}", f"file:{coded}", f"file://{coded}", "file:///no/where"):
            component = instantiate(None if location is None else location.encode())
            assert component and log == [], (location, log)
            unit.slave.fmi2FreeInstance(component)
        shutil.rmtree(folder / "resources")
        for location in (None, b"", f"file://{coded}".encode()):
            log.clear()
            assert not instantiate(location)
            assert len(log) == 1 and log[0][0] == "logStatusError" and "drive.bin is missing" in log[0][1], log


def test_output_derivatives_are_finite_right_after_initialisation(fmu, name):
    package = fmu(name)
    outputs = [v.valueReference for v in package.description.modelVariables if v.causality == "output" and v.type == "Real"]
    with started(package) as unit:
        for order in (1, 2):
            for value in unit.slave.getRealOutputDerivatives(outputs, [order] * len(outputs)):
                assert value - value == 0.0


# FMI Library 3 takes the 3.0 that the schema of that folder demands for a fatal error in an FMU of FMI 2.0.
def test_an_fmu_holds_only_what_fmi_2_knows(fmu, name):
    folders = {path.name for path in fmu(name).folder.iterdir() if path.is_dir()}
    # `extra` is of FMI 2.0.4.
    assert folders == {"binaries", "documentation", "extra", "resources"}


# That of Red Hat Enterprise Linux 9. Rust's own library brings it where the build machine has it or a later one;
# the mathematics must not raise it.
NEWEST_GLIBC = (2, 34)


@pytest.mark.skipif(platform.system() != "Linux", reason="reads ELF files")
def test_the_library_needs_nothing_but_the_c_library(fmu, name):
    package = fmu(name)
    identifier = package.description.coSimulation.modelIdentifier
    data = (package.folder / "binaries" / "linux64" / f"{identifier}.so").read_bytes()
    needed = {text.decode() for text in re.findall(rb"[\w-]+\.so\.\d+", data)}
    assert needed <= {"libc.so.6", "libm.so.6", "libgcc_s.so.1", "ld-linux-x86-64.so.2"}, needed
    versions = {tuple(int(part) for part in text.split(b".")) for text in re.findall(rb"GLIBC_([\d.]+)", data)}
    print("newest GLIBC version:", ".".join(map(str, max(versions))))
    assert max(versions) <= NEWEST_GLIBC
