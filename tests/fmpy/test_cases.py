"""Inputs that once gave wrong answers, with the right ones: each in `cases` beside what it is compared with. The values at the end of
a run (`right_at_end` of `numbers/*.json`) come from a Taylor integration in 80 bits."""

import json
import math
import subprocess

import pytest
from conftest import CAMDRIVE, ROOT, Package

CASES = ROOT / "tests/fmpy/cases"
RUNS = sorted((CASES / "numbers").glob("*.json"))
assert RUNS


def told(*arguments):
    return json.loads(subprocess.run([CAMDRIVE, *map(str, arguments)], check=True, capture_output=True).stdout)


def packed(scene, folder):
    path = folder / "case.fmu"
    subprocess.run([CAMDRIVE, "export", scene, "-o", path], check=True, capture_output=True)
    return Package(path, folder / "case")


@pytest.mark.parametrize("case", RUNS, ids=lambda path: path.stem)
def test_a_run_ends_within_its_estimate(case, tmp_path):
    known = json.loads(case.read_text())
    package = packed(case.with_suffix(".toml"), tmp_path)
    with package.unit() as unit:
        unit.slave.setupExperiment(tolerance=known["tolerance"], startTime=known["times"][0])
        unit.time = known["times"][0]

        def apply(inputs):
            for name, [value, *derivatives] in inputs.items():
                reference = package.variables[name].valueReference
                unit.set(**{name: value})
                if derivatives:
                    orders = list(range(1, len(derivatives) + 1))
                    unit.slave.setRealInputDerivatives([reference] * len(orders), orders, derivatives)

        steps = known["inputs"] or [{}] * (len(known["times"]) - 1)
        # FMI takes derivatives of inputs in step mode only.
        apply({name: values[:1] for name, values in steps[0].items()})
        unit.slave.enterInitializationMode()
        unit.slave.exitInitializationMode()
        largest = {}
        for inputs, time in zip(steps, known["times"][1:]):
            apply(inputs)
            unit.step_to(time)
            largest = {name: max(abs(unit.get(name)), largest.get(name, 0.0)) for name in known["outputs"]}
        estimate = unit.get("solver.error_estimate")
        for name, right in zip(known["outputs"], map(float, known["right_at_end"])):
            # The estimate is of the state; what impacts add up is sums of small parts.
            bound = 1e-11 if name in ("impulse", "energy_loss") else estimate
            assert abs(unit.get(name) - right) <= bound * largest[name], name
        assert estimate < 1e-8


def test_a_cycle_has_the_characteristic_values_of_its_law():
    motions = told("check", "--json", CASES / "numbers/polynomial_4567_cycle.toml")[0]["motions"]
    for motion, start in zip(motions, (0.0, 2.6), strict=True):
        assert motion["velocity"] == pytest.approx(35 / 16, rel=1e-12) and motion["jerk"] == pytest.approx(52.5, rel=1e-12)
        for key, peak in (("acceleration", 84 * math.sqrt(5) / 25), ("torque", 10.750226164)):
            assert list(map(abs, motion[key])) == pytest.approx([peak] * 2, rel=1e-10)
        assert motion["from"] == pytest.approx(start, abs=1e-12)


def numbers(value):
    """All numbers of a document in their order."""
    if isinstance(value, dict):
        return [number for part in value.values() for number in numbers(part)]
    if isinstance(value, list):
        return [number for part in value for number in numbers(part)]
    return [value] if isinstance(value, (int, float)) else []


def test_extremes_do_not_depend_on_the_origin_of_the_angle():
    own, moved = (told("check", "--json", CASES / f"sampled_extremes/{name}.toml")[0] for name in ("check_resonance", "check_resonance_rotated"))
    for key in ("figures", "resonances"):
        assert numbers(own[key]) == pytest.approx(numbers(moved[key]), rel=1e-9)
    own, moved = (
        told("steady", "--json", "--period", "1.5 s", CASES / f"sampled_extremes/{name}.toml")["without_torques"]
        for name in ("steady_without_torques", "steady_without_torques_rotated")
    )
    assert numbers(own) == pytest.approx(numbers(moved), rel=1e-12)


def test_a_machine_starts_with_the_energy_of_its_angle(tmp_path):
    """dE/dφ = M_an; E is that of the periodic motion, which it meets again after a turn."""
    package = packed(CASES / "steady_start_angle/scene.toml", tmp_path)
    period = told("steady", "--json", CASES / "steady_start_angle/scene.toml")["motions"][0]["period"]
    for degrees in (200.0, -10.0, 0.0, 90.0, 1000.0):
        with package.unit() as unit:
            unit.initialise(values={"phi_start": math.radians(degrees)})
            before = unit.get("E")
            unit.step(period)
            assert unit.get("E") == pytest.approx(before, rel=1e-11) and unit.get("phi") == pytest.approx(math.radians(degrees) + math.tau)


def test_backwards_the_drive_is_the_mirrored_one(tmp_path):
    """Free motions at −2 rad/s grow by e^0.312 in a turn."""
    studied = lambda name, *more: told(
        "stability", "--json", "--quick", "-o", tmp_path / name, CASES / f"turns_backwards/{name}.toml", *more
    )["speeds"][0]
    own, image = studied("scene"), studied("mirrored")
    assert math.log(own["radius"]) == pytest.approx(0.312, abs=5e-4)
    assert numbers(own["multipliers"]) == pytest.approx(numbers(image["multipliers"]), rel=1e-9)
    own, image = studied("varying_mass", "--speed", "-1.9"), studied("varying_mass_mirrored")
    assert numbers(own["multipliers"]) == pytest.approx(numbers(image["multipliers"]), rel=1e-9)
