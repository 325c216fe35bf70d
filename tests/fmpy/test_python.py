"""The Python package of the wheel: every function on an example, its errors, and both engines of `simulate`."""

import math
import os
import pickle
import re
import shutil
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas
import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WHEEL = os.environ.get("CAMDRIVE_WHEEL")
GUIDE_BAR = EXAMPLES / "guide_bar" / "scene.toml"
LOOM = EXAMPLES / "rapier_loom" / "scene.toml"

pytestmark = pytest.mark.skipif(not WHEEL, reason="CAMDRIVE_WHEEL names no wheel")


def refused(kind, call, *arguments, **keywords):
    """The exception of this call, which is of this kind and of no derived one."""
    with pytest.raises(kind) as caught:
        call(*arguments, **keywords)
    assert type(caught.value) is kind
    return caught.value


# Reports


def answers(report):
    """Whether the answer has all that holds and all that is to be done."""
    said = [*report.verdict["result"], *(advice["text"] for advice in report.verdict["advice"])]
    return said and all(sentence in report.answer for sentence in said)


def test_check_has_the_figures_of_a_design(camdrive):
    report = camdrive.check(GUIDE_BAR)
    assert repr(report).startswith("guide_bar\nNo errors") and report.verdict["level"] == "good"
    figures = report.table("figures").set_index("name")
    # 1800 rpm; 12 kg at 270 Hz.
    assert figures["value"]["speed"] == pytest.approx(60 * math.pi, rel=1e-12)
    assert report.ok is True and report.files == {} and report.svg == {}
    assert "resonances" in report.tables and "resonances" in dir(report)
    with pytest.raises(AttributeError, match="no objective, but .*figures"):
        report.objective


def test_check_takes_systems_and_verify_fmus(camdrive, tmp_path):
    report = camdrive.check(GUIDE_BAR.parent.parent / "two_cams" / "system.toml")
    assert repr(report).startswith("two_cams\nNo fault") and "connections" in report.tables
    fmu = camdrive.export(GUIDE_BAR, tmp_path / "bar.fmu")
    report = camdrive.verify(fmu)
    assert report.agrees is True and "outputs" in report.tables and "agree up to" in repr(report)
    (tmp_path / "no.fmu").write_text("none")
    assert "no.fmu" in str(refused(camdrive.Error, camdrive.verify, tmp_path / "no.fmu"))


def test_a_page_is_text_that_notebooks_show(camdrive, tmp_path):
    page = camdrive.report(GUIDE_BAR, output=tmp_path / "bar.html")
    assert page == (tmp_path / "bar.html").read_text() == page._repr_html_() and "Characteristic values" in page
    assert len(repr(page)) < 100 and camdrive.report(GUIDE_BAR) == page
    (tmp_path / "mine.html").write_text("mine")
    assert "mine.html" in str(refused(camdrive.Error, camdrive.report, GUIDE_BAR, output=tmp_path / "mine.html"))
    assert camdrive.report(GUIDE_BAR, output=tmp_path / "mine.html", force=True) == page
    study = camdrive.study(GUIDE_BAR, {"m": [11, 12]}, "max |q|", turns=1)
    assert "2 runs" in study._repr_html_()
    assert camdrive.study(GUIDE_BAR, {"m": [11, 12]}, "max |q|", turns=1, explain=True)._repr_html_() is None


def test_a_system_is_written_and_studied(camdrive, tmp_path):
    file = EXAMPLES / "two_cams" / "system.toml"
    written = camdrive.system(file, output=tmp_path)
    assert {"machine.fmu", "pusher.fmu", "two_cams.ssp", "run.py"} <= set(written.files) == {p.name for p in tmp_path.iterdir()}
    assert written.shafts[0]["machine"] == "machine" and "connections" in written.tables
    study = camdrive.system(file, study=True)
    rows = study.table("rows")
    assert set(rows["exchange"]) == {"held", "extrapolated", "gauss_seidel", "interpolated"} and answers(study)
    assert study.plot().startswith("<svg") and study._repr_html_().count("<h1") == 1
    wrong = Path(shutil.copytree(file.parent, tmp_path / "copy")) / "wrong.toml"
    wrong.write_text(file.read_text().replace('shaft = "machine"', 'shaft = "nothing"'))
    assert "nothing" in str(refused(camdrive.SceneError, camdrive.system, wrong))


