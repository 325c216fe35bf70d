"""@name@: the FMUs next to this file as one system, results in @name@.csv. Needs fmpy: python run.py [STEP]"""
import csv
import math
import sys
from pathlib import Path
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STOP, STEP = @stop@, @step@
FMUS = @fmus@
START = @start@
# Output, input, factor, offset.
CONNECTIONS = [
@connections@]
# The machine of each drive, with ratio and offset.
SHAFTS = @shafts@

class Part:
    def __init__(self, name, path):
        self.about = read_model_description(path)
        self.variables = {v.name: v for v in self.about.modelVariables}
        self.fmu = FMU2Slave(guid=self.about.guid, unzipDirectory=extract(path), instanceName=name,
                             modelIdentifier=self.about.coSimulation.modelIdentifier)
        # FMUs of other tools treat phi, w, a as three independent inputs.
        own = (self.about.generationTool or "").startswith("camdrive")
        self.follows = own and self.about.coSimulation.canInterpolateInputs
        self.last = {}
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)

    def call(self, verb, name, *values):
        v = self.variables[name]
        return getattr(self.fmu, verb + v.type.replace("Enumeration", "Integer"))([v.valueReference], *values)

    def get(self, name):
        return self.call("get", name)[0]

    def set(self, name, value, *rates):
        self.call("set", name, [value])
        if rates and self.about.coSimulation.canInterpolateInputs:
            references = [self.variables[name].valueReference] * len(rates)
            self.fmu.setRealInputDerivatives(references, range(1, len(rates) + 1), rates)

    def rate(self, name, h):
        """The derivative of an output, from the FMU or else over the last step."""
        v, value = self.variables[name], self.get(name)
        last, self.last[name] = self.last.get(name, value), value
        known = v.variability == "continuous" and self.about.coSimulation.maxOutputDerivativeOrder
        rate = self.fmu.getRealOutputDerivatives([v.valueReference], [1])[0] if known else math.nan
        own = (value - last) / h if v.variability == "continuous" else 0.0
        return rate if math.isfinite(rate) else own

def connect(parts, to, h=None):
    """Sets the inputs of a part to the outputs, with their derivatives for a step of h."""
    for source, output, part, name, factor, offset in CONNECTIONS:
        if part == to:
            slope = [factor * parts[source].rate(output, h)] if h else []
            parts[part].set(name, factor * parts[source].get(output) + offset, *slope)

def meet(parts):
    """Parts that do not follow their inputs get the inputs of the end, in turn with machines."""
    late = [name for name, part in parts.items() if not part.follows]
    machines = [machine for name, (machine, _, _) in SHAFTS.items() if name in late]
    for name in (late + machines) * 20:
        connect(parts, name)

@step_function@
def simulate(step_size=STEP):
    """The heading, and a row for each communication point."""
    parts = {name: Part(name, str(Path(__file__).with_name(file))) for name, file in FMUS.items()}
    for name, part in parts.items():
        for variable, value in START.get(name, {}).items():
            part.set(variable, value)
        part.fmu.enterInitializationMode()
    for name in list(parts) * 20:  # Algebraic loops converge.
        connect(parts, name)
    for part in parts.values():
        part.fmu.exitInitializationMode()
    outputs = [(name, v.name) for name, part in parts.items() for v in part.about.modelVariables if v.causality == "output"]
    row = lambda time: [time] + [parts[name].get(output) for name, output in outputs]
    rows = [["time"] + [".".join(output) for output in outputs], row(0.0)]
    times = [i * step_size for i in range(math.ceil(STOP / step_size - 1e-9))] + [STOP]
    for time, end in zip(times, times[1:]):
        step(parts, time, end - time)
        meet(parts)
        rows.append(row(end))
    for part in parts.values():
        part.fmu.terminate()
        part.fmu.freeInstance()
    return rows

if __name__ == "__main__":
    with open("@name@.csv", "w", newline="") as file:
        csv.writer(file).writerows(simulate(*map(float, sys.argv[1:2])))
