"""`simulate`: scenes, FMUs and systems with the tool, or an FMU with FMPy."""

from __future__ import annotations

import ctypes
import functools
import json
import os
import platform
import re
import shutil
import sys
import threading
import warnings
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Optional, Union

import numpy as np

from ._tool import (
    Error,
    PathLike,
    SimulationError,
    export,
    failure,
    hinted,
    is_fmu,
    module,
    run,
    temporary_folder,
    words,
)

Array = np.ndarray[Any, np.dtype[Any]]
Time = Union[float, str, None]
Values = dict[str, Any]
Names = Optional[list[str]]


class Result(Array):
    """A structured array of `time` and variables; `pandas.DataFrame(result)` makes a table of it.

    `units` and `descriptions` have an entry for every variable by name; the unit is "" if there is none.
    `result["y"]` is a plain array.
    """

    units: dict[str, str]
    descriptions: dict[str, str]

    def __array_finalize__(self, source: Any) -> None:
        self.units = getattr(source, "units", {})
        self.descriptions = getattr(source, "descriptions", {})

    def __getitem__(self, key: Any) -> Any:
        part = super().__getitem__(key)
        return part.view(np.ndarray) if isinstance(part, Result) and part.dtype.names is None else part

    def __reduce__(self) -> Any:
        build: Any = super().__reduce__()
        return (*build[:2], (build[2], self.units, self.descriptions))

    def __setstate__(self, state: Any) -> None:
        array, self.units, self.descriptions = state
        super().__setstate__(array)


def _result(array: Array, units: dict[str, str], descriptions: dict[str, str]) -> Result:
    result = array.view(Result)
    result.units, result.descriptions = units, descriptions
    return result


def simulate(
    scene_or_fmu: PathLike,
    *,
    start_values: Optional[Mapping[str, Any]] = None,
    output: Union[str, Iterable[str], None] = None,
    stop_time: Time = None,
    step: Time = None,
    input: Optional[Array] = None,
    engine: Optional[str] = None,
    timeout: Time = None,
    **more_start_values: Any,
) -> Result:
    """Simulates a scene, an FMU or a system and returns a structured array of `time` and the outputs, with their units.

    Parameters and start values of inputs are keywords, or the mapping `start_values`, which also takes names such as
    `drive.w` or `cam.a[3]`. A value is a number in SI units, True or False, the name of an item of an enumeration, or
    a text with a unit, "2000 rpm". `output` names the variables to return, by default all outputs. `stop_time` and the
    communication step `step`, in s or with a unit, are by default the FMU's experiment. `input` is a
    structured array with `time` and inputs in SI units or in the units of its fields, "w [rpm]"; it is interpolated.
    If the unit of an FMU is not SI, a number without a unit is refused. Several threads may call it at once.

    A system is a TOML file with parts, or NAME.ssp; its variables are called `machine.w`. The `engine` is "native", the
    tool, or "fmpy": FMPy, which the extra `camdrive[fmpy]` brings, drives the FMU, which is exported of a scene, and takes
    those units that its variables have.

    The tool runs the library of a foreign FMU in a process of its own; one call of it may take `timeout`, in s or with a
    unit, by default 60 s. FMPy runs it in this process. An FMU that ends the simulation itself gives its rows so far, and
    a `UserWarning` says why.

    Raises `SceneError` where the scene has faults, `SimulationError` where the drive refuses something, else `Error`.
    """
    values = {**(start_values or {}), **more_start_values}
    outputs = [output] if isinstance(output, str) else None if output is None else list(output)
    if engine not in ("native", "fmpy", None):
        raise Error(f'engine = {engine!r}: admissible is "native" or "fmpy"')
    fields = getattr(getattr(input, "dtype", None), "names", None) or ()
    if input is not None and not any(field.split("[")[0].strip() == "time" for field in fields):
        raise Error("input: a structured array with the fields `time` and inputs is expected")
    with temporary_folder() as folder:
        if engine != "fmpy":
            return _by_tool(os.fspath(scene_or_fmu), values, outputs, stop_time, step, input, timeout, folder)
        return _by_fmpy(Path(scene_or_fmu), values, outputs, stop_time, step, input, folder)