def test_describe_has_the_variables(camdrive):
    report = camdrive.describe(LOOM)
    variables = report.table("variables").set_index("name")
    assert variables["items"]["solver.method"] == ["adaptive", "fixed_cost"]
    assert variables["unit"]["w"] == "rad/s" and report.summary in repr(report)


def test_steady_finds_a_motion_or_none(camdrive):
    report = camdrive.steady(LOOM, period="120 ms")
    assert "runs at 500 rpm" in repr(report)
    (motion,) = report.motions
    assert motion["period"] == pytest.approx(0.12, rel=1e-9) and motion["stable"]
    course = report.table("rapier_loom.steady.csv")
    course = course[course["motion"] == "1 (stable)"]
    assert course["w_rpm"].max() * math.pi / 30 == pytest.approx(motion["largest_speed"], rel=1e-4)
    assert report.plot().startswith("<svg") and report.plot()._repr_svg_() == report.svg["rapier_loom.steady"]
    stalled = camdrive.steady(LOOM, load=4000)
    assert stalled.motions == [] and stalled.load == 4000 and "stalls" in repr(stalled)


def test_stability_takes_several_speeds(camdrive):
    scene = EXAMPLES / "transfer_manipulator" / "hs3.toml"
    report = camdrive.stability(scene, quick=True, speed=["60 rpm", 9.5], from_="30 rpm", to="200 rpm")
    assert list(report.table("speeds")["speed"]) == pytest.approx([2 * math.pi, 9.5])
    assert answers(report)
    assert "transfer_hs3.load" in repr(report) and report.plot("load").startswith("<svg")


def test_forces_where_a_follower_stays_and_where_it_leaves(camdrive):
    report = camdrive.forces(EXAMPLES / "sealing_machine" / "scene.toml")
    quantities = report.table("drives.quantities")
    of_first = quantities[quantities["drives.name"] == "sealing_machine.follower1"].set_index("quantity")
    course = report.table("sealing_machine.follower1.csv")
    assert of_first["largest.value"]["roller_force_F"] == pytest.approx(course["roller_force_F_N"].max(), rel=1e-3)
    assert report.plot() == report.svg["sealing_machine.torque"] != report.plot("follower2.roller_force")
    assert "follower1.roller_force, " in str(refused(camdrive.Error, report.plot, "roller_force"))
    assert "0 diagrams are called speed" in str(refused(camdrive.Error, report.plot, "speed"))
    assert "drives.quantities" in str(refused(camdrive.Error, report.table, "quantities"))
    # It leaves its cam at this speed: a result, too.
    left = camdrive.forces(EXAMPLES / "valve_train" / "scene.toml")
    speed = left.drives[0]["keeping"]["lift_off_speed"]["value"]
    assert speed < left.speed and answers(left) and left.verdict["level"] == "bad"
    assert "lifts off its cam" in left.messages
    slower = camdrive.forces(EXAMPLES / "valve_train" / "scene.toml", speed=0.99 * speed)
    assert slower.verdict["level"] != "bad"


def test_tradeoff_advises(camdrive):
    report = camdrive.tradeoff(GUIDE_BAR, turns=1, quick=True)
    assert answers(report)
    assert (report.table("settings")["error"] < 1e-10).all() and report.plot() == report.svg["guide_bar.work_precision"]


def test_synthesis_and_compensation_make_scenes(camdrive, tmp_path):
    folder = EXAMPLES / "loom"
    task = camdrive.synthesize(folder / "task.toml", scene=folder / "scene.toml", output=tmp_path / "task")
    assert answers(task) and list(task.table("laws")["name"]) == ["tools_gripper", "tools_sley"]
    assert {place.name: place.read_bytes() for place in (tmp_path / "task").iterdir()} == task.files
    assert camdrive.check(tmp_path / "task" / "profile.toml").model == "RigidMachine"
    report = camdrive.compensate(LOOM, output=tmp_path / "loom")
    deviations = report.table("finished.tools")["deviation"].abs()
    assert deviations.max() < 1e-5 < report.table("rounds.tools")["deviation"].abs().max()
    assert answers(report) and report.plot() == report.svg["rapier_loom.speed"]
    # The tool's own check of the result.
    assert camdrive.check(tmp_path / "loom" / "compensated.toml").name == "rapier_loom_hs"
    again = camdrive.compensate(LOOM, period="0.12 s")
    assert again.period == pytest.approx(0.12, rel=1e-9) and b"[follower.cam]" in again.files["compensated.toml"]


