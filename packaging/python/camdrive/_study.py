"""`study`: many variants of a scene, a system or an FMU, on this machine or on the workers of a Dask cluster."""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import re
import tempfile
from collections.abc import Iterable, Mapping
from functools import cached_property
from importlib import import_module
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Optional, Union

from ._reports import report
from ._tool import Error, PathLike, failure, hinted, is_fmu, module, run, temporary_folder, words

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    Vary = Union[Mapping[Any, Any], Iterable[Mapping[str, Any]], pd.DataFrame]

_FORMAT = 2
_EXPLAINED = ("rows", "parts", "seconds", "bytes")
# A share without parts: with it the tool makes or checks a store and computes nothing.
_NOTHING = "--part=1000000000000000000/1000000000000000000"


class Study:
    """The runs of a study. Its store `folder` is for others, too: polars and duckdb read `runs/*.parquet`.

    `data` is the content of its study.json, `units` and `meanings` have an entry for each column by name. A store in a
    temporary folder lives as long as this object. A study that is only explained has no store, and in `data` what it
    would take: `rows`, `parts`, `seconds`, `bytes`.
    """

    def __init__(self, folder: Optional[Path], data: dict[str, Any], temporary: object = None) -> None:
        self.folder, self.data, self._temporary = folder, data, temporary
        self.units: dict[str, str] = {column["name"]: column["unit"] for column in data["columns"]}
        self.meanings: dict[str, str] = {column["name"]: column["meaning"] for column in data["columns"]}
        self.measures: list[str] = [column["name"] for column in data["columns"] if column["role"] == "measured"]

    def __repr__(self) -> str:
        said: dict[str, Any] = {key: self.data[key] for key in _EXPLAINED if key in self.data}
        if self.folder is not None:
            status = [*self.table["status"]]
            said.update({word: status.count(word) for word in ("ok", "refused", "failed")})
            said.update(missing=said["rows"] - len(status), folder=str(self.folder))
        return f"<Study: {', '.join(f'{name} {value}' for name, value in said.items())}>"

    def _repr_html_(self) -> Optional[str]:
        """The page about the runs so far; None for a study that is only explained."""
        return None if self.folder is None else str(report(self.folder))

    @cached_property
    def table(self) -> pd.DataFrame:
        """The runs so far by their number `run`: varied quantities, measures, `status` and `message`.

        A measure of a run that was refused or failed is NaN. `attrs` has `units` and `meanings`.
        Raises `Error` where a part cannot be read, of a study that is only explained, and without pandas and pyarrow,
        which the extra `camdrive[study]` brings.
        """
        if self.folder is None:
            raise Error("the study was explained, not run")
        pandas, _, runs = module("pandas"), module("pyarrow"), self.folder / "runs"
        if not runs.is_dir():
            raise Error(f"{self.folder} is there no more")
        try:
            parts = [
                pandas.read_parquet(io.BytesIO(_sealed(part, self.data["identity"])), engine="pyarrow")
                for part in sorted(runs.glob("*.parquet"))
            ]
        except (OSError, ValueError, KeyError) as error:
            raise Error(f"{runs}: {words(error)}") from error
        table: pd.DataFrame = pandas.concat(parts or [pandas.DataFrame(columns=[*self.units])]).set_index("run")
        table.attrs.update(units=self.units, meanings=self.meanings)
        return table

    @property
    def refused(self) -> pd.DataFrame:
        """The refused and failed runs: varied quantities, `status` and `message`."""
        return self.table[self.table["status"] != "ok"].drop(columns=self.measures)

    def to_xarray(self) -> xr.Dataset:
        """The measures over the varied quantities: a product has a dimension for each quantity, with its values.

        Quantities that vary together or are sampled have the dimension `run`, or one by their names where there are
        several such groups. `attrs` of all have `units` and `long_name`.
        Raises `Error` where runs are missing, or without xarray, which the extra `camdrive[study]` brings.
        """
        xarray, table, axes, rows = module("xarray"), self.table, self.data["axes"], self.data["rows"]
        if len(table) < rows:
            raise Error(f"{self.folder}: {rows - len(table)} of {rows} runs are missing; resume=True computes them")
        lengths, last = self.data["lengths"], axes[-1] if self.data["sampled"] else None
        groups = [len(axis) > 1 or axis is last for axis in axes]
        about = {name: {"units": self.units[name], "long_name": self.meanings[name]} for name in self.units}
        joined = ["run" if sum(groups) == 1 else ", ".join(axis) for axis in axes]
        names = [joined[i] if group else axes[i][0] for i, group in enumerate(groups)]
        coordinates: dict[str, Any] = {name: range(length) for name, length in zip(names, lengths)}
        for place, axis in enumerate(axes):
            values = table.iloc[:: math.prod(lengths[place + 1 :])][: lengths[place]]
            coordinates.update({one: (names[place], values[one].to_numpy(), about[one]) for one in axis})
        arrays = {one: (names, table[one].to_numpy().reshape(lengths), about[one]) for one in self.measures}
        # A quantity with one value is a coordinate without a dimension.
        return xarray.Dataset(arrays, coordinates).squeeze()  # type: ignore[no-any-return]


