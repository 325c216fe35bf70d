"""Studies from Python: their numbers, their stores, and their division among threads, processes and machines."""

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pandas
import pytest
from conftest import CAMDRIVE
from distributed import Client, LocalCluster
from scipy.optimize import differential_evolution

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
GUIDE_BAR = EXAMPLES / "guide_bar" / "scene.toml"

pytestmark = pytest.mark.skipif("CAMDRIVE_WHEEL" not in os.environ, reason="CAMDRIVE_WHEEL names no wheel")

# 1600 runs in 100 parts; the long ones last seconds.
SPEEDS = {"drive.w": {"from": "900 rpm", "to": "2400 rpm", "count": 1600}}
MANY = {"vary": SPEEDS, "measures": "max |q|", "turns": 10}
LONG = {**MANY, "turns": 300}


@pytest.fixture(scope="module")
def cluster(camdrive):
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:
        yield cluster


@pytest.fixture
def client(cluster):
    with Client(cluster) as client:
        client.wait_for_workers(2, timeout=60)
        yield client


@pytest.fixture(scope="module")
def many(camdrive):
    return camdrive.study(GUIDE_BAR, **MANY)


def refused(kind, call, *arguments, **keywords):
    """The message of this call's exception, which is of this kind and of no derived one."""
    with pytest.raises(kind) as caught:
        call(*arguments, **keywords)
    assert type(caught.value) is kind
    return str(caught.value)


def parts(study):
    return {place.name: place.read_bytes() for place in Path(study.folder, "runs").iterdir()}


def written(place):
    """Which file it is and when it was written: a slow machine reads it in a later second."""
    state = place.stat()
    return state.st_ino, state.st_size, state.st_mtime_ns


def waited(condition):
    end = time.monotonic() + 60
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)
    assert condition()


# Numbers and tables


def test_a_product_is_what_single_simulations_are(camdrive):
    speeds, masses = ["900 rpm", 200.0], [11, "13000 g"]
    measures = ["last y", "max |q|", "min y"]
    study = camdrive.study(GUIDE_BAR, {"drive.w": speeds, "m": masses}, measures, time="50 ms")
    assert list(study.table.index) == [0, 1, 2, 3] and (study.table["status"] == "ok").all()
    assert list(study.table["drive.w"]) == pytest.approx([30 * math.pi, 30 * math.pi, 200, 200], rel=1e-15)
    assert list(study.table["m"]) == [11, 13, 11, 13]
    for run, (speed, mass) in enumerate((speed, mass) for speed in speeds for mass in masses):
        values = {"drive.w": speed, "m": mass}
        single = camdrive.simulate(GUIDE_BAR, start_values=values, output=["y", "q"], stop_time=0.05, step=1e-5)
        row = study.table.loc[run]
        assert row["last y"] == pytest.approx(single["y"][-1], rel=1e-9)
        # Of 5000 samples, none need be at the extreme.
        assert row["max |q|"] == pytest.approx(np.abs(single["q"]).max(), rel=1e-4)
        assert row["min y"] == pytest.approx(single["y"].min(), rel=1e-4)


def test_systems_and_fmus_vary_as_scenes_do(camdrive, tmp_path):
    system = EXAMPLES / "two_cams" / "system.toml"
    speeds, masses = ["200 rpm", 30.0], [2, "4000 g"]
    vary, measures = {"machine.w_start": speeds, "pusher.m": masses}, ["last machine.w", "max |pusher.q|"]
    study = camdrive.study(system, vary, measures, time="100 ms")
    assert (study.table["status"] == "ok").all() and study.units["machine.w_start"] == "rad/s"
    for run, (speed, mass) in enumerate((speed, mass) for speed in speeds for mass in masses):
        values = {"machine.w_start": speed, "pusher.m": mass}
        single = camdrive.simulate(system, start_values=values, output=["machine.w", "pusher.q"], stop_time=0.1)
        row, most = study.table.loc[run], np.abs(single["pusher.q"]).max()
        assert row["last machine.w"] == single["machine.w"][-1] and most <= row["max |pusher.q|"] < 1.02 * most
    key = {"pusher.elasticity.natural_frequency": ["70 Hz", "80 Hz"], "part.gripper.ratio": [1, 2]}
    keyed = camdrive.study(system, key, "last pusher.q", time=0.05, step="0.5 ms")
    assert (keyed.table["status"] == "ok").all() and keyed.table["last pusher.q"].nunique() == 4
    fmu = camdrive.export(GUIDE_BAR, tmp_path / "one.fmu")
    of_fmu, of_scene = (
        camdrive.study(path, {"drive.w": ["1500 rpm"]}, "max |q|", turns=2).table for path in (fmu, GUIDE_BAR)
    )
    assert of_fmu["max |q|"][0] == pytest.approx(of_scene["max |q|"][0], rel=1e-5)
    message = refused(camdrive.Error, camdrive.study, system, {"pusher.w": [1]}, "last pusher.q", time=1)
    assert "`pusher.w` cannot vary: the input is connected" in message


