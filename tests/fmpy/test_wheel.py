"""The wheel of packaging/wheels: installed into a fresh environment it exports and simulates without Rust."""

import json
import os
import subprocess
import sys
import venv
from pathlib import Path

import fmpy
import numpy
import pytest

ROOT = Path(__file__).resolve().parents[2]
WHEEL = os.environ.get("CAMDRIVE_WHEEL")
SCENE = str(ROOT / "examples" / "guide_bar" / "scene.toml")
# Where FMPy is, and all else that pip would bring with an extra.
EXTRAS = str(Path(fmpy.__file__).parents[1])

pytestmark = pytest.mark.skipif(not WHEEL, reason="CAMDRIVE_WHEEL names no wheel")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    venv.create(folder / "venv", with_pip=False)
    python = folder / "venv" / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps", "--no-index", WHEEL]
    subprocess.run(pip, check=True)
    # NumPy, on which the wheel depends, and nothing else.
    (folder / "numpy").mkdir()
    for part in Path(numpy.__file__).parents[1].glob("numpy*"):
        (folder / "numpy" / part.name).symlink_to(part)
    return folder


def output(home, *command, path=None):
    """What a command of the environment prints; no cargo and no rustc are in its PATH."""
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": path or str(home / "numpy")}
    command = [str(home / "venv" / "bin" / command[0]), *command[1:]]
    done = subprocess.run(command, cwd=home, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_executable_finds_its_libraries_and_brings_completions(home):
    version, commit, platforms = output(home, "camdrive", "--version").splitlines()
    assert version.startswith("camdrive ") and commit.startswith("commit: ")
    assert "linux64" in platforms
    (fmu,) = json.loads(output(home, "camdrive", "export", "--json", SCENE))
    assert (home / fmu["fmu"]).stat().st_size == fmu["size"] <= 4_000_000
    assert "linux64" in [library["platform"] for library in fmu["platforms"]]
    completions = ["bash-completion/completions/camdrive", "zsh/site-functions/_camdrive"]
    for place in [*completions, "camdrive/licenses/THIRD-PARTY.txt"]:
        assert (home / "venv" / "share" / place).stat().st_size > 1000


def test_the_wheel_has_the_documentation_and_the_examples(home):
    doc = home / "venv" / "share" / "doc" / "camdrive"
    readme = (doc / "README.md").read_text()
    assert readme == (ROOT / "README.md").read_text()
    # What its links name of the scene is there, too.
    for place in ["docs/scene.md", "docs/task.md", "docs/json.md"]:
        assert f"({place})" in readme and (doc / place).read_text() == (ROOT / place).read_text()
    listed = subprocess.run(["git", "ls-files", "examples"], cwd=ROOT, check=True, capture_output=True, text=True)
    tracked = listed.stdout.split()
    assert "examples/guide_bar/scene.toml" in tracked
    installed = [str(place.relative_to(doc)) for place in doc.glob("examples/**/*") if place.is_file()]
    # pip compiles what is Python.
    assert sorted(place for place in installed if not place.endswith(".pyc")) == sorted(tracked)
    output(home, "camdrive", "check", *(str(doc / place) for place in tracked if place.endswith("/scene.toml")))
    code = "from importlib.metadata import metadata; print(metadata('camdrive').get_payload())"
    assert "[scene reference]" in output(home, "python", "-c", code)


def test_the_wheel_names_what_it_needs(home):
    code = "from importlib.metadata import requires; print(*requires('camdrive'), sep='\\n')"
    needed = output(home, "python", "-c", code).splitlines()
    assert [name for name in needed if "extra" not in name] == ["numpy"], needed


def test_the_package_does_all_but_fmus_and_tables_with_numpy_alone(home):
    code = f"""
import camdrive
path = camdrive.export({SCENE!r}, "fmus/", platforms=["linux64"])
assert path.as_posix() == "fmus/guide_bar.fmu" and path.is_file(), path
assert len(camdrive.simulate({SCENE!r}, output="y", stop_time=0.01, step="1 ms")) == 11
report = camdrive.check({SCENE!r})
print(report)
for call in (lambda: camdrive.simulate(path, engine="fmpy"), lambda: report.table("figures")):
    try:
        call()
    except camdrive.Error as error:
        print(error)
"""
    # Nothing is on PyPI that an extra could be of.
    said = output(home, "python", "-c", code)
    assert "guide_bar" in said and "pip install fmpy\n" in said and "pip install pandas\n" in said


def test_the_package_simulates_scenes_and_fmus(home):
    code = f"""
import camdrive
scene = camdrive.simulate({SCENE!r}, output=["y"], stop_time=0.01, step=1e-3, engine="fmpy")
assert scene.dtype.names == ("time", "y") and len(scene) == 11, scene
whole = camdrive.simulate({SCENE!r}, output="y", engine="fmpy")
assert whole.dtype.names == ("time", "y") and len(whole) > 100 and whole["time"][-1] > 0.1, whole
fmu = camdrive.export({SCENE!r}, "one.fmu")
for engine in ("native", "fmpy"):
    same = camdrive.simulate(fmu, output=["y"], stop_time=0.01, step=1e-3, engine=engine)
    assert (same == scene).all(), engine
faster = camdrive.simulate(fmu, output=["y"], stop_time=0.01, step=1e-3, **{{"drive.w": 250}})
values = {{"drive.w": 250.0, "cam.a[2]": 1e-4}}
other = camdrive.simulate(fmu, output=["y"], stop_time=0.01, step=1e-3, start_values=values)
assert (faster != scene).any() and (faster != other).any()
"""
    output(home, "python", "-c", code, path=EXTRAS)


def test_any_thread_may_simulate_and_the_process_stays_where_it_is(home):
    code = f"""
import camdrive, os
from concurrent.futures import ThreadPoolExecutor
def forbidden(folder):
    raise AssertionError(f"the process goes to {{folder}}")
os.chdir = forbidden
fmu = camdrive.export({SCENE!r}, "threads.fmu")
def one(i, speed):
    # Relative paths count from the folder of the process, and every thread has the messages of its own FMU.
    try:
        camdrive.simulate("threads.fmu", stop_time=0.01, m=-1.0 - i, engine="fmpy")
    except camdrive.SimulationError as error:
        assert all(f"-{{i + 1}}" in message for message in error.messages) and error.messages, (i, error)
    return camdrive.simulate("threads.fmu", stop_time=0.01, step=1e-4, engine="fmpy", **{{"drive.w": speed}})
speeds = [150.0 + i for i in range(16)]
with ThreadPoolExecutor(4) as pool:
    results = list(pool.map(one, range(16), speeds))
for i, speed in enumerate(speeds):
    assert (results[i] == one(i, speed)).all()
"""
    output(home, "python", "-c", code, path=EXTRAS)


def test_names_with_a_dash_are_files_and_a_lost_temporary_folder_is_named(home):
    code = f"""
import camdrive, tempfile
assert camdrive.export({SCENE!r}, "-x.fmu", platforms="linux64").is_file()
tempfile.tempdir = "/no/such/folder"
try:
    camdrive.simulate("-x.fmu")
except camdrive.Error as error:
    print(error)
tempfile.tempdir = None
try:
    camdrive.simulate("none.fmu", engine="fmpy")
except camdrive.Error as error:
    print(error)
"""
    said = output(home, "python", "-c", code, path=EXTRAS)
    assert "TMPDIR" in said and "/no/such/folder" in said
    assert "none.fmu: No such file" in said and "Errno" not in said


def test_errors_carry_diagnostics(home):
    (home / "wrong.toml").write_text(Path(SCENE).read_text().replace('"12 kg"', '"12 mm"').replace("0.03", "-1"))
    code = f"""
import camdrive
def caught(kind, call, *arguments, **keywords):
    try:
        call(*arguments, **keywords)
    except kind as error:
        assert type(error) is kind, repr(error)
        return error
    raise AssertionError("no error")
error = caught(camdrive.SceneError, camdrive.export, "wrong.toml")
assert "12 mm" in str(error), error
assert [d.key for d in error.diagnostics] == ["elasticity.m", "elasticity.damping_ratio"], error.diagnostics
assert error.diagnostics[0].line and error.diagnostics[0].file == "wrong.toml" and error.diagnostics[0].hint
import pickle, sys
again = pickle.loads(pickle.dumps(error))
assert str(again) == str(error) and again.diagnostics == error.diagnostics
assert "missing.toml" in str(caught(camdrive.SceneError, camdrive.simulate, "missing.toml"))
assert "win32" in str(caught(camdrive.Error, camdrive.export, {SCENE!r}, platforms=["win32"]))
fmu = camdrive.export({SCENE!r}, "two.fmu")
assert "nothing" in str(caught(camdrive.SimulationError, camdrive.simulate, fmu, nothing=1.0, engine="fmpy"))
refused = caught(camdrive.SimulationError, camdrive.simulate, fmu, m=-1.0, engine="fmpy")
assert any("`m`" in message for message in refused.messages), refused
assert sys.platform != "linux" or "guide_bar" not in open("/proc/self/maps").read(), "the library is still in use"
assert str(pickle.loads(pickle.dumps(refused))) == str(refused)
"""
    output(home, "python", "-c", code, path=EXTRAS)
