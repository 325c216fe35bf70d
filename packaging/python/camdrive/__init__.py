"""Exports cam drives, drives with backlash and rigid machines as FMI 2.0 Co-Simulation FMUs, and simulates them.

    import camdrive
    path = camdrive.export("scene.toml")
    result = camdrive.simulate("scene.toml", output=["y"], start_values={"drive.w": 200.0, "cam.a[3]": -9.0e-5})
    result["time"], result["y"]

The executable `camdrive` in the wheel does the work. `simulate` needs FMPy: `pip install fmpy`. The folder
`share/doc/camdrive` of the environment has README.md and the reference of all keys of a scene.
"""

from __future__ import annotations

import ctypes
import functools
import json
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Optional, Union

if TYPE_CHECKING:
    import numpy as np

__all__ = ["Diagnostic", "Error", "SceneError", "SimulationError", "export", "simulate"]

__version__ = version("camdrive")

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
    """An FMU refused a value or a step: `str()` says which, `messages` are what it logged."""

    def __init__(self, text: str, messages: tuple[str, ...]) -> None:
        super().__init__(text, messages)
        self.messages = messages

    def __str__(self) -> str:
        return "\n".join((self.args[0], *self.messages))


def _words(error: Exception) -> str:
    """What went wrong, without the number of the system's error."""
    if isinstance(error, OSError) and error.strerror:
        place = f"{os.fspath(error.filename)}: " if isinstance(error.filename, (str, os.PathLike)) else ""
        return place + error.strerror
    return str(error)


def _run(*arguments: str) -> subprocess.CompletedProcess[str]:
    name = "camdrive" + (sysconfig.get_config_var("EXE") or "")
    # Of an environment, of pip install --user, of pip install --target.
    scripts = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    places = [Path(folder, name) for folder in (*scripts, str(Path(__file__).parents[1] / "bin"))]
    program = next((str(place) for place in places if place.is_file()), None) or shutil.which("camdrive")
    if program is None:
        raise Error(f"the executable camdrive is neither in the PATH nor one of {', '.join(map(str, places))}")
    # Messages are for exceptions, not for a terminal with colours.
    environment = {name: value for name, value in os.environ.items() if name != "CLICOLOR_FORCE"}
    try:
        return subprocess.run([program, *arguments], capture_output=True, encoding="utf-8", env=environment)
    except OSError as error:
        raise Error(f"the executable camdrive cannot be run: {_words(error)}") from error


def _diagnostics(scene: str) -> tuple[Diagnostic, ...]:
    try:
        (entry,) = json.loads(_run("check", "--json", "--", scene).stdout)
    except ValueError:
        return ()
    return tuple(Diagnostic(**fault) for fault in entry.get("faults", ()))


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
    done = _run(*arguments, "--", os.fspath(scene))
    if done.returncode == 0:
        return Path(json.loads(done.stdout)[0]["fmu"])
    diagnostics = _diagnostics(os.fspath(scene))
    raise SceneError(done.stderr, diagnostics) if diagnostics else Error(done.stderr)


# FMPy goes into the folder of a library while it loads it, and the working directory is that of the whole process.
_without_chdir = SimpleNamespace(**{**vars(os), "chdir": lambda _folder: None})
_loading = threading.Lock()
_of_thread = threading.local()


def _log(_environment: Any, _instance: bytes, status: int, _category: bytes, message: bytes) -> None:
    if status > 0:
        _of_thread.messages.append(message.decode("utf-8", "replace"))


@functools.cache
def _logger() -> Any:
    from fmpy.fmi2 import fmi2CallbackLoggerTYPE

    return fmi2CallbackLoggerTYPE(_log)


def _instantiate(folder: str, description: Any) -> Any:
    """An instance of FMPy, made in any thread and without a change of the working directory."""
    import fmpy.fmi1

    with _loading:
        fmpy.fmi1.os, before = _without_chdir, fmpy.fmi1.os
        try:
            # FMPy has one logger for all FMUs, the last one: hence the address of one that lives as long as the process.
            logger = ctypes.cast(_logger(), ctypes.c_void_p).value
            return fmpy.instantiate_fmu(folder, description, "CoSimulation", logger=logger)
        finally:
            fmpy.fmi1.os = before


def simulate(
    scene_or_fmu: PathLike,
    *,
    start_values: Optional[Mapping[str, Any]] = None,
    output: Optional[Iterable[str]] = None,
    stop_time: Optional[float] = None,
    step: Optional[float] = None,
    input: Optional[np.ndarray] = None,
    **more_start_values: Any,
) -> np.ndarray:
    """Simulates a scene or an FMU and returns a structured array of `time` and the outputs.

    Parameters and start values of inputs are keywords, or the mapping `start_values`, which also takes names such as
    `drive.w` or `cam.a[3]`. `output` names the variables to return, by default all outputs. `stop_time` and the
    communication step `step` in s are by default those of the FMU's experiment. `input` is a structured array with
    `time` and inputs, which are interpolated. All values are SI. `pandas.DataFrame(result)` makes a
    table of the result. Several threads may call it at once.

    Raises `SceneError` or `Error` as `export` does, `SimulationError` where the FMU refuses something.
    """
    try:
        import fmpy
    except ImportError as error:
        raise Error("camdrive.simulate needs FMPy: pip install fmpy") from error
    values = {**(start_values or {}), **more_start_values}
    messages: list[str] = []
    _of_thread.messages = messages
    try:
        temporary = tempfile.TemporaryDirectory()
    except OSError as error:
        raise Error(f"no temporary folder can be made (TMPDIR says where): {_words(error)}") from error
    with temporary as folder:
        fmu = Path(scene_or_fmu)
        if fmu.suffix.lower() != ".fmu":
            fmu = export(fmu, folder)
        try:
            # Unpacked here, since FMPy leaves what it unpacks of an FMU that refuses something; and on Linux it looks into
            # linux64 on any processor.
            unpacked = fmpy.extract(str(fmu), unzipdir=os.path.join(folder, "unpacked"))
            arm = Path(unpacked, "binaries", "aarch64-linux")
            if arm.is_dir() and sys.platform == "linux" and platform.machine() == "aarch64":
                shutil.copytree(arm, arm.with_name("linux64"), dirs_exist_ok=True)
            description = fmpy.read_model_description(unpacked)
            outputs = [output] if isinstance(output, str) else None if output is None else list(output)
            known = {variable.name for variable in description.modelVariables}
            unknown = [name for name in (*values, *(outputs or ())) if name not in known]
            if unknown:
                raise SimulationError(f"the FMU has no variable {', '.join(unknown)}", ())
            if step is None and description.defaultExperiment and description.defaultExperiment.stepSize:
                # FMPy would lengthen the step of the FMU in a long experiment.
                step = float(description.defaultExperiment.stepSize)
            # Made here, so that it is freed where it refuses something, too: Windows deletes no library in use.
            instance = _instantiate(unpacked, description)
            try:
                result: np.ndarray = fmpy.simulate_fmu(
                    unpacked,
                    start_values=values,
                    output=outputs,
                    stop_time=stop_time,
                    output_interval=step,
                    input=input,
                    fmu_instance=instance,
                )
            finally:
                instance.freeInstance()
            return result
        except Error:
            raise
        except Exception as error:
            raise SimulationError(_words(error), tuple(messages)) from error
