"""The drive with backlash against exact phases in multiple precision, and its balances."""

import math
import re

import numpy as np
import pytest

import reference

LINE = re.compile(r"t = ([-+0-9.e]+) s: (release|impact)")


def switching(unit):
    """(kind, time) of the logged events."""
    found = (LINE.search(text) for _, category, text in unit.log if category == "logEvents")
    return [(m.group(2), float(m.group(1))) for m in found if m]


@pytest.fixture(scope="module")
def truth(fmu):
    package = fmu("backlash_drive")
    p = package.parameters()
    return reference.Backlash(p, reference.Series.of(package)).run(0.5)


@pytest.mark.parametrize("size", [1e-4, 1e-3, 1e-2, 0.5])
def test_switching_instants_and_states(fmu, truth, size):
    package = fmu("backlash_drive")
    events, state = truth
    with package.unit() as unit:
        unit.initialise()
        for _ in range(round(0.5 / size)):
            unit.step(size)
        got = np.array(unit.get("x1", "der(x1)", "y", "der(y)"))
        impulse, impacts = unit.get("impulse", "impacts")
        logged = switching(unit)
    expected = [(kind, float(t)) for t, kind, _ in events]
    assert [k for k, _ in logged] == [k for k, _ in expected]
    assert max(abs(a - b) for (_, a), (_, b) in zip(logged, expected)) <= 1e-12
    total = float(sum(abs(i) for _, _, i in events))
    assert abs(impulse - float(sum(i for _, _, i in events))) <= 1e-10 * total
    assert impacts == sum(kind == "impact" for kind, _ in expected)
    assert np.all(np.abs(got - state) <= 1e-10 * np.array([1e-2, 1.0, 1e-2, 1.0]))


def test_microsecond_steps_and_ten_turns_in_one_step(fmu):
    package = fmu("backlash_drive")
    names = ("x1", "der(x1)", "y", "der(y)", "impulse", "impacts")
    turn = 2 * math.pi / package.start("drive.w")
    for span, size in ((0.1, 1e-6), (10 * turn, turn / 200)):
        results = []
        for count in (1, round(span / size)):
            with package.unit() as unit:
                unit.initialise()
                for i in range(count):
                    unit.step_to(span * (i + 1) / count)
                results.append(np.array(unit.get(*names), dtype=float))
        assert results[0][-1] == results[1][-1]
        assert np.all(np.abs(results[0] - results[1]) <= 1e-10 * np.array([1e-2, 1.0, 1e-2, 1.0, 1.0, 1.0]))


