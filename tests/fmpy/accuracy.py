"""Prints the errors of the exported FMUs against the references of the tests, relative to the largest value of the
motion. Run after tests/run:

    target/venv/bin/python tests/fmpy/accuracy.py
"""

import tempfile

import numpy as np

import conftest
import reference
import test_backlash
import test_elastic_output
import test_rigid_machine


def package(name):
    return conftest.Package(conftest.FMUS / f"{name}.fmu", tempfile.mkdtemp())


def report(what, got, expected, scale):
    errors = np.abs(np.array(got, dtype=float) - expected) / scale
    print(f"{what:60}", *(f"{e:8.1e}" for e in errors))


def elastic_output():
    bar = package("guide_bar")
    for case, values in test_elastic_output.CASES.items():
        for turns in (1, 1_000_000):
            span = turns * test_elastic_output.TURN
            with bar.unit() as unit:
                unit.initialise(values=values)
                unit.step_to(0.7 * span)
                unit.step_to(span)
                expected = test_elastic_output.closed(bar, values, [unit.time])[0]
                scale = test_elastic_output.size_of_motion(bar, values, span)
                report(f"elastic output, {case}, {turns} turns: q, der(q)", unit.get("q", "der(q)"), expected, scale)
    moved = package("output_input")
    p, ramp = moved.parameters(), test_elastic_output.ramp
    rhs = reference.elastic_output(p["m"], p["c"], p["b"], reference.Series.of(moved), ramp)
    expected = reference.integrate(rhs, [0.0, 0.0], np.linspace(0.0, 2.0, 101))
    for size in (1e-4, 1e-2, 2.0):
        with moved.unit() as unit:
            unit.set(phi=0.0, w=2.0, a=35.0)
            unit.initialise()
            for _ in range(round(2.0 / size)):
                unit.set(**dict(zip(("phi", "w", "a"), ramp(unit.time))))
                unit.step(size)
            got = unit.get("q", "der(q)")
        report(f"elastic output, ramp, steps of {size} s: q, der(q)", got, expected[-1], np.abs(expected).max(axis=0))


def elastic_shaft():
    press = package("transfer_hs3")
    p = press.parameters()
    motion = lambda t: (p["drive.w"] * t, p["drive.w"], 0.0)
    for linear in (False, True):
        rhs = reference.elastic_shaft(p["m"], p["J"], p["c"], p["b"], reference.Series.of(press), motion, linear)
        expected = reference.integrate(rhs, [0.0, 0.0], np.linspace(0.0, 13.0, 1301))
        for size in (1e-3, 13.0):
            with press.unit() as unit:
                unit.initialise(values={"shaft.linear": linear})
                for _ in range(round(13.0 / size)):
                    unit.step(size)
                got = unit.get("q", "der(q)")
            kind = "linear" if linear else "nonlinear"
            scale = np.abs(expected).max(axis=0)
            report(f"elastic shaft, {kind}, 10 turns, steps of {size} s: q, der(q)", got, expected[-1], scale)


def rigid_machine():
    loom = package("rapier_loom")
    _, rhs = test_rigid_machine.machine(loom)
    expected = reference.integrate(rhs, [0.0, 0.0], np.linspace(0.0, 1.2, 121))
    for size in (1e-4, 1e-2, 1.2):
        with loom.unit() as unit:
            unit.initialise(values={"start.mode": 1, "phi_start": 0.0, "w_start": 0.0})
            for _ in range(round(1.2 / size)):
                unit.step(size)
            got = unit.get("phi", "w")
        report(f"rigid machine, run-up, steps of {size} s: phi, w", got, expected[-1], np.abs(expected).max(axis=0))


def backlash():
    joint = package("backlash_drive")
    events, state = reference.Backlash(joint.parameters(), reference.Series.of(joint)).run(0.5)
    for size in (1e-4, 0.5):
        with joint.unit() as unit:
            unit.initialise()
            for _ in range(round(0.5 / size)):
                unit.step(size)
            logged = [time for _, time in test_backlash.switching(unit)]
            got = unit.get("x1", "der(x1)", "y", "der(y)")
        instants = np.max(np.abs(np.array(logged) - [float(t) for t, _, _ in events]))
        print(f"backlash, {len(logged)} switching instants, steps of {size} s: largest error {instants:.1e} s")
        report(f"backlash, state after 0.5 s, steps of {size} s", got, state, np.array([1e-2, 0.25, 1e-2, 0.25]))


if __name__ == "__main__":
    elastic_output()
    elastic_shaft()
    rigid_machine()
    backlash()
