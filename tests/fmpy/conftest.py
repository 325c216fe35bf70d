"""What all tests share: where the exported FMUs are, and a thin driver over fmpy's FMU2Slave."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi2 import fmi2CallbackAllocateMemoryTYPE, fmi2CallbackFreeMemoryTYPE

ROOT = Path(__file__).resolve().parents[2]
FMUS = Path(os.environ.get("CAMDRIVE_FMUS", ROOT / "target" / "fmus"))
CAMDRIVE = os.environ.get("CAMDRIVE", str(ROOT / "target" / "release" / "camdrive"))


class Package:
    """An exported FMU, unpacked once; yields any number of instances."""

    def __init__(self, path, folder):
        self.path = path
        self.folder = folder
        self.description = fmpy.read_model_description(str(path))
        self.variables = {v.name: v for v in self.description.modelVariables}
        fmpy.extract(str(path), unzipdir=str(folder))

    def start(self, name):
        return float(self.variables[name].start)

    def parameters(self):
        """All numeric start values of the parameters, by name."""
        kinds = ("Real", "Integer", "Enumeration")
        chosen = [v for v in self.description.modelVariables if v.causality == "parameter" and v.type in kinds]
        return {v.name: float(v.start) for v in chosen}

    def outputs(self):
        return [v.name for v in self.description.modelVariables if v.causality == "output"]

    def unit(self, name="unit", **kwargs):
        return Unit(self, name, **kwargs)


class Unit:
    """One instance with access by variable name; collects the log."""

    def __init__(self, package, name="unit", logging=True):
        self.package = package
        self.log = []
        description = package.description
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(package.folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )

        def logger(_environment, _instance, status, category, message):
            self.log.append((status, category.decode(), message.decode()))

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(logger)
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self.slave.instantiate(callbacks=callbacks, loggingOn=logging)
        self.time = 0.0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.free()

    def free(self):
        if self.slave is not None:
            self.slave.freeInstance()
            self.slave = None

    def initialise(self, start_time=0.0, stop_time=None, tolerance=None, **parameters):
        """`parameters`: names with dots and brackets are passed as a dict under the key `values`."""
        values = parameters.pop("values", {}) | parameters
        self.slave.setupExperiment(tolerance=tolerance, startTime=start_time, stopTime=stop_time)
        self.set(**{k: v for k, v in values.items()})
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.time = start_time
        return self

    def set(self, **values):
        for name, value in values.items():
            v = self.package.variables[name]
            reference = [v.valueReference]
            if v.type == "Real":
                self.slave.setReal(reference, [float(value)])
            elif v.type == "Boolean":
                self.slave.setBoolean(reference, [bool(value)])
            else:
                self.slave.setInteger(reference, [int(value)])

    def get(self, *names):
        values = []
        for name in names:
            v = self.package.variables[name]
            getter = {"Real": self.slave.getReal, "Boolean": self.slave.getBoolean}.get(v.type, self.slave.getInteger)
            values.append(getter([v.valueReference])[0])
        return values[0] if len(values) == 1 else values

    def step(self, size):
        self.slave.doStep(self.time, size)
        self.time += size

    def step_to(self, time):
        """Steps to `time`; the rounded sum that the FMU forms is the time that it arrives at."""
        self.step(time - self.time)


@pytest.fixture(scope="session")
def fmu(tmp_path_factory):
    """A function from the name of an exported FMU to its package."""
    packages = {}

    def load(name):
        if name not in packages:
            packages[name] = Package(FMUS / f"{name}.fmu", tmp_path_factory.mktemp(name))
        return packages[name]

    yield load
    for package in packages.values():
        shutil.rmtree(package.folder, ignore_errors=True)


@pytest.fixture(scope="session")
def camdrive(tmp_path_factory):
    """The Python package of the wheel."""
    folder = str(tmp_path_factory.mktemp("package"))
    wheel = os.environ["CAMDRIVE_WHEEL"]
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", folder, wheel]
    subprocess.run(pip, check=True)
    sys.path.insert(0, folder)
    import camdrive

    yield camdrive
    sys.path.remove(folder)


def all_fmus():
    return sorted(p.stem for p in FMUS.glob("*.fmu"))
