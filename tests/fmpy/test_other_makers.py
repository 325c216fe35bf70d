"""FMUs of other makers through `run`, `study`, `verify`, `system` and the Python package, against FMPy's own runs of them: those that the
wheels of `others.txt` bring or make. They are OpenModelica's (gemseo-fmu), C code from a template (qfmu) and Python (pythonfmu)."""

import csv
import importlib.metadata
import io
import json
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import fmpy
import numpy as np
import pandas
import pytest
from conftest import CAMDRIVE, ROOT, Package

needs_wheel = pytest.mark.skipif("CAMDRIVE_WHEEL" not in os.environ, reason="CAMDRIVE_WHEEL names no wheel")

# Those of OpenModelica that are of FMI 2.0. Their solver is Euler's with the communication step.
MODELICA = ["Mass_Damper", "MassSpringSubSystem1", "MassSpringSubSystem2", "MassSpringSystem", "add", "ramp"]

# By qfmu: an oscillator x″ = u − 4 x′ − 400 x, and a controller.
QFMU = {
    "oscillator": ["ss", "-A", "[[0,1],[-400,-4]]", "-B", "[[0],[1]]", "-C", "[[1,0],[0,1]]", "-x0", "[0.5,0]"],
    "controller": ["pid", "-kp", "2", "-ki", "3", "-kd", "0.1", "-T", "0.01"],
}

# By pythonfmu: y' = u − k y, exactly.
DECAY = """
from math import exp
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

class Decay(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.k, self.u, self.y = 2.0, 0.0, 1.0
        self.register_variable(Real("k", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, time, step):
        left = exp(-self.k * step)
        self.y = self.y * left + self.u / self.k * (1 - left)
        return True
"""


@pytest.fixture(scope="module")
def others(tmp_path_factory):
    """The FMUs by their names, in one folder."""
    folder = tmp_path_factory.mktemp("others")
    system = {"Linux": "linux", "Windows": "win32"}.get(platform.system())
    if system is None or platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip(f"gemseo-fmu has no FMUs for {platform.platform()}")
    for place in importlib.metadata.files("gemseo-fmu"):
        if place.parent.name == system and place.stem in [*MODELICA, "FMU3Model"]:
            shutil.copy(place.locate(), folder)
    for name, arguments in QFMU.items():
        made = [sys.executable, "-m", "qfmu", *arguments, "-o", f"{name}.fmu"]
        subprocess.run(made, check=True, cwd=folder, capture_output=True)
    (folder / "decay.py").write_text(DECAY)
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", "decay.py"], check=True, cwd=folder)
    found = {place.stem: place for place in folder.glob("*.fmu")}
    assert sorted(found) == sorted([*MODELICA, *QFMU, "Decay", "FMU3Model"])
    return found


def camdrive_of(*arguments, **keywords):
    return subprocess.run([CAMDRIVE, *map(str, arguments)], capture_output=True, text=True, **keywords)


def columns(text):
    head, *rows = csv.reader(io.StringIO(text))
    # Headings have units that are not SI.
    return {name.split(" [")[0]: values for name, values in zip(head, np.array(rows, dtype=float).T)}


def ran(*arguments, **keywords):
    done = camdrive_of("run", *arguments, **keywords)
    assert done.returncode == 0, done.stderr
    return columns(done.stdout)


def outputs(place):
    return [v.name for v in fmpy.read_model_description(str(place)).modelVariables if v.causality == "output"]


def by_fmpy(place, step=1e-3, **keywords):
    """FMPy's run to 1 s in steps of the thousandth that the tool takes where an FMU tells none."""
    keywords = {"stop_time": 1.0, "output_interval": step, "output": outputs(place), **keywords}
    return fmpy.simulate_fmu(str(place), fmi_type="CoSimulation", **keywords)


def same(found, right):
    """The values of all columns are the same to the bit, those of FMPy's clock aside, which adds up its steps."""
    assert set(right.dtype.names) == set(found)
    for name in right.dtype.names:
        assert len(found[name]) == len(right[name]), name
        assert np.abs(found[name] - right[name]).max() <= (1e-12 if name == "time" else 0), name


# run and verify


@pytest.mark.parametrize("name", [*MODELICA, *QFMU])
def test_a_run_by_default_settings_is_that_of_fmpy(others, name):
    same(ran(others[name]), by_fmpy(others[name]))


@pytest.mark.parametrize("name, values, held", [
    ("Mass_Damper", {"mass.m": 2.5, "spring.c": 900}, {"f": 3.0}),
    ("MassSpringSystem", {}, {"m1": 2.0, "k3": 0.25}),
    ("add", {"add.k1": -2}, {"u1": 3.0, "u2": 0.5}),
    ("ramp", {"ramp.duration": 0.4, "ramp.startTime": 0.25}, {}),
    ("oscillator", {"x1_start": 0.2, "u1_start": 7}, {}),
    ("controller", {}, {"u1": 1.5}),
])
def test_start_values_are_set_as_fmpy_sets_them(others, name, values, held):
    starts = [word for key, value in {**values, **held}.items() for word in ("--start", f"{key}={value}")]
    same(ran(others[name], *starts), by_fmpy(others[name], start_values={**values, **held}))