def test_files_of_others_are_none_of_a_report(camdrive, tmp_path):
    (tmp_path / "mine.csv").write_text("1")
    first = camdrive.steady(LOOM, output=tmp_path)
    second = camdrive.steady(LOOM, output=tmp_path)
    parts = ("steady.csv", "turn.csv", "steady.svg", "motion.svg", "motor.svg", "json", "html")
    assert first.files == second.files and set(first.files) == {f"rapier_loom.{part}" for part in parts}
    assert (tmp_path / "rapier_loom.steady.csv").read_bytes() == first.files["rapier_loom.steady.csv"]


def test_clearance_compares_laws(camdrive):
    scene = EXAMPLES / "backlash_drive" / "scene.toml"
    report = camdrive.clearance(scene, quick=True, turns=4, compare=["hs3", "hs7"])
    assert list(report.table("laws")["law"]) == ["scene", "hs3", "hs7"]
    assert answers(report)
    passages = report.table("laws.passages")
    assert len(passages[passages["laws.law"] == "scene"]) == 2 and (passages["model.impulse"] > 0).all()
    assert passages["k"][0] == report.laws[0]["passages"][0]["k"]


def test_cam_has_contours_and_findings(camdrive):
    report = camdrive.cam(EXAMPLES / "tappet" / "scene.toml")
    assert "tappet can be cut" in repr(report) and report.plot() == report.svg["tappet"]
    findings = report.table("followers.cams.findings")
    assert set(findings["followers.name"]) == {"tappet"} and (findings["verdict"] == "good").all()
    contour, steps = report.table("tappet.csv"), report.table("tappet.plcopen.csv")
    assert contour["centre_r_mm"].min() * 1e-3 == pytest.approx(report.followers[0]["cams"][0]["findings"][3]["value"])
    assert "SlavePosition[mm]" in steps and report.files["tappet.dxf"].endswith(b"EOF\n")


def test_fields_of_files_are_documented(camdrive):
    page = (EXAMPLES.parent / "docs" / "json.md").read_text()
    for report in (camdrive.tradeoff(GUIDE_BAR, turns=1, quick=True), camdrive.cam(EXAMPLES / "tappet" / "scene.toml")):
        command = "cam" if "followers" in report.data else "tradeoff"
        (section,) = (part for part in page.split("\n## ") if part.startswith(f"`{command}`"))
        names = {name for table in report.tables if ".csv" not in table and not table.startswith("verdict") for name in report.table(table)}
        # What is by the names of outputs has the name of their field.
        fields = {part for name in names if "." not in name or "cost." in name for part in name.split(".")}
        assert len(fields) > 10 and [field for field in fields if f"`{field}`" not in section] == [], command


def test_reports_pass_from_one_process_to_another(camdrive):
    report = camdrive.steady(LOOM)
    again = pickle.loads(pickle.dumps(report))
    assert again == report and again.motions == report.motions and repr(again) == repr(report)


