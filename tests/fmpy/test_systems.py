"""Systems of FMUs: what `camdrive system` writes, its own master run.py, and the same system in masters of others, with the numbers of
docs/coupling.md. Masters that a platform lacks are skipped."""

import importlib.util
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import CAMDRIVE, ROOT
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet, read_ssd, validate_tree
from lxml import etree


def write(folder, example, **changes):
    """The system of an example with keys of its file changed, written into a folder of its own."""
    source = folder / "source"
    shutil.copytree(ROOT / "examples" / example, source, dirs_exist_ok=True)
    lines = (source / "system.toml").read_text().splitlines()
    lines = [line for line in lines if line.split(" = ")[0] not in changes]
    at = next(i for i, line in enumerate(lines) if line.startswith("name"))
    lines[at + 1 : at + 1] = [f'{key} = "{value}"' for key, value in changes.items()]
    (source / "system.toml").write_text("\n".join(lines))
    target = folder / "target"
    subprocess.run([CAMDRIVE, "system", source / "system.toml", "-o", target], check=True, capture_output=True)
    return target


def master(folder):
    spec = importlib.util.spec_from_file_location(f"run_{folder.parent.name}", folder / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(folder, step):
    head, *rows = master(folder).simulate(step)
    return dict(zip(head, np.array(rows, dtype=float).T))


def start_values(ssp):
    """Those of all components, as fmpy takes them."""
    values = []
    for component in read_ssd(ssp).system.elements:
        for parameters in component.parameterBindings:
            for given in parameters.parameterValues[0].parameters:
                values.append(Parameter(name=f"{component.name}.{given.name}", type=given.type, value=given.value))
    return ParameterSet(parameters=values)


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    return write(tmp_path_factory.mktemp("held"), "two_cams", exchange="held")


def test_the_structure_is_ssp_1_0_with_units_and_one_parameter_set(held):
    archive = zipfile.ZipFile(held / "two_cams.ssp")
    assert sorted(archive.namelist()) == ["SystemStructure.ssd"] + [f"resources/{n}.fmu" for n in ("gripper", "machine", "pusher")]
    for name in ("gripper", "machine", "pusher"):
        assert archive.read(f"resources/{name}.fmu") == (held / f"{name}.fmu").read_bytes()
    root = etree.fromstring(archive.read("SystemStructure.ssd"))
    validate_tree(root, "SystemStructureDescription.xsd")
    sets = root.findall(".//{*}ParameterSet")
    for parameters in sets:
        validate_tree(etree.fromstring(etree.tostring(parameters)), "SystemStructureParameterValues.xsd")
    assert root.get("version") == "1.0" and {s.get("name") for s in sets} == {"two_cams"}
    connector = root.find(".//{*}Component[@name='gripper']//{*}Connector[@name='a']")
    assert connector[0].get("unit") == "rad/s2"
    assert {u.get("name"): dict(u[0].attrib) for u in root.iter("{*}Unit")}["N.m"] == {"kg": "1", "m": "2", "s": "-2"}
    turned = root.find(".//{*}Connection[@endElement='gripper'][@endConnector='phi']/{*}LinearTransformation")
    assert float(turned.get("factor")) == 2 and float(turned.get("offset")) == np.radians(30)
    assert root.find(".//{*}DefaultExperiment").get("stopTime") == "1.2"


def test_the_osp_structure_has_a_function_for_each_factor(held):
    root = etree.parse(str(held / "OspSystemStructure.xml")).getroot()
    order = [element.tag.split("}")[1] for element in root]
    assert order == ["StartTime", "EndTime", "BaseStepSize", "Algorithm", "Simulators", "Functions", "Connections"]
    functions = {f.get("name"): (float(f.get("factor")), float(f.get("offset"))) for f in root.iter("{*}LinearTransformation")}
    assert sorted(functions.values()) == [(2.0, 0.0)] * 3 + [(2.0, np.radians(30))]
    signals = [(s.get("function"), s.get("name")) for s in root.iter("{*}Signal")]
    assert sorted(signals) == sorted((name, end) for name in functions for end in ("in", "out"))


def test_interpolation_has_order_two_and_gains_a_hundredfold(tmp_path):
    # The loom: 231 rad/s of elastic loads on the shaft.
    ends = {}
    for exchange in ("interpolated", "held"):
        folder = write(tmp_path / exchange, "loom", exchange=exchange, step="0.25 ms", stop="0.2 s")
        ends[exchange] = {h: run(folder, h)["machine.w"][-1] for h in (5e-4, 2.5e-4, 3.125e-5)}
    exact = ends["interpolated"][3.125e-5]
    errors = {exchange: [abs(of[h] - exact) for h in (5e-4, 2.5e-4)] for exchange, of in ends.items()}
    assert errors["interpolated"][0] / errors["interpolated"][1] > 3.5, errors
    assert errors["held"][1] > 20 * errors["interpolated"][1], errors


def test_fmpy_holds_values_and_leaves_out_the_factors(held):
    ssp = str(held / "two_cams.ssp")
    ours = run(held, 1e-3)["machine.w"]
    theirs = simulate_ssp(ssp, stop_time=1.2, step_size=1e-3, parameter_set=start_values(ssp))["machine.w"]
    # The gripper of ratio 2 turns as slow as the machine, and the first step begins at 0.
    assert 1e-3 < abs(theirs[1199] - ours[1200]) < 5e-3


def in_libcosim(path, step, stop):
    execution = pytest.importorskip("libcosimpy.CosimExecution").CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    nanoseconds = lambda time: round(1e9 * time)
    is_file = Path(path).is_file()
    simulation = execution.from_ssp_file(str(path), step_size=nanoseconds(step)) if is_file else execution.from_osp_config_file(str(path))
    observer = CosimObserver.create_last_value()
    simulation.add_observer(observer)
    machine = simulation.slave_index_from_instance_name("machine")
    references = {v.name.decode(): v.reference for v in simulation.slave_variables(machine)}
    simulation.simulate_until(nanoseconds(stop))
    return observer.last_real_values(machine, [references["w"]])[0]


def test_libcosim_does_what_run_py_does_with_held_values(held):
    ours = run(held, 1e-3)["machine.w"][-1]
    for path in (held, held / "two_cams.ssp"):
        assert abs(in_libcosim(path, 1e-3, 1.2) - ours) < 1e-11


def test_ecos_does_the_same(held):
    if importlib.util.find_spec("ecospy") is None:
        pytest.skip("ecospy is not installed")
    # It needs tbb, which pip installs where the loader does not look.
    libraries = os.path.join(sys.prefix, "lib")
    code = (
        "from ecospy.EcosSimulation import EcosSimulation as E\n"
        f"s = E(ssp_path={str(held / 'two_cams.ssp')!r}, step_size=1e-3)\n"
        "s.init(parameter_set='two_cams'); s.step(1200); print(s.get_real('machine::w'))"
    )
    done = subprocess.run([sys.executable, "-c", code], env=os.environ | {"LD_LIBRARY_PATH": libraries}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert abs(float(done.stdout.split()[-1]) - run(held, 1e-3)["machine.w"][-1]) < 1e-11


def test_a_container_fmu_does_the_same_without_factors_and_start_values(tmp_path):
    pytest.importorskip("fmu_manipulation_toolbox")
    source = tmp_path / "source"
    shutil.copytree(ROOT / "examples" / "two_cams", source)
    lines = (source / "system.toml").read_text().splitlines()
    lines = [line for line in lines if line.split(" = ")[0] not in ("start", "ratio", "offset")]
    (source / "system.toml").write_text("\n".join(["exchange = 'held'", *lines]))
    with open(source / "machine.toml", "a") as machine:
        machine.write('\n[start]\nw_start = "200 rpm"\n')
    folder = tmp_path / "target"
    subprocess.run([CAMDRIVE, "system", source / "system.toml", "-o", folder], check=True, capture_output=True)
    code = "from fmu_manipulation_toolbox.cli.fmucontainer import fmucontainer; fmucontainer()"
    options = ["-container", "two_cams.ssp:0.001", "-fmu-directory", "."]
    subprocess.run([sys.executable, "-c", code, *options], cwd=folder, check=True, capture_output=True)
    fmu = str(folder / "two_cams.fmu")
    result = fmpy.simulate_fmu(fmu, stop_time=1.2, step_size=1e-3, output_interval=1e-3, output=["machine.w"])
    assert abs(result["machine.w"][-1] - run(folder, 1e-3)["machine.w"][-1]) < 1e-11


@pytest.fixture(scope="module")
def backlash(tmp_path_factory):
    return write(tmp_path_factory.mktemp("backlash"), "backlash_machine")


def test_the_mean_torque_tends_to_the_train_and_balances_momentum(backlash, fmu):
    with fmu("backlash_train").unit() as train:
        train.initialise()
        for _ in range(1000):
            train.step(1e-4)
        whole = train.get("w")
    ends = []
    for step in (1e-4, 2e-5):
        r = run(backlash, step)
        ends.append(r["machine.w"][-1])
        # J (w - w0) = sum of (M_an - tau_mean of the step before) h
        driving = 0.5 * (r["machine.M_an"][1:] + r["machine.M_an"][:-1]).sum() * step
        braking = r["pusher.tau_mean"][:-1].sum() * step
        change = 0.2 * (r["machine.w"][-1] - r["machine.w"][0])
        assert abs(change - driving + braking) < 1e-4 * abs(braking), (change, driving, braking)
        assert r["pusher.impacts"][-1] >= 3
    # Of one impact to the next the machine's own motion is that of the train but for m1 U'^2/J of the impulses.
    assert abs(ends[1] - whole) < 1e-3 and abs(ends[0] - whole) < 2e-3, (ends, whole)