def test_keys_of_the_scene_vary(camdrive, tmp_path):
    key = "elasticity.natural_frequency"
    study = camdrive.study(GUIDE_BAR, {key: ["200 Hz", "270 Hz"]}, "last q", time=0.03)
    scene = tmp_path / "scene.toml"
    for run, frequency in enumerate((200, 270)):
        scene.write_text(GUIDE_BAR.read_text().replace("270 Hz", f"{frequency} Hz"))
        single = camdrive.simulate(scene, output="q", stop_time=0.03, step=1e-3)
        assert study.table.loc[run, "last q"] == pytest.approx(single["q"][-1], rel=1e-9)
    assert study.units[key] == "Hz" and list(study.table[key]) == [200, 270]
    scene.write_text(GUIDE_BAR.read_text() + "[load]\ninput = true\n")
    flags = camdrive.study(scene, {"load.input": [True, np.bool_(False)]}, "last q", time=0.03)
    assert list(flags.table["load.input"]) == ["true", "false"] and (flags.table["status"] == "ok").all()


def test_rows_come_from_tables(camdrive):
    table = pandas.DataFrame({"drive.w": [150.0, 180.0, 150.0], "m": [11, 12, 11], "start.mode": ["at_rest"] * 3})
    study = camdrive.study(GUIDE_BAR, table, ["max |q|"], turns=2)
    again = camdrive.study(GUIDE_BAR, table.to_dict("records"), "max |q|", turns=2)
    pandas.testing.assert_frame_equal(study.table, again.table, check_exact=True)
    assert list(study.table["m"]) == [11, 12, 11] and list(study.table["start.mode"]) == [1, 1, 1]
    assert study.table["max |q|"][0] == study.table["max |q|"][2] != study.table["max |q|"][1]
    ones = camdrive.study(GUIDE_BAR, {("drive.w", "m"): table[["drive.w", "m"]].to_numpy()}, "max |q|", turns=2)
    assert (ones.table["max |q|"] == study.table["max |q|"]).all()
    measured = study.to_xarray()["max |q|"]
    assert measured.dims == ("run",) and list(measured["m"].values) == [11, 12, 11]


def test_dimensions_of_a_product(camdrive):
    vary = {
        "drive.w": np.linspace(100, 200, 3),
        ("m", "b"): [(11, 900), (12, 950)],
        "drive.phi_start": {"from": "0 deg", "to": "90 deg", "count": 4},
    }
    study = camdrive.study(GUIDE_BAR, vary, ["max |y|", "rms force"], turns=1)
    data = study.to_xarray()
    assert dict(data.sizes) == {"drive.w": 3, "run": 2, "drive.phi_start": 4}
    assert data["max |y|"].dims == ("drive.w", "run", "drive.phi_start")
    assert list(data["drive.phi_start"].values) == pytest.approx([0, math.pi / 6, math.pi / 3, math.pi / 2])
    assert data["m"].dims == ("run",) and list(data["b"].values) == [900, 950]
    for _, row in study.table.iterrows():
        where = {"drive.w": row["drive.w"], "run": [11, 12].index(row["m"]), "drive.phi_start": row["drive.phi_start"]}
        assert float(data["rms force"].sel(where)) == row["rms force"]
    assert data["rms force"].attrs["units"] == "N" == study.table.attrs["units"]["rms force"]
    assert data["m"].attrs == {"units": "kg", "long_name": study.meanings["m"]}
    assert "Force on the mass" in data["rms force"].attrs["long_name"]
    both = {("m", "b"): [(11, 900), (12, 950)], ("c", "drive.w"): [(3e7, 100), (4e7, 100), (3e7, 200)]}
    names = camdrive.study(GUIDE_BAR, both, "max |y|", turns=1).to_xarray()["max |y|"].dims
    assert names == ("m, b", "c, drive.w")


