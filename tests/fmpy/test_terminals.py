"""The terminal of a shaft that `camdrive export --terminals` adds, against the schema of FMI 3.0."""

import subprocess
from pathlib import Path
from zipfile import ZipFile

import fmpy
import pytest
from lxml import etree

from conftest import CAMDRIVE, ROOT

SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
FOLDER = "terminalsAndIcons/"


def export(scene, target):
    """Exports a scene with terminals; the archive."""
    subprocess.run([CAMDRIVE, "export", ROOT / scene, "--terminals", "-o", target], check=True, capture_output=True)
    return ZipFile(target)


@pytest.mark.parametrize(
    "scene, torque, kind",
    [
        ("examples/guide_bar/run_up.toml", "tau", "inflow"),
        ("tests/fmpy/scenes/backlash_input.toml", "tau_mean", "inflow"),
        ("examples/rapier_loom/scene.toml", "tau", "outflow"),
    ],
)
def test_a_shaft_becomes_a_terminal_of_its_motion_and_torque(tmp_path, scene, torque, kind):
    with export(scene, tmp_path / "unit.fmu") as archive:
        document = etree.fromstring(archive.read(f"{FOLDER}terminalsAndIcons.xml"))
        etree.XMLSchema(etree.parse(str(SCHEMA))).assertValid(document)
        keys = ("variableName", "memberName", "variableKind")
        members = [tuple(m.get(key) for key in keys) for m in document.iter("TerminalMemberVariable")]
        assert members == [(name, name, "signal") for name in ("phi", "w", "a")] + [(torque, "tau", kind)]
        assert archive.read(f"{FOLDER}icon.png").startswith(b"\x89PNG")
    names = {v.name for v in fmpy.read_model_description(str(tmp_path / "unit.fmu")).modelVariables}
    assert names >= {name for name, *_ in members}


def test_a_drive_without_a_shaft_to_connect_has_no_terminal(tmp_path):
    with export("examples/guide_bar/scene.toml", tmp_path / "unit.fmu") as archive:
        assert not any(name.startswith(FOLDER) for name in archive.namelist())