def _by_tool(
    scene: str,
    values: Values,
    outputs: Names,
    stop: Time,
    step: Time,
    input: Optional[Array],
    timeout: Time,
    folder: str,
) -> Result:
    # TOML and the tool write true, Python True.
    texts = {str(True): "true", str(False): "false"}
    arguments = [f"--start={name}={texts.get(str(value), value)}" for name, value in values.items()]
    names = None if outputs is None else ",".join(outputs)
    options = (("output", names), ("stop", stop), ("step", step), ("timeout", timeout))
    arguments += [f"--{option}={given}" for option, given in options if given is not None]
    if input is not None:
        table, names = os.path.join(folder, "input.csv"), ",".join(input.dtype.names or ())
        # With all digits.
        np.savetxt(table, np.atleast_1d(input), "%.17g", ",", header=names, comments="", encoding="utf-8")
        arguments.append(f"--input={table}")
    done = run("run", "--json", *arguments, "--", scene)
    if done.returncode != 0:
        raise SimulationError(done.stderr) if is_fmu(scene) else failure(done.stderr, scene, SimulationError)
    document = json.loads(done.stdout)
    if "ended" in document:
        # At the line that called `simulate`.
        warnings.warn(document["ended"], stacklevel=3)
    columns = {column["name"]: column for column in document["columns"]}
    lists = [[np.nan if value is None else value for value in column["values"]] for column in columns.values()]
    types = [(name, np.asarray(values).dtype) for name, values in zip(columns, lists)]
    # A unit that is not known is null.
    keys = ("unit", "description")
    units, descriptions = ({name: column[key] or "" for name, column in columns.items()} for key in keys)
    return _result(np.array([*zip(*lists)], types), units, descriptions)


# FMPy changes into the folder of a library while it loads it, and the working directory belongs to the whole process.
_without_chdir = SimpleNamespace(**{**vars(os), "chdir": lambda _folder: None})
_loading = threading.Lock()
# The library below FMPy makes its table of XML's types at the first schema it reads: of two threads that come at once, one
# finds the table half made.
_reading = threading.Lock()
_of_thread = threading.local()


def _log(_environment: Any, _instance: bytes, status: int, _category: bytes, message: bytes) -> None:
    if status > 0:
        _of_thread.messages.append(message.decode("utf-8", "replace"))


@functools.cache
def _logger() -> Any:
    return import_module("fmpy.fmi2").fmi2CallbackLoggerTYPE(_log)


def _instantiate(fmpy: Any, folder: str, description: Any) -> Any:
    """An instance of FMPy, made in any thread and without a change of the working directory."""
    with _loading:
        fmpy.fmi1.os, before = _without_chdir, fmpy.fmi1.os
        try:
            # FMPy has one logger for all FMUs, the last one: hence the address of one that lives with the process.
            logger = ctypes.cast(_logger(), ctypes.c_void_p).value
            return fmpy.instantiate_fmu(folder, description, "CoSimulation", logger=logger)
        finally:
            fmpy.fmi1.os = before


def _units(description: Any) -> dict[str, tuple[Any, float, float]]:
    """Dimension, factor and offset to SI of the units of an FMU's variables."""
    known: dict[str, tuple[Any, float, float]] = {}
    for unit in description.unitDefinitions:
        base = unit.baseUnit
        names = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
        dimension = unit.name if base is None else tuple(int(getattr(base, name)) for name in names)
        factor, offset = (1.0, 0.0) if base is None else (float(base.factor), float(base.offset))
        known[unit.name] = (dimension, factor, offset)
    return known


def _in_own_unit(value: Any, unit: str, variable: Any, units: dict[str, tuple[Any, float, float]]) -> Any:
    """Numbers in a unit, or in SI without one, converted to the unit of the variable; None if the FMU does not define the unit."""
    own = units.get(variable.unit, (variable.unit, 1.0, 0.0))
    if unit == (variable.unit or "") or not unit and own[1:] == (1.0, 0.0):
        return value
    if not unit:
        hint = f'write the unit: "2 {variable.unit}", of a field of `input` "{variable.name} [{variable.unit}]"'
        message = f"`{variable.name}`: numbers may be in SI or in {variable.unit}, the unit of the FMU"
        raise SimulationError(hinted(message, hint))
    other = units.get(unit)
    return None if other is None or other[0] != own[0] else (other[1] * value + other[2] - own[2]) / own[1]