def test_samples_have_one_dimension_beside_those_of_lists(camdrive):
    vary = {"drive.w": [150, 160], "m": {"mean": "12 kg", "deviation": "0.1 kg"}, "b": {"from": 900, "to": 1000}}
    first, again, other = (
        camdrive.study(GUIDE_BAR, vary, "max |y|", turns=1, runs=50, seed=seed) for seed in (1, 1, 2)
    )
    data = first.to_xarray()
    assert dict(data.sizes) == {"drive.w": 2, "run": 50} and data["m"].dims == ("run",)
    assert abs(float(data["m"].mean()) - 12) < 0.01 and 900 < data["b"].min() < data["b"].max() < 1000
    assert first.table.equals(again.table) and not first.table["m"].equals(other.table["m"])


def test_runs_that_are_refused_are_rows(camdrive):
    study = camdrive.study(GUIDE_BAR, {"elasticity.damping_ratio": [0.03, -0.3, 0.05]}, "max |q|", turns=1)
    assert list(study.table["status"]) == ["ok", "refused", "ok"]
    assert list(study.table["max |q|"].isna()) == [False, True, False]
    assert list(study.refused.index) == [1] and "-0.3" in study.refused["message"][1]
    assert "max |q|" not in study.refused
    assert np.isnan(study.to_xarray()["max |q|"].values).tolist() == [False, True, False]
    assert "rows 3, ok 2, refused 1, failed 0, missing 0" in repr(study)


def test_a_study_is_explained_without_a_run(camdrive):
    study = camdrive.study(GUIDE_BAR, **MANY, explain=True)
    assert (study.data["rows"], study.data["parts"]) == (1600, 100) and study.data["seconds"] > 0
    assert study.folder is None and "rows 1600, parts 100" in repr(study)
    assert "explained" in refused(camdrive.Error, lambda: study.table)


def test_it_is_a_vectorised_function(camdrive):
    calls = []

    def deformation(x):
        calls.append(x.shape)
        table = pandas.DataFrame(x.T, columns=["m", "drive.w"])
        return camdrive.study(GUIDE_BAR, table, "max |q|", turns=1).table["max |q|"].to_numpy()

    options = {"vectorized": True, "updating": "deferred", "polish": False}
    found = differential_evolution(deformation, [(5, 20), (100, 200)], maxiter=8, rng=1, **options)
    # Without resonance the deformation is as the force of inertia: least where mass and speed are.
    assert found.x[0] < 6 and found.x[1] < 110 and calls[0] == (2, 30) and len(calls) == 9


# Faults


def test_faults_have_the_words_of_the_tool(camdrive, tmp_path):
    def message(vary=None, measures="max |q|", kind=camdrive.Error, scene=GUIDE_BAR, turns=1, **keywords):
        return refused(kind, camdrive.study, scene, vary or {"m": [1]}, measures, turns=turns, **keywords)

    assert "no output `z`" in message(measures=["max |q|", "max |z|"])
    assert "largest q" in message(measures="largest q") and "measures" in message(measures=[])
    assert "`drive.v`" in message({"drive.v": [1]}) and "did you mean `drive.w`" in message({"driv.w": [1]})
    assert "3 mm" in message({"m": [1, "3 mm"]}) and "no values" in message({"m": []})
    assert "runs" in message({"m": {"from": 1, "to": 2}}) and "runs are too many" in message(
        {"m": {"from": 1, "to": 2, "count": 10**6}, "drive.w": {"from": 1, "to": 2, "count": 10**6}}
    )
    assert "turn" in message(turns=None, turn=2) and "turns" in message(turns=None)
    assert "missing.toml" in message(kind=camdrive.SceneError, scene=tmp_path / "missing.toml")
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(GUIDE_BAR.read_text().replace('"12 kg"', '"12 mm"'))
    assert "12 mm" in message(kind=camdrive.SceneError, scene=wrong)