@pytest.mark.parametrize("name, inputs", [
    ("Mass_Damper", {"f": [0, 40, -20, -20]}), ("add", {"u1": [1, 2, 0, 0], "u2": [0, 0, 3, 3]}),
    ("oscillator", {"u1": [0, 50, 50, 0]}), ("controller", {"u1": [0, 1, 1, -1]}),
])
def test_inputs_over_time_are_given_with_their_slopes(others, tmp_path, name, inputs):
    times, step = [0, 0.25, 0.5, 1], 0.0078125
    table = tmp_path / "inputs.csv"
    rows = np.column_stack([times, *inputs.values()])
    np.savetxt(table, rows, delimiter=",", header=",".join(["time", *inputs]), comments="")
    found = ran(others[name], "--input", table, "--step", step)
    package = Package(others[name], tmp_path / "unpacked")

    def give(unit, time):
        row = min(np.searchsorted(times, time, side="right"), len(times) - 1)
        for key, values in inputs.items():
            slope = np.diff(values)[row - 1] / np.diff(times)[row - 1]
            unit.set(**{key: values[row - 1] + slope * (time - times[row - 1])})
            if package.description.coSimulation.canInterpolateInputs:
                unit.slave.setRealInputDerivatives([package.variables[key].valueReference], [1], [slope])

    with package.unit() as unit:
        unit.initialise(stop_time=1.0, tolerance=float(package.description.defaultExperiment.tolerance))
        for i in range(129):
            give(unit, i * step)
            for output in outputs(others[name]):
                right = unit.get(output)
                assert found[output][i] == pytest.approx(right, rel=1e-12, abs=1e-12), (output, i)
            if i < 128:
                unit.step(step)


def test_what_the_tool_does_not_run_is_told(others):
    third = camdrive_of("run", others["FMU3Model"])
    assert third.returncode == 1 and "FMI 3.0" in third.stderr and "hint" in third.stderr
    for name in [*MODELICA, *QFMU]:
        done = camdrive_of("verify", others[name])
        assert done.returncode == 1 and "holds no results" in " ".join(done.stderr.split()), done.stderr


def test_an_fmu_that_lacks_its_python_says_so_and_runs_with_it(others):
    alone = camdrive_of("run", others["Decay"], "--stop", "1 s")
    assert alone.returncode == 1 and "the FMU needs PythonFMU 0.7.0 on this machine" in alone.stderr
    folder, library = sysconfig.get_config_vars("LIBDIR", "INSTSONAME")
    if not library or not Path(folder, library).exists():
        pytest.skip("this Python has no shared library to preload")
    with_it = {**os.environ, "LD_PRELOAD": str(Path(folder, library))}
    found = ran(others["Decay"], "--stop", "1 s", "--step", "0.125", "--start", "k=3", "--start", "u=6", env=with_it)
    assert found["y"] == pytest.approx(2 - np.exp(-3 * found["time"]), rel=1e-14)


# study


@pytest.mark.parametrize("name, vary, measure", [
    ("Mass_Damper", {"mass.m": [1, 2, 4, 8], "spring.c": [100, 1e4]}, "y"),
    ("MassSpringSystem", {"m1": [1, 2, 3, 4], "k1": [1, 2]}, "x1"),
    ("oscillator", {"x1_start": [0.1, 0.2, 0.3, 0.4], "x2_start": [0, 1]}, "y1"),
])
def test_a_study_on_several_threads_has_the_values_of_fmpy(others, tmp_path, name, vary, measure):
    given = "".join(f"[[vary]]\nname = {json.dumps(key)}\nvalues = {values}\n" for key, values in vary.items())
    head = f'scene = {json.dumps(str(others[name]))}\ntime = "1 s"\nstep = "1 ms"\nmeasures = ["last {measure}"]\n'
    (tmp_path / "study.toml").write_text(head + given)
    done = camdrive_of("study", tmp_path / "study.toml", "-o", tmp_path / "store", "--threads", 4, "--json")
    assert done.returncode == 0, done.stderr
    assert [json.loads(done.stdout)[key] for key in ("ok", "refused", "failed")] == [8, 0, 0]
    table = pandas.read_parquet(tmp_path / "store" / "runs")
    assert len(table) == 8
    for _, row in table.iterrows():
        right = by_fmpy(others[name], start_values={key: row[key] for key in vary})
        assert row[f"last {measure}"] == pytest.approx(right[measure][-1], rel=1e-14)


# system


