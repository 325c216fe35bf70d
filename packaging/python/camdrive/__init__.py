"""Cam drives, drives with backlash and rigid machines: exported as FMI 2.0 Co-Simulation FMUs, simulated and designed.

    import camdrive
    result = camdrive.simulate("scene.toml", output=["y"], start_values={"drive.w": "2000 rpm", "cam.a[3]": -9.0e-5})
    result["time"], result["y"], result.units["y"]
    path = camdrive.export("scene.toml")
    report = camdrive.steady("machine.toml", load="40 N.m")
    report.motions[0]["period"], report.table("motions"), report.plot()
    study = camdrive.study("scene.toml", {"drive.w": ["900 rpm", "1800 rpm"], "m": [11, 12]}, "max |q|", turns=2)
    study.table, study.to_xarray(), study.refused
    camdrive.report("scene.toml")  # A page, which notebooks show.

The executable `camdrive` in the wheel does the work. Extras of the wheel bring what only some functions need:
`camdrive[study]` pandas, pyarrow and xarray, for tables and studies; `camdrive[dask]` Dask's distributed, for studies on
clusters; `camdrive[fmpy]` FMPy, for `engine="fmpy"`. The folder `share/doc/camdrive` of the environment has README.md,
the reference of all keys of a scene, the fields of all reports (docs/json.md) and the examples.
"""

from importlib.metadata import version

from ._reports import Diagram, Page, Report, cam, check, clearance, compensate, describe, forces
from ._reports import report, stability, steady, synthesize, system, tradeoff, verify
from ._simulate import Result, simulate
from ._study import Study, open_study, study
from ._tool import Diagnostic, Error, SceneError, SimulationError, export

__all__ = [
    "Diagnostic", "Diagram", "Error", "Page", "Report", "Result", "SceneError", "SimulationError", "Study",
    "cam", "check", "clearance", "compensate", "describe", "export", "forces", "open_study",
    "report", "simulate", "stability", "steady", "study", "synthesize", "system", "tradeoff", "verify",
]  # fmt: skip

__version__ = version("camdrive")