def test_what_is_no_value_is_refused(camdrive, tmp_path):
    def message(vary, **keywords):
        return refused(camdrive.Error, camdrive.study, GUIDE_BAR, vary, "max |q|", turns=1, **keywords)

    for value in (math.nan, math.inf, None, 1j, {"a": 1}, np.datetime64("2020-01-01")):
        assert "`m`" in message({"m": [1, value]}) and "finite number" in message({"m": [1, value]}), value
    assert "finite" in message(pandas.DataFrame({"m": [1, math.nan]}))
    # A single value is a constant.
    table = camdrive.study(GUIDE_BAR, {"m": "12 kg", "b": 900}, "max |q|", turns=1).table
    assert [*table["m"]] == [12.0] and [*table["b"]] == [900.0]
    assert "twice" in message(pandas.DataFrame([[1, 2]], columns=["m", "m"]))
    for vary in ("m", 3, [1], [{"m": 1}, {"b": 1}]):
        assert "a list of mappings" in message(vary)
    assert "`store`" in message({"m": [1]}, resume=True)
    assert "workers" in message({"m": [1]}, client="tcp://127.0.0.1:1", threads=2)
    assert "`vary` is missing" in refused(camdrive.Error, camdrive.study, GUIDE_BAR, measures="max |q|")
    assert "is no store" in refused(camdrive.Error, camdrive.open_study, tmp_path)
    (tmp_path / "study.json").write_text("[]")
    assert "is no store" in refused(camdrive.Error, camdrive.open_study, tmp_path)


# Stores


def test_texts_pass_through_toml(camdrive, tmp_path):
    folder = tmp_path / 'a "b" \\ ü\t\x7f'
    folder.mkdir()
    shutil.copy(GUIDE_BAR, folder)
    study = camdrive.study(folder / "scene.toml", {"m": (np.float64(1e-9), np.int64(3), "4 kg")}, "max |q|", turns=1)
    assert list(study.table["m"]) == [1e-9, 3, 4]
    assert '`"\\`' in refused(camdrive.Error, camdrive.study, GUIDE_BAR, {'"\\': [1]}, "max |q|", turns=1)
    assert "`?`" in refused(camdrive.Error, camdrive.study, GUIDE_BAR, {"\ud800": [1]}, "max |q|", turns=1)


def test_a_store_goes_on_after_parts_are_lost(camdrive, many, tmp_path):
    store = tmp_path / "store"
    study = camdrive.study(GUIDE_BAR, **MANY, store=store)
    whole = parts(study)
    assert len(whole) == 100 and whole == parts(many)
    for number in (0, 7, 99):
        (store / "runs" / f"part-{number:05}.parquet").unlink()
    rest = camdrive.open_study(store)
    assert len(rest.table) == 1600 - 3 * 16 and "missing 48" in repr(rest)
    assert "48 of 1600 runs are missing" in refused(camdrive.Error, rest.to_xarray)
    assert "resume" in refused(camdrive.Error, camdrive.study, GUIDE_BAR, **MANY, store=store)
    kept = written(store / "runs" / "part-00008.parquet")
    study = camdrive.study(GUIDE_BAR, **MANY, store=store, resume=True)
    assert parts(study) == whole and written(store / "runs" / "part-00008.parquet") == kept
    pandas.testing.assert_frame_equal(study.table, many.table, check_exact=True)
    other = {**MANY, "turns": 99}
    text = refused(camdrive.Error, camdrive.study, GUIDE_BAR, **other, store=store, resume=True)
    assert "another study" in " ".join(text.split()) and parts(study) == whole
    for part in (store / "runs").iterdir():
        part.unlink()
    assert len(camdrive.open_study(store).table) == 0


def test_numbers_are_the_same_for_any_division(camdrive, many, tmp_path):
    assert parts(camdrive.study(GUIDE_BAR, **MANY, threads=1)) == parts(many)
    assert parts(camdrive.study(GUIDE_BAR, **MANY, threads=3)) == parts(many)
    file = tmp_path / "study.toml"
    file.write_text(json.loads((many.folder / "study.json").read_text())["study"])
    for share in ("2/3", "1/3", "3/3"):
        command = [CAMDRIVE, "study", "--part", share, "-o", tmp_path / "store", file]
        subprocess.run(command, check=True, capture_output=True)
    shares = camdrive.open_study(tmp_path / "store")
    assert parts(shares) == parts(many)
    # The study file itself.
    assert camdrive.study(file).table.equals(many.table)


