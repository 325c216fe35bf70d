"""The executable `camdrive`: where it is, how it is run, and what its failures are in Python."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Optional, Union

PathLike = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class Diagnostic:
    """A fault of a scene: where it is, what is wrong, what is admissible and what helps, as far as that is known."""

    message: str
    file: str
    line: Optional[int] = None
    column: Optional[int] = None
    key: Optional[str] = None
    admissible: Optional[str] = None
    hint: Optional[str] = None


class Error(Exception):
    """The message of camdrive or of an FMU when it failed, as text."""


class SceneError(Error):
    """A scene has faults: `str()` is the text of the tool, `diagnostics` has one entry per fault."""

    def __init__(self, text: str, diagnostics: tuple[Diagnostic, ...]) -> None:
        # Both, so that the exception passes from one process to another.
        super().__init__(text, diagnostics)
        self.diagnostics = diagnostics

    def __str__(self) -> str:
        return str(self.args[0])


class SimulationError(Error):
    """A drive refused a value or a step: `str()` says which, `messages` are what an FMU logged."""

    def __init__(self, text: str, messages: tuple[str, ...] = ()) -> None:
        super().__init__(text, messages)
        self.messages = messages

    def __str__(self) -> str:
        return "\n".join((self.args[0], *self.messages))


def hinted(message: str, hint: str) -> str:
    """A message with its remedy, as the tool prints it."""
    return f"{message}\n  = hint: {hint}"


def words(error: Exception) -> str:
    """What went wrong, without the number of the system's error."""
    if isinstance(error, OSError) and error.strerror:
        place = f"{os.fspath(error.filename)}: " if isinstance(error.filename, (str, os.PathLike)) else ""
        return place + error.strerror
    return str(error)


def module(name: str) -> Any:
    """A package that only some functions need."""
    try:
        return import_module(name)
    except ImportError as error:
        raise Error(f"{name} is missing: pip install {name}") from error


def temporary_folder() -> tempfile.TemporaryDirectory[str]:
    """A folder that vanishes at the end of its `with`."""
    try:
        return tempfile.TemporaryDirectory()
    except OSError as error:
        raise Error(f"no temporary folder can be made (TMPDIR says where): {words(error)}") from error


def by_arguments(text: str) -> str:
    """A message of the tool with the arguments of Python for its options, but for commands to type."""
    names = {"start": "start_values", "stop": "stop_time", "force": "force=True", "o": "output"}
    option = re.compile(r"(?<![\w-])--?(o\b|(?<=--)(?!runtime)[a-z][a-z-]*)")
    parts = text.split("\n\nUsage:")[0].split("`")
    parts[::2] = [option.sub(lambda of: names.get(of[1], of[1].replace("-", "_")), part) for part in parts[::2]]
    return "`".join(parts)


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs the executable with its options and returns what it printed."""
    name = "camdrive" + (sysconfig.get_config_var("EXE") or "")
    # The places in an environment, after pip install --user, after pip install --target.
    scripts = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    places = [Path(folder, name) for folder in (*scripts, str(Path(__file__).parents[1] / "bin"))]
    program = next((str(place) for place in places if place.is_file()), None) or shutil.which("camdrive")
    if program is None:
        raise Error(f"the executable camdrive is neither in the PATH nor one of {', '.join(map(str, places))}")
    # Messages are for exceptions, not for a terminal with colours and lines.
    environment = {name: value for name, value in os.environ.items() if name != "CLICOLOR_FORCE"}
    environment["COLUMNS"] = "10000"
    try:
        done = subprocess.run([program, *arguments], capture_output=True, encoding="utf-8", env=environment)
    except (OSError, ValueError) as error:
        raise Error(f"the executable camdrive cannot be run: {words(error)}") from error
    if not done.stdout and not done.stderr:
        done.stderr = f"camdrive ended with the exit code {done.returncode}"
    done.stderr = by_arguments(done.stderr)
    return done


def is_fmu(path: str) -> bool:
    """Whether a file is an FMU: it runs without a scene inside, so its failures are not a scene's."""
    return Path(path).suffix.lower() == ".fmu"


def failure(text: str, scene: str, kind: type[Error] = Error) -> Error:
    """The exception for a command that failed with this text: `SceneError` where it says faults that `check` finds."""
    try:
        (entry,) = json.loads(run("check", "--json", "--", scene).stdout)
    except ValueError:
        entry = {}
    diagnostics = tuple(Diagnostic(**fault) for fault in entry.get("faults", ()))
    return SceneError(text, diagnostics) if any(of.message in text for of in diagnostics) else kind(text)


def export(scene: PathLike, output: Optional[PathLike] = None, *, platforms: Iterable[str] = ()) -> Path:
    """Packs a scene into an FMU and returns its path.

    `output` is a file NAME.fmu or a folder, by default the current one; `platforms` are those to pack libraries for, by
    default all: linux64, aarch64-linux, win64, darwin64.

    Raises `SceneError` where the scene has faults, `Error` where the export fails otherwise.
    """
    arguments = ["export", "--json"]
    # A name that begins with a dash is one all the same.
    if output is not None:
        arguments.append(f"--output={os.fspath(output)}")
    chosen = platforms if isinstance(platforms, str) else ",".join(platforms)
    if chosen:
        arguments.append(f"--platforms={chosen}")
    done = run(*arguments, "--", os.fspath(scene))
    if done.returncode != 0:
        raise failure(done.stderr, os.fspath(scene))
    return Path(json.loads(done.stdout)[0]["fmu"])