def springs(others, folder, step, exchange=None):
    """Two masses between walls, each by an FMU of its own."""
    parts = "".join(
        f"[part.{part}]\nfmu = {json.dumps(str(others[f'MassSpringSubSystem{i}']))}\n" for part, i in (("a", 1), ("b", 2))
    )
    wires = "".join(f'[[connection]]\nfrom = "{a}.{x}"\nto = "{b}.{x}"\n' for a, b, x in (("a", "b", "x1"), ("b", "a", "x2")))
    chosen = f'exchange = "{exchange}"\n' if exchange else ""
    file = folder / "springs.toml"
    file.write_text(f'name = "springs"\nstop = 1\nstep = {step}\n{chosen}{parts}{wires}')
    return file


@pytest.mark.parametrize("exchange", [None, "held", "interpolated"])
def test_coupled_halves_are_the_whole(others, tmp_path, exchange):
    # Euler's rule takes inputs at the beginning of a step, so that the parts make the steps of the whole.
    found = ran(springs(others, tmp_path, 0.01, exchange), "--output", "a.x1,a.v1,b.x2,b.v2")
    right = by_fmpy(others["MassSpringSystem"], step=0.01)
    for part, name in (("a", "x1"), ("a", "v1"), ("b", "x2"), ("b", "v2")):
        assert np.abs(found[f"{part}.{name}"] - right[name]).max() < 1e-14, name


@pytest.mark.parametrize("exchange", ["held", "interpolated"])
def test_what_system_writes_couples_them(others, tmp_path, exchange):
    file = springs(others, tmp_path, 0.01, exchange)
    done = camdrive_of("system", file, "-o", tmp_path / "written")
    assert done.returncode == 0, done.stderr
    right = by_fmpy(others["MassSpringSystem"], step=0.01)
    for found in (master(tmp_path / "written", 0.01), ran(tmp_path / "written" / "springs.ssp", "--step", "0.01")):
        for part, name in (("a", "x1"), ("b", "v2")):
            assert np.abs(found[f"{part}.{name}"] - right[name]).max() < 1e-14, name


def master(folder, step):
    """The columns of its run.py."""
    subprocess.run([sys.executable, "run.py", str(step)], check=True, cwd=folder, capture_output=True)
    return columns((folder / "springs.csv").read_text())


def test_an_order_that_openmodelica_refuses_is_not_given_again(others, tmp_path):
    machine = ROOT / "examples" / "two_cams" / "machine.toml"
    file = tmp_path / "mixed.toml"
    file.write_text(
        f'name = "mixed"\nstop = 0.2\nstep = 1e-3\nexchange = "interpolated"\n[part.machine]\nscene = "{machine}"\n'
        f'[part.add]\nfmu = "{others["add"]}"\n[[connection]]\nfrom = "machine.w"\nto = "add.u1"\n'
        '[[connection]]\nfrom = "machine.a"\nto = "add.u2"\n'
    )
    done = camdrive_of("run", file, "--output", "machine.w,machine.a,add.y")
    assert done.returncode == 0 and "warning" not in done.stderr, done.stderr
    found = columns(done.stdout)
    # A part of another maker gets the inputs of the end before its outputs are read.
    assert np.abs(found["add.y"] - found["machine.w"] - found["machine.a"])[1:].max() < 1e-12


# Python


@needs_wheel
@pytest.mark.parametrize("name", ["Mass_Damper", "MassSpringSystem", "oscillator"])
def test_both_engines_give_the_same(others, camdrive, name):
    by_tool, by_engine = (camdrive.simulate(others[name], step=1e-3, engine=engine) for engine in ("native", "fmpy"))
    assert by_tool.dtype.names == by_engine.dtype.names and by_tool.units == by_engine.units
    for column in by_tool.dtype.names:
        assert np.abs(by_tool[column] - by_engine[column]).max() <= (1e-12 if column == "time" else 0), column


@needs_wheel
def test_python_that_is_there_runs_what_is_made_of_it(others, camdrive):
    found = camdrive.simulate(others["Decay"], stop_time=1, step=0.125, engine="fmpy", k=3, u=6)
    assert found["y"] == pytest.approx(2 - np.exp(-3 * found["time"]), rel=1e-14)


@needs_wheel
def test_threads_of_python_do_not_disturb_each_other(others, camdrive):
    masses = np.linspace(1, 4, 12)

    def last(mass):
        return camdrive.simulate(others["Mass_Damper"], start_values={"mass.m": f"{mass} kg"})["y"][-1]

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(last, masses))
    assert found == [by_fmpy(others["Mass_Damper"], start_values={"mass.m": mass})["y"][-1] for mass in masses]


@needs_wheel
def test_a_study_in_python(others, camdrive):
    study = camdrive.study(others["Mass_Damper"], {"mass.m": [1, 4]}, ["last y", "mean y"], time="1 s", step="1 ms")
    for mass, row in zip((1, 4), study.table.to_dict("records")):
        right = by_fmpy(others["Mass_Damper"], start_values={"mass.m": mass})
        assert row["status"] == "ok" and row["last y"] == right["y"][-1]
        # Between communication points an output without derivatives is taken as linear.
        assert row["mean y"] == pytest.approx(np.trapezoid(right["y"], right["time"]), rel=1e-9)