def test_the_folder_of_a_temporary_store_vanishes(camdrive):
    study = camdrive.study(GUIDE_BAR, {"m": [1]}, "max |q|", turns=1)
    folder = study.folder
    assert folder.is_dir()
    del study
    assert not folder.exists()


# Clusters


def test_a_cluster_computes_the_same(camdrive, many, client, cluster, tmp_path):
    study = camdrive.study(GUIDE_BAR, **MANY, client=client, store=tmp_path / "store")
    assert parts(study) == parts(many) and study.data == many.data
    assert "resume" in refused(
        camdrive.Error, camdrive.study, GUIDE_BAR, **MANY, client=client, store=tmp_path / "store"
    )
    for number in range(3, 9):
        (study.folder / "runs" / f"part-{number:05}.parquet").unlink()
    kept = written(study.folder / "runs" / "part-00000.parquet")
    address = cluster.scheduler_address
    again = camdrive.study(GUIDE_BAR, **MANY, client=address, store=tmp_path / "store", resume=True)
    assert parts(again) == parts(many) and written(study.folder / "runs" / "part-00000.parquet") == kept
    assert sorted(place.name for place in study.folder.iterdir()) == ["runs", "study.json"]


def test_files_of_a_scene_go_along(camdrive, client, tmp_path):
    folder = tmp_path / "scenes"
    folder.mkdir()
    text = (EXAMPLES / "valve_train" / "forces.toml").read_text()
    (folder / "train.toml").write_text(text.replace('"lift.csv"', '"../tables/lift.csv"'))
    (tmp_path / "tables").mkdir()
    shutil.copy(EXAMPLES / "valve_train" / "lift.csv", tmp_path / "tables")
    (tmp_path / "studies").mkdir()
    file = tmp_path / "studies" / "study.toml"
    file.write_text(
        'scene = "../scenes/train.toml"\ntime = 0.01\nmeasures = ["last phi"]\n[[vary]]\nfile = "speeds.csv"\n'
    )
    (tmp_path / "studies" / "speeds.csv").write_text("drive.w [rpm]\n60\n120\n")
    for arguments in ((file,), (folder / "train.toml", {"drive.w": ["60 rpm", "120 rpm"]}, "last phi")):
        keys = {"time": 0.01} if len(arguments) > 1 else {}
        study = camdrive.study(*arguments, **keys, client=client)
        assert list(study.table["last phi"]) == pytest.approx([0.02 * math.pi, 0.04 * math.pi], rel=1e-12)
        assert study.table.equals(camdrive.study(*arguments, **keys).table)


@pytest.fixture(scope="module")
def long(camdrive):
    return camdrive.study(GUIDE_BAR, **LONG)


def in_background(camdrive, store, client):
    """A study of which parts are there already, its thread and what it will have returned or raised."""
    outcome = []

    def run():
        try:
            outcome.append(camdrive.study(GUIDE_BAR, **LONG, client=client, store=store))
        except camdrive.Error as error:
            outcome.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    waited(lambda: any((store / "runs").glob("*.parquet")))
    return thread, outcome