def test_faults_are_exceptions(camdrive, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(GUIDE_BAR.read_text().replace('"12 kg"', '"12 mm"').replace("0.03", "-1"))
    calls = [camdrive.check, camdrive.describe, camdrive.steady, camdrive.stability, camdrive.forces, camdrive.tradeoff]
    for call in [*calls, camdrive.compensate, camdrive.clearance, camdrive.cam, camdrive.simulate]:
        error = refused(camdrive.SceneError, call, wrong)
        assert "12 mm" in str(error)
        assert [d.key for d in error.diagnostics] == ["elasticity.m", "elasticity.damping_ratio"], call
    assert "missing.toml" in str(refused(camdrive.SceneError, camdrive.check, tmp_path / "missing.toml"))
    assert "a scene, not a task" in str(refused(camdrive.Error, camdrive.synthesize, wrong))
    # A good scene, and a command that is not for it; options that do not exist or have no such value.
    assert "are for a RigidMachine" in str(refused(camdrive.Error, camdrive.steady, GUIDE_BAR, load=1.0))
    assert "looad" in str(refused(camdrive.Error, camdrive.steady, LOOM, looad=3))
    assert "3 kg" in str(refused(camdrive.Error, camdrive.steady, LOOM, load="3 kg"))
    assert "-o" in str(refused(camdrive.Error, camdrive.forces, LOOM, output=wrong))
    assert "Usage:" in str(refused(camdrive.Error, camdrive.steady, LOOM, help=True))


# Simulation


ELASTIC = ["guide_bar", "transfer_manipulator", "backlash_drive", "rod_drive"]
WITH_SHAFT = ["rapier_loom", "valve_train", "crank_press"]


@pytest.mark.parametrize("scene", [*ELASTIC, *WITH_SHAFT])
def test_both_engines_simulate_the_same(camdrive, scene):
    path = EXAMPLES / scene / "scene.toml"
    keywords = {"stop_time": 0.05, "step": 5e-4}
    native, fmu = camdrive.simulate(path, **keywords), camdrive.simulate(path, **keywords, engine="fmpy")
    assert native.dtype.names == fmu.dtype.names and len(native) == len(fmu) == 101
    assert native.units == fmu.units and native.descriptions == fmu.descriptions
    for name in native.dtype.names:
        ours, theirs = native[name].astype(float), fmu[name].astype(float)
        assert np.abs(ours - theirs).max() <= 1e-12 * np.abs(theirs).max(), name


def test_values_have_units_and_names(camdrive):
    def simulated(path=GUIDE_BAR, **keywords):
        return camdrive.simulate(path, stop_time=0.01, step=1e-3, **keywords)

    speed = {"start_values": {"drive.w": "2000 rpm"}, "output": "y"}
    assert (simulated(**speed) == simulated(start_values={"drive.w": 2000 * math.pi / 30}, output=["y"])).all()
    assert len(camdrive.simulate(GUIDE_BAR, output="y", stop_time="10 ms", step="2 ms")) == 6
    method = {"solver.method": "fixed_cost"}
    native, fmu = (simulated(LOOM, start_values=method, engine=engine) for engine in ("native", "fmpy"))
    assert np.allclose(native["w"], fmu["w"], rtol=1e-12) and (native != simulated(LOOM)).any()
    assert (fmu == simulated(LOOM, start_values={"solver.method": 2}, engine="fmpy")).all()


def test_inputs_come_from_an_array(camdrive):
    course = np.zeros(101, [(name, float) for name in ("time", "phi", "w", "a")])
    course["time"] = np.linspace(0, 0.1, 101)
    course["w"], course["phi"], course["a"] = 2e3 * course["time"], 1e3 * course["time"] ** 2, 2e3
    path = EXAMPLES / "guide_bar" / "run_up.toml"
    native, fmu = (
        camdrive.simulate(path, input=course, stop_time=0.1, step=1e-3, engine=engine) for engine in ("native", "fmpy")
    )
    # Both know the input at the communication points.
    assert np.abs(native["y"] - fmu["y"]).max() < 1e-9 * np.abs(fmu["y"]).max() and np.ptp(native["y"]) > 1e-4
    for wrong in (np.zeros(3), course[["phi", "w", "a"]], pandas.DataFrame(course)):
        assert "`time`" in str(refused(camdrive.Error, camdrive.simulate, path, input=wrong))
    course.dtype.names = ("time", "phi", "w", "b")
    for engine in ("native", "fmpy"):
        error = refused(camdrive.SimulationError, camdrive.simulate, path, input=course, engine=engine)
        # A parameter, but no input.
        assert "b" in re.findall(r"\w+", str(error))


def test_a_result_keeps_its_units(camdrive):
    result = camdrive.simulate(GUIDE_BAR, output=["y", "tau"], stop_time=0.01, step=1e-3)
    again = pickle.loads(pickle.dumps(result))
    for part in (result[3:], result[["time", "y"]], result[result["time"] > 0.005], again, result.copy()):
        assert isinstance(part, camdrive.Result)
        assert part.units == {"time": "s", "y": "m", "tau": "N.m"} and "torque" in part.descriptions["tau"].lower()
    assert (again == result).all() and type(result["y"]) is np.ndarray
    table = pandas.DataFrame(result)
    assert list(table) == ["time", "y", "tau"] and (table["y"] == result["y"]).all()


@pytest.mark.parametrize("engine", ["native", "fmpy"])
def test_the_variable_at_fault_is_named(camdrive, engine):
    def message(path=GUIDE_BAR, **keywords):
        return str(refused(camdrive.SimulationError, camdrive.simulate, path, engine=engine, **keywords))

    assert "nothing" in message(nothing=1.0)
    assert "nowhere" in message(output=["y", "nowhere"])
    assert "`m`" in message(m=-1.0)
    assert "drive.w" in message(start_values={"drive.w": "fast"})
    said = message(LOOM, start_values={"solver.method": "magic"})
    assert "solver.method" in said and "adaptive" in said and "fixed_cost" in said


def test_fmus_and_systems_are_simulated_as_scenes_are(camdrive, tmp_path):
    fmu = camdrive.export(GUIDE_BAR, tmp_path / "one.fmu")
    keywords = {"start_values": {"drive.w": "2000 rpm"}, "stop_time": "10 ms"}
    scene, other = (camdrive.simulate(path, **keywords) for path in (GUIDE_BAR, fmu))
    assert (scene == other).all() and scene.units == other.units and scene.descriptions == other.descriptions
    system = EXAMPLES / "two_cams" / "system.toml"
    result = camdrive.simulate(system, output=["machine.w", "pusher.q"], stop_time=0.1, step=1e-3)
    assert result.units == {"time": "s", "machine.w": "rad/s", "pusher.q": "m"} and len(result) == 101
    fine = camdrive.simulate(system, output=["machine.w", "pusher.q"], stop_time=0.1, step=1e-4)
    for name in ("machine.w", "pusher.q"):
        assert np.abs(result[name] - fine[name][::10]).max() < 1e-5 * np.abs(fine[name]).max()


def test_engines_that_do_not_fit_are_refused(camdrive, tmp_path):
    fmu = camdrive.export(GUIDE_BAR, tmp_path / "one.fmu")
    assert '"native" or "fmpy"' in str(refused(camdrive.Error, camdrive.simulate, GUIDE_BAR, engine="Native"))
    text = {"start_values": {"drive.w": "2000 rpm"}, "engine": "fmpy"}
    error = refused(camdrive.SimulationError, camdrive.simulate, fmu, **text)
    assert "`drive.w` = '2000 rpm'" in str(error) and "a number in rad/s" in str(error) and "native" in str(error)
    late = {"stop_time": "10 ms", "engine": "fmpy"}
    assert "stop_time" in str(refused(camdrive.SimulationError, camdrive.simulate, fmu, **late))


def test_numbers_without_the_unit_of_an_fmu_are_refused(camdrive, tmp_path):
    fmu = camdrive.export(EXAMPLES / "guide_bar" / "run_up.toml", tmp_path / "si.fmu")
    unit = '<Unit name="U/min"><BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></Unit>'
    other = tmp_path / "rpm.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                head, tail = content.decode().split('name="w"', 1)
                tail = tail.replace('unit="rad/s"', 'unit="U/min"', 1).replace(' displayUnit="rpm"', "", 1)
                content = (head.replace("<UnitDefinitions>", "<UnitDefinitions>" + unit) + 'name="w"' + tail).encode()
            new.writestr(name, content)
    course = np.zeros(2, [(name, float) for name in ("time", "w")])
    course["time"], course["w"] = [0, 0.1], [10, 10]
    common = {"stop_time": 0.1, "step": 1e-3, "output": ["y"]}
    for engine in ("native", "fmpy"):
        for keywords in ({"input": course}, {"start_values": {"w": 10.0}}):
            error = refused(camdrive.SimulationError, camdrive.simulate, other, engine=engine, **keywords, **common)
            assert "SI or in U/min" in str(error)
    start = {"start_values": {"w": "10 U/min"}}
    native, fmpy = (camdrive.simulate(other, engine=engine, **start, **common) for engine in ("native", "fmpy"))
    assert np.abs(native["y"] - fmpy["y"]).max() < 1e-9 * np.abs(fmpy["y"]).max()


DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="bad" guid="g"><CoSimulation modelIdentifier="bad"/>
<DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/><ModelVariables>
<ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable></ModelVariables><ModelStructure/>
</fmiModelDescription>"""


def test_a_foreign_fmu_that_fails_names_its_cause(camdrive, tmp_path):
    fmu = tmp_path / "bad.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        for library in ("linux64/bad.so", "aarch64-linux/bad.so", "win64/bad.dll", "darwin64/bad.dylib"):
            archive.writestr(f"binaries/{library}", "no library")
    error = refused(camdrive.SimulationError, camdrive.simulate, fmu, timeout="5 s")
    assert "its library cannot be loaded" in str(error) and "scene" not in str(error)
    measured = {"measures": "last y", "time": "1 s", "timeout": 5}
    error = refused(camdrive.Error, camdrive.study, fmu, {"y": [1.0]}, **measured)
    assert "its library cannot be loaded" in str(error)


def test_threads_simulate_natively(camdrive):
    def last(speed):
        return camdrive.simulate(GUIDE_BAR, output="y", stop_time=0.01, step=1e-3, **{"drive.w": speed})["y"][-1]

    speeds = [150.0 + i for i in range(8)]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(last, speeds)) == [last(speed) for speed in speeds]