def _in_own_units(input: Array, known: dict[str, Any], units: dict[str, tuple[Any, float, float]]) -> Array:
    """The inputs over time for FMPy: by their names, in the units of the FMU, `time` in s."""
    fields = [re.fullmatch(r"(.*?)\s*(?:\[([^\[\]]*[^\[\]\d][^\[\]]*)\])?", field) for field in input.dtype.names or ()]
    pairs = [(field[1], field[2] or "") if field else ("", "") for field in fields]
    inputs = {"time", *(name for name, variable in known.items() if variable.causality == "input")}
    unknown = [name for name, _ in pairs if name not in inputs]
    if unknown:
        raise SimulationError(f"the FMU has no variable or no input {', '.join(unknown)}")
    rows = np.atleast_1d(input)
    columns = []
    for (name, unit), field in zip(pairs, input.dtype.names or ()):
        variable = SimpleNamespace(name="time", unit="s") if name == "time" else known[name]
        column = rows[field] if name == "time" and unit in ("", "s") else _in_own_unit(rows[field], unit, variable, units)
        if column is None:
            raise SimulationError(f"`{name}`: {unit} is no unit of it that the FMU defines")
        columns.append(column)
    types = [(name, np.asarray(column).dtype) for (name, _), column in zip(pairs, columns)]
    return np.array([*zip(*columns)], types)


def _number(value: Any, variable: Any, units: dict[str, tuple[Any, float, float]]) -> Any:
    """The value of a variable of an FMU in its unit; for an enumeration also from the name of an item."""
    items = {item.name: int(item.value) for item in getattr(variable.declaredType, "items", None) or ()}
    if variable.type == "Boolean":
        items = {"true": True, "false": False}
    number = items.get(value, value) if isinstance(value, str) else value
    if isinstance(number, (int, float, np.number, np.bool_)):
        return _in_own_unit(number, "", variable, units) if variable.type == "Real" else number
    text = re.fullmatch(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\D.*?)\s*", str(number)) if not items else None
    own = _in_own_unit(float(text[1]), text[2], variable, units) if text else None
    if own is not None:
        return own
    admissible = " or ".join([f"a number in {variable.unit}" if variable.unit else "a number", *items])
    message = f"`{variable.name}` = {value!r}\n  = admissible: {admissible}"
    hint = 'texts with units are for scenes with engine = "native"'
    raise SimulationError(message if items else hinted(message, hint))


def _by_fmpy(
    path: Path, values: Values, outputs: Names, stop: Time, step: Time, input: Optional[Array], folder: str
) -> Result:
    fmpy = module("fmpy")
    for name, given in (("stop_time", stop), ("step", step)):
        if isinstance(given, str):
            raise SimulationError(f'{name} = {given!r}: a number in s is expected; texts are for engine = "native"')
    messages: list[str] = []
    _of_thread.messages = messages
    fmu = path if path.suffix.lower() == ".fmu" else export(path, folder)
    try:
        # Unpacked here, since FMPy leaves what it unpacks of an FMU that refuses something; and on Linux it looks into
        # linux64 on any processor.
        unpacked = fmpy.extract(str(fmu), unzipdir=os.path.join(folder, "unpacked"))
        arm = Path(unpacked, "binaries", "aarch64-linux")
        if arm.is_dir() and sys.platform == "linux" and platform.machine() == "aarch64":
            shutil.copytree(arm, arm.with_name("linux64"), dirs_exist_ok=True)
        with _reading:
            description = fmpy.read_model_description(unpacked)
        known = {variable.name: variable for variable in description.modelVariables}
        units_of_fmu = _units(description)
        unknown = [name for name in (*values, *(outputs or ())) if name not in known]
        if unknown:
            raise SimulationError(f"the FMU has no variable or no input {', '.join(unknown)}")
        if input is not None:
            input = _in_own_units(input, known, units_of_fmu)
        if step is None and description.defaultExperiment and description.defaultExperiment.stepSize:
            # FMPy would lengthen the step of the FMU in a long experiment.
            step = float(description.defaultExperiment.stepSize)
        # Made here, so that it is freed where it refuses something, too: Windows deletes no library in use.
        instance = _instantiate(fmpy, unpacked, description)
        try:
            array = fmpy.simulate_fmu(
                unpacked,
                model_description=description,
                start_values={name: _number(value, known[name], units_of_fmu) for name, value in values.items()},
                output=outputs,
                stop_time=stop,
                output_interval=step,
                input=input,
                fmu_instance=instance,
            )
        finally:
            instance.freeInstance()
    except Error:
        raise
    except Exception as error:
        raise SimulationError(words(error), tuple(messages)) from error
    # FMPy sorts them by type.
    names = [*dict.fromkeys(outputs or [name for name in known if name in array.dtype.names])]
    units = {"time": "s", **{name: known[name].unit or "" for name in names}}
    descriptions = {"time": "Time", **{name: known[name].description or "" for name in names}}
    return _result(array[["time", *names]], units, descriptions)