def open_study(folder: PathLike) -> Study:
    """The study in a store, complete or not. Raises `Error` without one."""
    try:
        data = json.loads(Path(folder, "study.json").read_bytes())
        if data["format"] != _FORMAT:
            raise ValueError(f"its format is {data['format']}, this version reads {_FORMAT}")
        return Study(Path(folder), data)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise Error(f"{os.fspath(folder)} is no store of a study: {words(error)}") from error


def study(
    scene: PathLike,
    vary: Optional[Vary] = None,
    measures: Union[str, Iterable[str], None] = None,
    *,
    store: Optional[PathLike] = None,
    client: Any = None,
    resume: bool = False,
    threads: Optional[int] = None,
    explain: bool = False,
    timeout: Union[str, float, None] = None,
    **keys: Union[str, float, None],
) -> Study:
    """Runs many variants of a scene and measures each; the numbers are the same wherever they are computed.

    `scene` may be a system (TOML or .ssp) or an FMU, too; its variables are named as `simulate` names them.
    `vary` maps variables or keys of the scene to lists, all of which are combined; to series such as
    `{"from": "900 rpm", "to": "2000 rpm", "count": 12}`; or to distributions, `{"mean": "12 kg", "deviation": 0.1}`.
    A tuple of names varies together: `{("m", "b"): [(11, 900), (12, 950)]}`. A DataFrame or a list of mappings has a
    row for each run. Values are numbers in SI units, texts with a unit, names of items, True or False. `measures` are
    texts such as "max |q|". `keys` are `time` or `turns`, `settle`, `accuracy`, of systems and FMUs `step`, and for
    distributions `runs`, `design`, `seed`, as docs/study.md explains them. Without `vary`, `scene` is a study file:
    `camdrive.study("study.toml")`.

    `store` is a folder, by default a temporary one; with `resume` the parts of this study that it has are kept.
    `client` is a dask.distributed.Client or the address of a scheduler whose workers have camdrive; they compute shares
    and parts are stored as they arrive. The extra `camdrive[dask]` brings what that takes. Without it `threads` of this
    machine do, by default all. With `explain` only a sample is run. One call of a foreign FMU's library may take `timeout`,
    in s or with a unit, by default 60 s.

    Raises `SceneError` where the scene has faults, else `Error`; parts that a store has are kept.
    """
    place, keys = os.path.abspath(scene), {key: value for key, value in keys.items() if value is not None}
    if vary is None and (measures is not None or keys):
        raise Error("`vary` is missing; without it, all that is measured is in a study file")
    if resume and store is None:
        raise Error("resume=True needs the `store` to go on with")
    if client is not None and threads is not None:
        raise Error("`threads` is for this machine only; workers have their own number")
    temporary = None if store is not None or explain else temporary_folder()
    target = Path(temporary.name if temporary else os.path.abspath(store or ""))
    is_sent = client is not None and not explain
    # A share goes on with any store of the study.
    if is_sent and not resume and (target / "study.json").exists():
        raise Error(hinted(f"{target}: a store is there", "resume=True computes what it lacks"))
    options = {"--explain": explain, "--resume": resume, _NOTHING: is_sent, f"--output={target}": not explain}
    options[f"--threads={threads}"] = threads is not None
    limit = () if timeout is None else (f"--timeout={timeout}",)
    with temporary_folder() as folder:
        file = place if vary is None else os.path.join(folder, "study.toml")
        if vary is not None:
            vary = _by_name(vary)
            texts = [measures] if isinstance(measures, str) else [*(measures or ())]
            Path(file).write_bytes(_text(vary, {"scene": place, **keys, "measures": texts}).encode(errors="replace"))
        ran = run("study", "--json", *limit, *(option for option, is_given in options.items() if is_given), "--", file)
        if ran.returncode != 0:
            text = ran.stderr if vary is None else _of_dictionary(ran.stderr, file, [*vary])
            raise Error(text) if vary is None or is_fmu(place) else failure(text, place)
        told = json.loads(ran.stdout)
        if explain:
            return Study(None, told)
        done = Study(target, open_study(target).data, temporary)
        if is_sent:
            _distribute(client, done, [file, told["scene"], *told["tables"]], limit)
        return done


