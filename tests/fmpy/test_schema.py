"""The JSON Schemas of scenes, tasks, studies and systems, as editors use them: taplo and tombi find nothing wrong in right files, and in wrong ones
what a schema can know, in the line that camdrive names."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import CAMDRIVE, ROOT

RIGHT = sorted([*ROOT.glob("examples/*/*.toml"), *ROOT.glob("tests/fmpy/scenes/*.toml"), *ROOT.glob("modelDescription/*.toml")])
# Unknown keys, values of another type, plain numbers out of range, names that are not known.
KNOWN = re.compile(r"is not known( in |$)|expected, .* is an? (array|table|string|boolean|integer|float)$|: [-+.e\d]+ is out of range")
# What depends on another key or on the kind of drive.
BEYOND = {("machine.toml", "start.mode"), ("beyond_the_fmu.toml", "cam.a[1]")}
TOOLS = {"taplo": ["lint", "--colors", "never"], "tombi": ["lint", "--offline"]}


def lint(tool, kind, files, folder):
    """The lines in which the tool finds something wrong, for each file."""
    shutil.copy(ROOT / f"docs/{kind}.schema.json", folder / "schema.json")
    names = {}
    for i, file in enumerate(files):
        names[f"{i:03}_{file.name}"] = file
        (folder / f"{i:03}_{file.name}").write_bytes(b"#:schema ./schema.json\n" + file.read_bytes())
    program = Path(sys.executable).with_name(tool)
    run = subprocess.run([program, *TOOLS[tool], *names], cwd=folder, capture_output=True, text=True, env=os.environ | {"NO_COLOR": "1"})
    lines = {file: set() for file in files}
    for name, line in re.findall(r"(\d{3}_\w+\.toml):(\d+):\d+", run.stdout + run.stderr):
        lines[names[name]].add(int(line) - 1)
    assert run.returncode == 0 or any(lines.values()), run.stdout + run.stderr
    return lines


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("kind", ["scene", "task", "study", "system"])
def test_a_right_file_has_no_faults(tool, kind, tmp_path):
    files = [file for file in RIGHT if (file.stem if file.stem in ("task", "study", "system") else "scene") == kind]
    assert len(files) > {"scene": 50, "task": 2, "study": 2, "system": 2}[kind]
    assert not [file for file, lines in lint(tool, kind, files, tmp_path).items() if lines]


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("kind", ["scene", "task"])
def test_a_wrong_file_has_its_faults_in_the_same_lines(tool, kind, tmp_path):
    files = sorted((ROOT / f"tests/{kind}s").glob("*.toml"))
    found, checked, missed = lint(tool, kind, files, tmp_path), 0, []
    for file in files:
        for said, line in re.findall(r"^error: (.*)\n +--> \S+?:(\d+):", file.with_suffix(".txt").read_text(), re.M):
            key = said.split("`")[1] if "`" in said else ""
            if KNOWN.search(said) and (file.name, key) not in BEYOND:
                checked += 1
                missed += [(file.name, line, said)] if int(line) not in found[file] else []
    assert not missed and checked > (1 if kind == "task" else 25), (checked, missed)


LIST = subprocess.run([CAMDRIVE, "new"], check=True, capture_output=True, text=True).stdout
TEMPLATES = re.findall(r"^  (\S+) ", LIST, re.MULTILINE)
MODELS = ["ElasticCamDrive", "BacklashDrive", "RigidMachine", "DriveTrain", "ParametricDrive"]


@pytest.mark.parametrize("template", [*TEMPLATES, *MODELS])
def test_a_new_file_exports_as_it_is_and_editors_find_no_fault(template, tmp_path):
    subprocess.run([CAMDRIVE, "new", template], cwd=tmp_path, check=True, capture_output=True)
    files = sorted(tmp_path.glob("*.toml"))
    scenes = [file.name for file in files if file.stem not in ("task", "study", "system")]
    subprocess.run([CAMDRIVE, "export", *scenes], cwd=tmp_path, check=True, capture_output=True)
    assert len(list(tmp_path.glob("*.fmu"))) == len(scenes) > 0
    assert all("\n#:schema ./" in file.read_text() for file in files)
    for tool in TOOLS:
        run = subprocess.run([Path(sys.executable).with_name(tool), *TOOLS[tool], *(file.name for file in files)], cwd=tmp_path, capture_output=True, text=True)
        assert run.returncode == 0, run.stdout + run.stderr
