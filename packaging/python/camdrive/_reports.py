"""The design commands of the tool as functions: each returns the JSON, the tables and the diagrams of its command."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

from ._tool import Error, PathLike, failure, module, run, temporary_folder

if TYPE_CHECKING:
    import pandas as pd

_Value = Union[str, float, "os.PathLike[str]"]
Option = Union[_Value, Sequence[_Value], None]


class Diagram(str):
    """The SVG text of a diagram, which notebooks draw."""

    def _repr_svg_(self) -> str:
        return str(self)

    def __repr__(self) -> str:
        return f"<Diagram: {len(self)} characters of SVG>"


class Page(str):
    """The HTML text of a page, which notebooks show."""

    def _repr_html_(self) -> str:
        return str(self)

    def __repr__(self) -> str:
        return f"<Page: {len(self)} characters of HTML>"


@dataclass(repr=False)
class Report:
    """The findings of a command. Its `repr` is the `answer`, name, result and advice of the `verdict`, and the names of all parts.

    `data` is the JSON document of the command; its fields are attributes, too: `steady(scene).motions[0]["period"]`.
    docs/json.md says what they are; values are in SI units, angles in rad; what is infinite or unknown is None.
    `files` has the content of the files that the command wrote, by name; `messages` are its warnings and notes.
    """

    data: Any
    files: dict[str, bytes]
    messages: str
    _main: str = ""

    @property
    def answer(self) -> str:
        """The result and the advice in the `verdict` of the command."""
        fields = self._fields
        name = next((fields[key] for key in ("name", "scene", "system", "file") if key in fields), "")
        verdict = fields.get("verdict", {"result": [fields.get("summary", "")], "advice": []})
        advice = [advice["text"] for advice in verdict["advice"]]
        return "\n".join(line for line in (name, *verdict["result"], *advice) if line)

    @property
    def _fields(self) -> dict[str, Any]:
        data = self.__dict__.get("data", {})
        return data if isinstance(data, dict) else {"followers": data}

    def __getattr__(self, name: str) -> Any:
        try:
            return self._fields[name]
        except KeyError:
            raise AttributeError(f"this report has no {name}, but {', '.join(self._fields)}") from None

    def _repr_html_(self) -> Optional[str]:
        """The page of the report, which notebooks show; None without one."""
        return next((content.decode() for name, content in self.files.items() if name.endswith(".html")), None)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __repr__(self) -> str:
        parts = {"fields": [*self._fields], "tables": self.tables, "diagrams": [*self.svg]}
        return "\n".join([self.answer, *(f"{part}: {', '.join(names)}" for part, names in parts.items() if names)])

    @property
    def tables(self) -> list[str]:
        """The names of all tables: lists of records in `data`, and files NAME.csv."""
        return [*_records(self._fields), *(name for name in self.files if name.endswith(".csv"))]

    def table(self, name: str) -> pd.DataFrame:
        """One of `tables`. Records within others have the fields of these in columns such as `drives.name`.

        Raises `Error` where there is no such table, or no pandas, which the extra `camdrive[study]` brings.
        """
        if name not in self.tables:
            raise Error(f"this report has no table {name}, but {', '.join(self.tables) or 'none'}")
        pandas = module("pandas")
        if name not in self.files:
            return pandas.DataFrame(_records(self._fields)[name])  # type: ignore[no-any-return]
        text = self.files[name].decode()
        # Files for motion controllers have semicolons.
        separator = ";" if ";" in text.partition("\n")[0] else ","
        return pandas.read_csv(io.StringIO(text), sep=separator)  # type: ignore[no-any-return]

    @property
    def svg(self) -> dict[str, str]:
        """The diagrams as SVG texts; the keys are the names of their files without the ending."""
        return {name[:-4]: content.decode() for name, content in self.files.items() if name.endswith(".svg")}

    def plot(self, diagram: Optional[str] = None) -> Diagram:
        """A diagram of `svg` by its name or by the end of it, such as "torque"; by default the main one.

        Raises `Error` for an unknown or ambiguous name.
        """
        drawn = self.svg
        ends = [name for name in drawn if f".{name}".endswith(f".{diagram or self._main}")]
        if diagram is None and drawn:
            ends = ends[:1] or [min(drawn, key=len)]
        if len(ends) != 1:
            raise Error(f"{len(ends)} diagrams are called {diagram}; the report has {', '.join(drawn) or 'none'}")
        return Diagram(drawn[ends[0]])


def _records(fields: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """The lists of records in these fields, flat, by their names."""
    found: dict[str, list[dict[str, Any]]] = {}

    def look(value: Any, name: str, above: dict[str, Any]) -> None:
        if isinstance(value, dict):
            for key, part in value.items():
                look(part, f"{name}.{key}" if name else key, above)
        elif _is_table(value):
            for record in value:
                found.setdefault(name, []).append({**above, **_flat(record)})
                plain = {f"{name}.{key}": part for key, part in record.items() if not isinstance(part, (dict, list))}
                look(record, name, {**above, **plain})

    look(fields, "", {})
    return found


def _is_table(value: Any) -> bool:
    return isinstance(value, list) and any(isinstance(record, dict) for record in value)


def _flat(record: dict[str, Any], before: str = "") -> dict[str, Any]:
    """A record with the fields of its parts as its own, such as `largest.phi`."""
    flat: dict[str, Any] = {}
    for key, value in record.items():
        flat.update(_flat(value, f"{before}{key}.") if isinstance(value, dict) else {before + key: value})
    return {key: value for key, value in flat.items() if not _is_table(value)}


def _stamps(folder: str) -> dict[Path, tuple[int, int]]:
    if not os.path.isdir(folder):
        return {}
    states = ((place, place.stat()) for place in sorted(Path(folder).iterdir()) if place.is_file())
    return {place: (state.st_ino, state.st_mtime_ns) for place, state in states}


def _report(
    command: str,
    scene: PathLike,
    options: dict[str, Option],
    output: Optional[PathLike] = None,
    places: Sequence[str] = ("--output={}",),
    main: str = "",
    json_of_file: bool = False,
) -> Report:
    """Runs a command that writes into a folder, `output` or a temporary one, named by the options `places`."""
    arguments = [] if json_of_file else ["--json"]
    for key, given in options.items():
        # `from` is a word of Python.
        option = "--" + key.rstrip("_").replace("_", "-")
        for value in given if isinstance(given, (list, tuple)) else [given]:
            if value is True:
                arguments.append(option)
            elif value is not None and value is not False:
                arguments.append(f"{option}={value}")
    with temporary_folder() as temporary:
        folder = os.path.join(temporary if output is None else os.fspath(output), "")
        before = _stamps(folder)
        arguments += [place.format(folder) for place in places]
        done = run(command, *arguments, "--", os.fspath(scene))
        files = {place.name: place for place, stamp in _stamps(folder).items() if before.get(place) != stamp}
        content = {name: place.read_bytes() for name, place in files.items()}
    written = next((content[name] for name in content if name.endswith(".json")), b"")
    # Not the exit code decides: a machine without periodic motion and a follower that leaves its cam are results.
    try:
        data = json.loads(written if json_of_file else done.stdout)
    except ValueError:
        text = done.stderr or done.stdout
        raise Error(text) if command == "synthesize" else failure(text, os.fspath(scene)) from None
    if command in ("check", "verify"):
        (data,) = data
    if command == "check" and not data["ok"]:
        raise failure(run("check", "--", os.fspath(scene)).stderr, os.fspath(scene))
    if command == "verify" and "error" in data:
        raise Error(data["error"])
    return Report(data, content, done.stderr, main)


def check(scene: PathLike) -> Report:
    """Validates a scene: characteristic `figures` of its design, `motions` of its laws, `resonances`, `warnings`.

    For a system: `parts`, `connections`, `shafts` with their stable steps, and `loops`.
    Raises `SceneError` where it has faults, `Error` where it cannot be checked; so does every function here.
    """
    return _report("check", scene, {}, places=())


def report(file: PathLike, *, output: Optional[PathLike] = None, force: bool = False) -> Page:
    """One page about a scene, a system or a study: all its tables and diagrams, as HTML that needs no network.

    `output` is a file for it; one that no command wrote is replaced only with `force=True`.
    """
    with temporary_folder() as folder:
        page = os.path.join(folder, "page.html") if output is None else os.fspath(output)
        done = run("report", f"--output={page}", *(["--force"] if force else []), "--", os.fspath(file))
        if done.returncode != 0:
            raise failure(done.stderr, os.fspath(file))
        return Page(Path(page).read_text(encoding="utf-8"))


def system(file: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """Connects a machine and the drives on its shaft: `parts`, `connections`, `shafts` with their stable steps.

    `files` has what other masters need: an FMU for each part, NAME.ssp, OspSystemStructure.xml and run.py. With `study=True`
    the system runs with each exchange at several steps instead: `rows` of errors, and the verdict says which step to take.
    `simulate` gives the course of a run. Further options as of `camdrive help system`.
    """
    return _report("system", file, options, output)


def verify(fmu: PathLike, *, timeout: Option = None) -> Report:
    """Runs the default experiment of an FMU again: whether it `agrees` with the results inside, `outputs`, `changes`.

    One call of its library, unless it is the one of this tool, may take `timeout`, by default 60 s.
    """
    return _report("verify", fmu, {"timeout": timeout}, places=())


def describe(scene: PathLike) -> Report:
    """The interface of the FMU of a scene: `variables` with units and ranges, `equations`, `accuracy`, `limits`."""
    return _report("describe", scene, {}, places=())


def steady(scene: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """The periodic `motions` of a drive or a machine, and its `turn`; a drive without one is a result as well.

    `speed="1800 rpm"` applies to a drive on inputs. For a RigidMachine `period="120 ms"` finds the speed of the motor that
    yields it, and `load="30 N.m"` brakes. As everywhere here, the
    options are those that `camdrive help steady` explains, with underscores: numbers in SI, texts with a unit, True for
    one without a value, a list where several are possible. `output` is a folder for the tables and diagrams, which the
    report has in any case.
    """
    return _report("steady", scene, options, output, ("--report={}",), main="steady")


def stability(scene: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """The `speeds` at which a drive with periodic coefficients is unstable, its `orders`, and the damping that prevents it.

    `speed=["60 rpm", "92 rpm"]` are examined, `from_` and `to` are the ends of the diagrams, `quick=True` leaves the
    maps out. Further options as of `camdrive help stability`.
    """
    return _report("stability", scene, options, output, main="modulation")


def forces(scene: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """The loads on rollers, joints and shaft over the turn, and the forces that keep followers on their cams.

    `speed="300 rpm"` replaces the scene's speed. Further options: see `camdrive help forces`.
    """
    return _report("forces", scene, options, output, main="torque")


def tradeoff(scene: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """Error and cost of every setting of the solver (`settings`) and of every feature of a scene (`features`), with `advice`.

    `turns=2` and `quick=True` shorten it. Further options as of `camdrive help tradeoff`.
    """
    return _report("tradeoff", scene, options, output, main="work_precision")


def synthesize(task: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """A cam profile of few harmonics for a motion task: its coefficients, errors, peaks and restrictions.

    The profile is `files["profile.toml"]`, a fragment `[cam]` or a whole scene: from the task, or from
    `scene="loom.toml"`. Further options as of `camdrive help synthesize`. Raises `Error` where the task has faults.
    """
    places = ("--output={}profile.toml", "--report={}")
    return _report("synthesize", task, options, output, places, main="position")


def compensate(scene: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """Cams that make the tools of a machine move as prescribed although its speed fluctuates.

    The scene with them is `files["compensated.toml"]`; tables and the scenes of `cam="1=gripper.toml"` are next to it.
    `period="120 ms"` is needed without a motor. Further options as of `camdrive help compensate`.
    """
    places = ("--output={}compensated.toml", "--report={}")
    return _report("compensate", scene, options, output, places, main="speed", json_of_file=True)


def clearance(scene: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """Where and how hard a drive passes through its clearance, and the remedies against further impacts, for all `laws`.

    `clearance="0.05 mm"`, `m1="2 kg"` and `speed` replace the scene's values, `compare=["bestehorn", "hs7"]` adds laws,
    `quick=True` leaves the maps by the model out. Further options as of `camdrive help clearance`.
    """
    return _report("clearance", scene, options, output, main="passage_time")


def cam(scene: PathLike, *, output: Optional[PathLike] = None, **options: Option) -> Report:
    """The contours of the cams of a scene (CSV, DXF, SVG), tables for motion controllers, and findings on them.

    `data` is a list, `followers` as an attribute. `chord_error="0.5 um"`, `follower=[1, 2]`; further options as of
    `camdrive help cam`. Raises `Error` where a cam cannot be cut, unless `force=True`.
    """
    return _report("cam", scene, options, output, json_of_file=True)