def _by_name(vary: Any) -> Mapping[Any, Any]:
    """The varied quantities by the names of their variables."""
    if hasattr(vary, "itertuples"):
        return {tuple(vary.columns): [*vary.itertuples(index=False, name=None)]}
    if not isinstance(vary, Mapping):
        table = [*vary] if isinstance(vary, Iterable) else [vary]
        if any(not isinstance(row, Mapping) or row.keys() != table[0].keys() for row in table):
            raise Error("vary: a mapping, a DataFrame or a list of mappings with the same names is expected")
        return {tuple(table[0] if table else ()): [[row[name] for name in table[0]] for row in table]}
    return vary


def _of_dictionary(text: str, file: str, names: list[Any]) -> str:
    """The message with keys of the dictionary instead of tables of the file, which no longer exists."""
    # Without the place in the file, and what stands there.
    text = re.sub(rf"(?m)^ *--> {re.escape(file)}.*\n(?: *\d* *\|.*\n)*", "", text).replace(file, "study")
    return re.sub(r"vary\[(\d+)\]", lambda place: f"vary[{names[int(place[1]) - 1]!r}]", text)


def _text(vary: Mapping[Any, Any], keys: dict[str, Any]) -> str:
    """The text of a study file."""
    lines = [f"{_toml(key)} = {_toml(value, key)}" for key, value in keys.items()]
    for name, values in vary.items():
        said, between = values if isinstance(values, Mapping) else {"values": values}, ",\n"
        lines += ["[[vary]]", f"{'names' if isinstance(name, tuple) else 'name'} = {_toml(name)}"]
        # A line for each value, as messages show lines.
        lines += [f"{_toml(key)} = {_toml(value, str(name), between)}" for key, value in said.items()]
    return "\n".join([*lines, ""])


def _toml(value: Any, name: str = "vary", between: str = ", ") -> str:
    value = value.item() if getattr(value, "shape", None) == () else value
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (int, float)) and abs(value) < math.inf:
        return repr(value).lower()
    if isinstance(value, Iterable) and not isinstance(value, (bytes, Mapping)):
        return f"[{between.join(_toml(item, name) for item in value)}]"
    raise Error(f"`{name}` = {value!r}: a finite number, a text, True or False is expected, or a list of these")


def _sealed(part: Path, identity: str) -> bytes:
    """The bytes of a part with a valid checksum: SHA-256 of the study, of its number, and of its bytes with zeros in the
    place of the checksum, each after its length."""
    whole = part.read_bytes()
    # Its key among the metadata, and the type and the length of a text.
    first = whole.rfind(b"camdrive.checksum") + 19
    bare = whole[:first] + b"0" * 64 + whole[first + 64 :]
    number = int(part.stem.rpartition("-")[2]).to_bytes(8, "little")
    digest = hashlib.sha256()
    for piece in (identity.encode(), number, bare):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    if digest.hexdigest().encode() != whole[first : first + 64]:
        hint = "resume=True, or `camdrive study --resume`, computes it again"
        raise ValueError(hinted(f"{part.name} is damaged, or of another place or study", hint))
    return whole


