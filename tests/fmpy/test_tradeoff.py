"""The files of `camdrive tradeoff` say the same in every form."""

import csv
import json
import subprocess

from conftest import CAMDRIVE, ROOT

SCENE = ROOT / "examples" / "transfer_manipulator" / "hs3.toml"


def test_the_tables_say_the_same_in_every_form(tmp_path):
    command = [CAMDRIVE, "tradeoff", str(SCENE), "-o", str(tmp_path), "--quick", "--turns", "2"]
    subprocess.run(command, check=True, capture_output=True)
    files = {ending: (tmp_path / f"transfer_hs3.{ending}").read_text() for ending in ("json", "settings.csv", "features.csv", "html")}
    report = json.loads(files["json"])
    settings, features = (list(csv.DictReader(files[name].splitlines())) for name in ("settings.csv", "features.csv"))
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
    for advice in report["verdict"]["advice"]:
        assert advice["text"].split(":")[0] in files["html"]
