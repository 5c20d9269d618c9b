"""A host for FMI units: FMPy validates each, simulates it as it is, and plays tapes on it.

    host.py validate UNIT...          prints what is wrong; nothing is good
    host.py play LIST                 LIST has a line for each tape: UNIT, TAPE, OUTPUT

tape.rs defines the tape. One process plays all tapes: starting Python costs more than a thousand steps.
"""
import io
import struct
import sys
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu


def validate(path):
    problems = list(validate_fmu(path))
    from lxml import etree
    schema = Path(fmpy.__file__).parent / "schema"
    with zipfile.ZipFile(path) as archive:
        if archive.testzip() is not None:
            problems.append("the archive is damaged")
        name = "sources/buildDescription.xml"
        if name in archive.namelist():
            rules = etree.XMLSchema(etree.parse(str(schema / "fmi3" / "fmi3BuildDescription.xsd")))
            tree = etree.parse(io.BytesIO(archive.read(name)))
            if not rules.validate(tree):
                problems.append(str(rules.error_log))
    description = read_model_description(path)
    if fmpy.platform not in fmpy.supported_platforms(path):
        problems.append("there is no binary for this computer")
    # As it was imported: it must run through its default experiment.
    result = simulate_fmu(path)
    experiment = description.defaultExperiment
    wanted = round(float(experiment.stopTime) / float(experiment.stepSize)) + 1
    if abs(len(result) - wanted) > 1:
        problems.append(f"{len(result)} rows instead of {wanted}")
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    if sorted(result.dtype.names) != sorted(["time"] + outputs):
        problems.append("the outputs are not those of the description")
    if result["total.steps"][-1] < 90:
        problems.append("the default experiment does not step the machine")
    if "completed" in outputs and result["completed"][-1] < 1:
        problems.append("the default experiment ends no operation")
    return problems


class Unit:
    """An instance of a unit, with the functions that tapes need."""

    def __init__(self, description, folder, name):
        self.two = description.fmiVersion == "2.0"
        self.time = 0.0
        self.fmu = (FMU2Slave if self.two else FMU3Slave)(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        # What is refused is part of the tape, so that its text need not be shown.
        if self.two:
            self.fmu.instantiate()
        else:
            self.fmu.instantiate(logMessage=quiet)
        self.initialize()

    def initialize(self):
        self.time = 0.0
        if self.two:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def reset(self):
        self.fmu.reset()
        self.initialize()

    def set(self, reference, kind, value):
        setter = {
            "r": self.fmu.setReal if self.two else self.fmu.setFloat64,
            "i": self.fmu.setInteger if self.two else self.fmu.setInt32,
            "e": self.fmu.setInteger if self.two else self.fmu.setInt64,
            "l": self.fmu.setReal if self.two else self.fmu.setInt64,
            "b": self.fmu.setBoolean,
        }[kind]
        setter([reference], [value])

    def read(self, watched):
        getter = {
            "r": self.fmu.getReal if self.two else self.fmu.getFloat64,
            "i": self.fmu.getInteger if self.two else self.fmu.getInt32,
            "e": self.fmu.getInteger if self.two else self.fmu.getInt64,
            "l": self.fmu.getReal if self.two else self.fmu.getInt64,
            "b": self.fmu.getBoolean,
        }
        values = {}
        for kind, places in watched.items():
            found = getter[kind]([r for _, r in places])
            for (place, _), value in zip(places, found):
                values[place] = struct.pack(">d", value).hex() if kind == "r" else str(int(value))
        return [values[i] for i in range(len(values))]

    def step(self, ticks, size):
        try:
            self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=ticks * size)
        except FMICallException as refused:
            return refused.status
        self.time += ticks * size
        return 0

    def save(self):
        return self.time, self.fmu.getFMUState()

    def load(self, saved):
        self.time = saved[0]
        self.fmu.setFMUState(saved[1])

    def rewrite(self, saved):
        if self.two:
            data = self.fmu.serializeFMUState(saved[1])
            self.fmu.freeFMUState(saved[1])
            return saved[0], self.fmu.deserializeFMUState(data)
        data = self.fmu.serializeFMUState(saved[1])
        self.fmu.freeFMUState(saved[1])
        return saved[0], self.fmu.deserializeFMUState(data)


def quiet(*_):
    pass


def play(path, tape, output):
    description = read_model_description(path)
    size = float(description.defaultExperiment.stepSize)
    watched, count, units, states, now = {}, 0, {}, {}, 0
    with TemporaryDirectory() as folder:
        extract(path, unzipdir=folder)
        for line in tape:
            words = line.split()
            match words[0]:
                case "watch":
                    watched.setdefault(words[2], []).append((count, int(words[1])))
                    count += 1
                case "new":
                    now = int(words[1])
                    units[now] = Unit(description, folder, f"unit {now}")
                case "use":
                    now = int(words[1])
                case "set":
                    kind, text = words[2], words[3]
                    value = struct.unpack(">d", bytes.fromhex(text))[0] if kind == "r" else int(text)
                    units[now].set(int(words[1]), kind, value)
                case "step":
                    status = units[now].step(int(words[1]), size)
                    print(f"={status}", *units[now].read(watched), file=output)
                case "reset":
                    units[now].reset()
                case "save":
                    states[words[1]] = units[now].save()
                case "load":
                    units[now].load(states[words[1]])
                case "bytes":
                    states[words[1]] = units[now].rewrite(states[words[1]])
        for _, state in states.values():
            units[0].fmu.freeFMUState(state)
        for unit in units.values():
            unit.fmu.terminate()
            unit.fmu.freeInstance()
    print("HOST PASSED", file=output)


if sys.argv[1] == "validate":
    for path in sys.argv[2:]:
        for problem in validate(path):
            print(f"{path}: {problem}")
    print("HOST PASSED")
else:
    for line in Path(sys.argv[2]).read_text().splitlines():
        path, tape, output = line.split("\t")
        with open(output, "w") as written:
            play(path, Path(tape).read_text().splitlines(), written)
    print("HOST PASSED")