def _is_whole(part: Path, identity: str) -> bool:
    try:
        return bool(_sealed(part, identity))
    except (OSError, ValueError):
        return False


def _share(
    files: dict[str, bytes], file: str, share: str, limit: tuple[str, ...]
) -> tuple[dict[str, Any], dict[str, bytes]]:
    """What a worker does: its study.json, and the parts of a share by name."""
    with temporary_folder() as folder:
        for name, content in files.items():
            Path(folder, name).parent.mkdir(parents=True, exist_ok=True)
            Path(folder, name).write_bytes(content)
        store = Path(folder, "store")
        options = "--threads=1", *limit, f"--part={share}", f"--output={store}"
        done = run("study", *options, "--", os.path.join(folder, file))
        if done.returncode != 0:
            raise Error(done.stderr)
        return open_study(store).data, {part.name: part.read_bytes() for part in (store / "runs").glob("*.parquet")}


def _distribute(client: Any, done: Study, files: list[str], limit: tuple[str, ...]) -> None:
    """Sends the parts that a store does not have to the workers of a cluster, with study, scene and tables."""
    distributed, data, runs = module("distributed"), done.data, Path(done.folder or "", "runs")
    # Below a folder of the worker all paths are as here, so that what study and scene name is found.
    inside = [PurePath("files", *PurePath(os.path.abspath(path)).parts[1:]).as_posix() for path in files]
    bundle = {place: Path(path).read_bytes() for place, path in zip(inside, files)}
    scene = os.path.relpath(inside[1], os.path.dirname(inside[0]))
    bundle[inside[0]] = data["study"].replace(_toml(files[1]), _toml(scene), 1).encode()
    parts = [f"part-{part:05}.parquet" for part in range(math.ceil(data["rows"] / data["rows_of_part"]))]
    missing = {name for name in parts if not _is_whole(runs / name, data["identity"])}

    def compute(*arguments: Any) -> Any:
        # Nested, it goes to workers by value: one without camdrive says so instead of breaking down at the message.
        return import_module("camdrive._study")._share(*arguments)

    futures: list[Any] = []
    cluster = client
    try:
        cluster = distributed.Client(client) if isinstance(client, str) else client
        # Several for each thread, so that a slow one delays little; of a store with parts only what is missing.
        several = 8 * sum(cluster.nthreads().values()) if len(missing) == len(parts) else 0
        n = min(several or len(parts), len(parts))
        # A task as well, which is done again where a worker is lost that had the result.
        sent = cluster.submit(dict, bundle, pure=False)
        shares = [f"{i + 1}/{n}" for i in range(n) if missing.intersection(parts[i::n])]
        futures = [cluster.submit(compute, sent, inside[0], share, limit, pure=False) for share in shares]
        with tempfile.TemporaryDirectory(prefix=".", dir=done.folder) as drafts:
            for future in distributed.as_completed(futures):
                theirs, found = future.result()
                future.release()
                # There it has another path of the scene.
                theirs["study"] = data["study"]
                if other := [f"{key} {theirs[key]} instead of {data[key]}" for key in data if theirs[key] != data[key]]:
                    raise Error(f"a worker has another study: {'; '.join(other)}")
                for name, content in found.items():
                    with open(os.path.join(drafts, name), "wb") as draft:
                        draft.write(content)
                        draft.flush()
                        os.fsync(draft.fileno())
                    os.replace(draft.name, runs / name)
                    missing.discard(name)
    except Exception as error:
        is_bare = isinstance(error, ImportError)
        hint = "pip install the wheel of camdrive on all workers" if is_bare else "with a `store`, resume=True goes on"
        kept = f"{len(parts) - len(missing)} of {len(parts)} parts are there"
        raise Error(hinted(f"{words(error) or type(error).__name__}\n  = note: {kept}", hint)) from error
    finally:
        for future in futures:
            future.release()
        if cluster is not client:
            cluster.close()
