"""What an FMU carries beside the drive: the scene it was made of, inputs and results of its default experiment."""

import csv
import subprocess
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from conftest import CAMDRIVE, FMUS, all_fmus

NAMES = all_fmus()
EXTRA = Path("extra") / "org.fmi-standard.fmi-ls-ref"


def inputs_of(folder):
    """Times and values of the inputs, by name; empty where there are none."""
    path = folder / EXTRA / "input.csv"
    return np.genfromtxt(path, delimiter=",", names=True, deletechars="") if path.is_file() else None


@pytest.mark.parametrize("name", NAMES)
def test_the_results_inside_are_those_of_another_importer(fmu, name):
    package = fmu(name)
    with open(package.folder / EXTRA / "result.csv", newline="") as file:
        head, *lines = csv.reader(file)
    results = np.array(lines, dtype=float)
    assert head == ["time", *package.outputs()]
    experiment = package.description.defaultExperiment
    assert results[0, 0] == 0.0 and results[-1, 0] == float(experiment.stopTime)
    inputs = inputs_of(package.folder)
    names = [] if inputs is None else inputs.dtype.names[1:]

    def give(unit, i):
        unit.set(**{name: inputs[name][i] for name in names})
        if i + 1 < len(results):
            # Of the motion of a shaft only `a` is no integral of another input.
            for name in names if "a" not in names else [name for name in names if name not in ("phi", "w")]:
                slope = (inputs[name][i + 1] - inputs[name][i]) / (inputs["time"][i + 1] - inputs["time"][i])
                unit.slave.setRealInputDerivatives([package.variables[name].valueReference], [1], [slope])

    with package.unit() as unit:
        values = {name: inputs[name][0] for name in names}
        unit.initialise(tolerance=float(experiment.tolerance), values=values)
        rows = []
        for i, time in enumerate(results[:, 0]):
            unit.time = time
            give(unit, i)
            rows.append(unit.get(*head[1:]))
            if i + 1 < len(results):
                unit.step(results[i + 1, 0] - time)
    values = np.array(rows, dtype=float)
    # Half a digit of seven, of numbers below 1e-12 all.
    bound = 1e-6 * np.abs(values).max(axis=0) + 1e-12
    assert np.all(np.abs(results[:, 1:] - values) <= bound), [
        head[i + 1] for i in np.flatnonzero(np.any(np.abs(results[:, 1:] - values) > bound, axis=0))
    ]


@pytest.mark.parametrize("name", NAMES)
def test_the_manifest_lists_each_file_once(fmu, name):
    folder = fmu(name).folder / EXTRA
    manifest = etree.parse(folder / "fmi-ls-manifest.xml").getroot()
    assert manifest.tag == "fmiReferences"
    namespace = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
    assert manifest.get(namespace + "name") == EXTRA.name and manifest.get(namespace + "version")
    assert all(entry.tag == "Related" and entry.get("type") and entry.get("description") for entry in manifest)
    listed = [(entry.get("source"), entry.get("role")) for entry in manifest]
    there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert sorted(source for source, _ in listed) == sorted(there - {"fmi-ls-manifest.xml"})
    assert [source for source, role in listed if role == "result"] == ["result.csv"]
    assert listed[0] == ("model/scene.toml", "model")
    inputs = [variable for variable in fmu(name).description.modelVariables if variable.causality == "input"]
    assert [source for source, role in listed if role == "testcase"] == (["input.csv"] if inputs else [])


def test_every_fmu_agrees_and_gives_itself_again(tmp_path):
    fmus = [FMUS / f"{name}.fmu" for name in NAMES]
    subprocess.run([CAMDRIVE, "verify", *fmus], check=True, capture_output=True)
    subprocess.run([CAMDRIVE, "export", *fmus, "-o", f"{tmp_path}/"], check=True, capture_output=True)
    others = [fmu.name for fmu in fmus if fmu.read_bytes() != (tmp_path / fmu.name).read_bytes()]
    assert others == []