@pytest.mark.parametrize("e", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("b", [0.0, 60.0, 1e6, 1e9])
def test_momentum_over_many_turns(fmu, e, b):
    """m1 v1 + m2 v2 changes by the sum of force_mean h, whatever happens inside the steps."""
    package = fmu("backlash_drive")
    p = package.parameters()
    with package.unit() as unit:
        unit.initialise(values={"e": e, "b": b})
        momentum = lambda: p["m1"] * unit.get("der(x1)") + p["m2"] * unit.get("der(y)")
        start, received, scale = momentum(), 0.0, 0.0
        for _ in range(2000):
            unit.step(2e-3)
            received += 2e-3 * unit.get("force_mean")
            scale = max(scale, abs(momentum()))
            gap = unit.get("gap")
            assert -1e-15 <= gap <= p["s"] + 1e-15
        assert abs(momentum() - start - received) <= 1e-10 * scale


def test_energy_over_many_turns(fmu):
    """With b = 0 the energy of the masses and the spring changes by the work of the drive less the impact losses."""
    package = fmu("backlash_drive")
    p = package.parameters()
    with package.unit() as unit:
        unit.initialise(values={"e": 0.3})

        def energy():
            v1, v2, q = unit.get("der(x1)", "der(y)", "q")
            return p["m1"] * v1 * v1 / 2 + p["m2"] * v2 * v2 / 2 + p["c"] * q * q / 2

        start, work, scale = energy(), 0.0, 0.0
        for _ in range(1000):
            unit.step(2e-3)
            part = 2e-3 * p["drive.w"] * unit.get("tau_mean")
            work, scale = work + part, scale + abs(part)
        assert abs(energy() - start - work + unit.get("energy_loss")) <= 1e-10 * scale


def test_without_clearance_the_mass_stays_on_the_cam(fmu):
    package = fmu("backlash_drive")
    p = package.parameters()
    series = reference.Series.of(package)
    with package.unit() as unit:
        unit.initialise(values={"s": 0.0, "start.mode": 1})
        for _ in range(40):
            unit.step(7e-3)
        q, x1, impacts = unit.get("q", "x1", "impacts")
        time = unit.time
    expected = reference.elastic_output_closed(
        p["m2"], p["c"], p["b"], series, p["drive.w"], p["drive.phi_start"], 0.0, 0.0, [time]
    )[0]
    assert impacts == 0
    assert abs(q - expected[0]) <= 1e-12
    assert math.isclose(x1, series.derivative(p["drive.phi_start"] + p["drive.w"] * time, 0), abs_tol=1e-14)


def test_inputs_at_constant_speed_yield_the_same_machine(fmu):
    """Inputs phi = w t: the same events as with prescribed constant speed."""
    constant, moved = fmu("backlash_drive"), fmu("backlash_input")
    p = constant.parameters()
    with constant.unit() as a, moved.unit() as b:
        a.initialise(values={"start.mode": 1})
        b.set(phi=p["drive.phi_start"], w=p["drive.w"], a=0.0)
        b.initialise()
        for _ in range(100):
            b.set(phi=p["drive.phi_start"] + p["drive.w"] * b.time, w=p["drive.w"], a=0.0)
            a.step(1e-3)
            b.step(1e-3)
        first, second = switching(a), switching(b)
        assert [k for k, _ in first] == [k for k, _ in second] and len(first) >= 2
        assert max(abs(s - t) for (_, s), (_, t) in zip(first, second)) <= 1e-9
        for name in ("x1", "y", "der(y)", "impulse"):
            assert math.isclose(a.get(name), b.get(name), rel_tol=1e-8, abs_tol=1e-9)


def test_the_published_passage(fmu, truth):
    """The strong zero of U'' at 254.1 degrees, s = 0.05 mm, eta = 0.05: passage of 8.7 degrees."""
    events, _ = truth
    p = fmu("backlash_drive").parameters()
    angle = lambda t: math.degrees(p["drive.phi_start"] + p["drive.w"] * float(t))
    release = next(t for t, kind, _ in events if kind == "release")
    impact = next(t for t, kind, _ in events if kind == "impact")
    assert abs(angle(release) - 254.05) < 0.1
    assert abs(angle(impact) - angle(release) - 8.7) < 0.1


@pytest.mark.parametrize("ratio", [1e-4, 1e-2, 1.0, 1e2, 1e4])
def test_momentum_for_any_mass_ratio(fmu, ratio):
    package = fmu("backlash_drive")
    p = package.parameters()
    m1 = ratio * p["m2"]
    with package.unit() as unit:
        unit.initialise(values={"m1": m1, "start.mode": 1})
        momentum = lambda: m1 * unit.get("der(x1)") + p["m2"] * unit.get("der(y)")
        start, received, scale = momentum(), 0.0, 0.0
        for _ in range(300):
            unit.step(2e-3)
            received += 2e-3 * unit.get("force_mean")
            scale = max(scale, abs(momentum()))
        assert abs(momentum() - start - received) <= 1e-12 * scale and unit.get("impacts") > 0


def test_the_start_time_does_not_matter(fmu):
    package = fmu("backlash_drive")
    with package.unit() as early, package.unit() as late:
        early.initialise()
        late.initialise(start_time=100.0)
        for _ in range(200):
            early.step(1e-3)
            late.step(1e-3)
        for name in ("x1", "y", "impulse"):
            # One rounding of t = 100 s moves the cam by 1e-14 s times its speed.
            assert math.isclose(early.get(name), late.get(name), rel_tol=1e-9, abs_tol=1e-11)


def test_a_drive_that_reverses_does_not_depend_on_the_step(fmu):
    """phi = 200 degrees + 25 t - 25 t^2 turns back at t = 0.5 s."""
    package = fmu("backlash_input")
    motion = lambda t: {"phi": math.radians(200) + 25 * t - 25 * t * t, "w": 25 - 50 * t, "a": -50.0}
    results = []
    for size in (1e-2, 1e-3, 1e-4):
        with package.unit() as unit:
            unit.set(**motion(0.0))
            unit.initialise()
            for _ in range(round(1.0 / size)):
                unit.set(**motion(unit.time))
                unit.step(size)
            results.append(unit.get("x1", "y", "impulse", "impacts"))
    for other in results[1:]:
        assert np.allclose(other, results[0], rtol=1e-8, atol=1e-11)
