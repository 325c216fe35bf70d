"""An FMU exported --with-tradeoff: valid, the same drive to the byte, and with the tables of the study."""

import csv
import io
import json
import os
import subprocess
import zipfile
from xml.etree import ElementTree

import pytest
from fmpy.validation import validate_fmu

from conftest import CAMDRIVE, FMUS, ROOT

FOLDER = "extra/org.camdrive.tradeoff/"
PAGE = "documentation/index.html"
SCENE = ROOT / "examples" / "transfer_manipulator" / "hs3.toml"


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    path = tmp_path_factory.mktemp("tradeoff") / "with.fmu"
    command = [CAMDRIVE, "export", str(SCENE), "-o", str(path), "--with-tradeoff", "--quick", "--turns", "2"]
    subprocess.run(command, check=True, capture_output=True, env=os.environ)
    return path


def content(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_it_is_valid_and_the_same_drive(exported):
    assert validate_fmu(str(exported)) == []
    plain, studied = content(FMUS / "transfer_hs3.fmu"), content(exported)
    assert set(studied) - set(plain) == {FOLDER + name for name in ("tradeoff.json", "settings.csv", "features.csv")}
    assert set(plain) <= set(studied)
    assert [name for name in plain if plain[name] != studied[name]] == [PAGE]


def test_the_tables_say_the_same_in_every_form(exported):
    files = content(exported)
    report = json.loads(files[FOLDER + "tradeoff.json"])
    tables = (files[FOLDER + name].decode() for name in ("settings.csv", "features.csv"))
    settings, features = (list(csv.DictReader(io.StringIO(text))) for text in tables)
    assert len(settings) == len(report["settings"]) > 4
    assert len(features) == len(report["features"]) > 3
    for row, other in zip(settings + features, report["settings"] + report["features"]):
        value, key = (other["error"], "error") if "error" in other else (other["change"], "change")
        if value is None:
            # Internal steps that are too long are refused, and the reason is told.
            assert row["method"] == "fixed_cost" and "solver.step_size" in row["fault"] == other["fault"]
            assert row[key] == row["cost_ns_per_ms"] == ""
            continue
        assert float(row[key]) == value
        assert float(row["cost_ns_per_ms"]) == other["cost"]["ns_per_ms"] > 0
    finer = [row for row in report["settings"] if row["tolerance"] == 1e-9]
    assert finer and all(row["error"] < 1e-7 for row in finer)
    assert 0 < report["reference"]["floor"] < 1e-9
    page = files[PAGE].decode()
    for advice in report["verdict"]["advice"]:
        assert advice["text"].split(":")[0] in page
    # The page stays well-formed, with the pictures of the cam and of the experiment, and the two diagrams.
    tree = ElementTree.fromstring(page.split("?>", 1)[-1].replace("<!DOCTYPE html>", ""))
    assert len(tree.findall(".//{http://www.w3.org/2000/svg}svg")) == 4