@pytest.mark.parametrize("what", [signal.SIGKILL, signal.SIGSTOP])
def test_a_lost_or_slow_worker_costs_nothing(camdrive, long, client, tmp_path, what):
    workers = client.run(os.getpid)
    thread, outcome = in_background(camdrive, tmp_path / "store", client)
    one = next(iter(workers.values()))
    os.kill(one, what)
    there = len([*(tmp_path / "store" / "runs").glob("*.parquet")])
    if what == signal.SIGSTOP:
        # The other one goes on with its own parts.
        waited(lambda: len([*(tmp_path / "store" / "runs").glob("*.parquet")]) > there)
        os.kill(one, signal.SIGCONT)
    thread.join()
    (study,) = outcome
    assert there < 100 and parts(study) == parts(long)
    pandas.testing.assert_frame_equal(study.table, long.table, check_exact=True)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A study of 8000 runs, and the parts of its store that none has killed."""
    folder = tmp_path_factory.mktemp("whole")
    text = "time = 4\nmeasures = ['max |q|']\nvary = [{ name = 'm', from = 10, to = 14, count = 8000 }]\n"
    (folder / "study.toml").write_text(f"scene = '{GUIDE_BAR}'\n{text}")
    command = [CAMDRIVE, "study", folder / "study.toml", "-o", folder / "store"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "study.toml", folder / "store" / "runs"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
@pytest.mark.parametrize("what", [signal.SIGKILL, signal.SIGINT])
def test_a_study_that_is_killed_goes_on(tmp_path, whole, what):
    study, runs = whole
    store = tmp_path / "store"
    command = [CAMDRIVE, "study", study, "-o", store]
    tool = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    waited(lambda: any((store / "runs").glob("*.parquet")))
    tool.send_signal(what)
    _, said = tool.communicate()
    there = {place.name: written(place) for place in (store / "runs").glob("*.parquet")}
    assert 0 < len(there) < 100
    if what == signal.SIGINT:
        assert tool.returncode == 130 and said.count(f"{len(there)} of 100 parts are there") == 1, said
    subprocess.run([*command, "--resume"], check=True, stdout=subprocess.DEVNULL)
    assert all(written(store / "runs" / name) == state for name, state in there.items())
    for place in (store / "runs").glob("*.parquet"):
        assert place.read_bytes() == (runs / place.name).read_bytes()


def test_a_restarted_scheduler_costs_what_is_under_way(camdrive, long, client, tmp_path):
    thread, outcome = in_background(camdrive, tmp_path / "store", client)
    client.restart()
    thread.join()
    (error,) = outcome
    assert "of 100 parts are there" in str(error) and "resume=True" in str(error)
    rest = camdrive.open_study(tmp_path / "store")
    before = {name: written(rest.folder / "runs" / name) for name in parts(rest)}
    assert 0 < len(before) < 100
    study = camdrive.study(GUIDE_BAR, **LONG, client=client, store=rest.folder, resume=True)
    assert parts(study) == parts(long)
    assert all(written(rest.folder / "runs" / name) == state for name, state in before.items())


def test_a_part_that_cannot_be_stored(camdrive, many, client, tmp_path):
    store = tmp_path / "store"
    obstacle = store / "runs" / "part-00042.parquet" / "obstacle"
    obstacle.mkdir(parents=True)
    text = refused(camdrive.Error, camdrive.study, GUIDE_BAR, **MANY, client=client, store=store)
    assert "part-00042" in text and "resume=True" in text
    shutil.rmtree(obstacle.parent)
    study = camdrive.study(GUIDE_BAR, **MANY, client=client, store=store, resume=True)
    assert parts(study) == parts(many)


def test_workers_without_camdrive(camdrive):
    bare = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with LocalCluster(n_workers=0, dashboard_address=":0") as cluster, Client(cluster) as client:
        command = [sys.executable, "-m", "distributed.cli.dask_worker", cluster.scheduler_address, "--no-dashboard"]
        worker = subprocess.Popen(command, env=bare, cwd="/", stderr=subprocess.DEVNULL)
        try:
            client.wait_for_workers(1, timeout=60)
            text = refused(camdrive.Error, camdrive.study, GUIDE_BAR, {"m": [1]}, "max |q|", turns=1, client=client)
        finally:
            worker.terminate()
            worker.wait()
    assert "No module named 'camdrive'" in text and "pip install the wheel" in text


def test_workers_of_another_version(camdrive, monkeypatch):
    run, texts = camdrive._study.run, []

    def older(*arguments):
        done = run(*arguments)
        store = next(Path(a.partition("=")[2]) for a in arguments if a.startswith("--output="))
        if "--threads=1" in arguments:
            texts.append(Path(arguments[-1]).read_text())
            data = json.loads((store / "study.json").read_text())
            (store / "study.json").write_text(json.dumps({**data, "commit": "0123456789ab"}))
        return done

    monkeypatch.setattr(camdrive._study, "run", older)
    with LocalCluster(n_workers=1, processes=False, dashboard_address=":0") as cluster, Client(cluster) as client:
        text = refused(camdrive.Error, camdrive.study, GUIDE_BAR, {"m": [1]}, "max |q|", turns=1, client=client)
    assert "commit 0123456789ab instead of" in text and "0 of 1 parts" in text
    # On another machine the scene is where the worker has put it.
    assert 'scene.toml"' in texts[0] and f'"{GUIDE_BAR}"' not in texts[0]
