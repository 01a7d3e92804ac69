"""A small importer of Functional Mock-up Units of FMI 2.0 and 3.0, for the tests: it unpacks one, reads its description and
calls its functions. What it checks of a description are the rules of the schemas in the standard (2.0.4, 3.0.1).
SPDX-License-Identifier: Apache-2.0"""
import ctypes
import re
import xml.etree.ElementTree as ET
import zipfile
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

OK, WARNING, DISCARD, ERROR = range(4)
LOG2 = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_char_p)
LOG3 = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    _fields_ = [("logger", LOG2), ("allocate", c_void_p), ("free", c_void_p), ("finished", c_void_p), ("environment", c_void_p)]


class EventInfo(ctypes.Structure):
    _fields_ = [(name, c_int) for name in ("again", "terminate", "nominals", "states", "next")] + [("time", c_double)]


def doubles(values):
    return (c_double * max(len(values), 1))(*values)


class Fmu:
    """An unpacked FMU: its description, and its library."""

    def __init__(self, path, folder, library=None):
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        self.folder = Path(folder)
        self.root = ET.parse(self.folder / "modelDescription.xml").getroot()
        self.version = int(self.root.get("fmiVersion")[0])
        self.token = self.root.get("guid" if self.version == 2 else "instantiationToken")
        self.identifier = self.root.find("CoSimulation").get("modelIdentifier")
        place = "linux64" if self.version == 2 else "x86_64-linux"
        self.library = ctypes.CDLL(str(library or self.folder / "binaries" / place / f"{self.identifier}.so"))
        self.variables = {v.get("name"): v for v in self.root.find("ModelVariables")}
        self.references = {name: int(v.get("valueReference")) for name, v in self.variables.items()}

    def function(self, name, result=c_int):
        found = getattr(self.library, f"fmi{self.version}{name}")
        found.restype = result
        return found

    def instance(self, exchange=False, token=None, folder=None, name=b"one"):
        return Instance(self, exchange, token or self.token, folder or self.folder, name)

    def outputs(self):
        return [name for name in self.variables if self.causality(name) == "output"]

    def causality(self, name):
        return self.variables[name].get("causality")


class Instance:
    """One instance; every call returns its status, and `said` holds the messages."""

    def __init__(self, fmu, exchange, token, folder, name):
        self.fmu, self.two, self.exchange, self.said = fmu, fmu.version == 2, exchange, []
        resources = Path(folder, "resources")
        if self.two:
            self.log = LOG2(lambda env, name, status, kind, form, message: self.said.append(message.decode()))
            self.callbacks = Callbacks(self.log, None, None, None, None)
            self.at = fmu.function("Instantiate", c_void_p)(name, 0 if exchange else 1, token.encode(),
                                                            resources.as_uri().encode(), byref(self.callbacks), 0, 0)
        else:
            self.log = LOG3(lambda env, status, kind, message: self.said.append(message.decode()))
            path = (str(resources) + "/").encode()
            if exchange:
                self.at = fmu.function("InstantiateModelExchange", c_void_p)(name, token.encode(), path, c_bool(0),
                                                                             c_bool(0), None, self.log)
            else:
                self.at = fmu.function("InstantiateCoSimulation", c_void_p)(
                    name, token.encode(), path, c_bool(0), c_bool(0), c_bool(0), c_bool(0), None, c_size_t(0), None, self.log,
                    None)

    def call(self, name, *arguments):
        return self.fmu.function(name)(c_void_p(self.at), *arguments)

    def free(self):
        self.fmu.function("FreeInstance", None)(c_void_p(self.at))
        self.at = None

    # --- life
    def set_up(self, start=0.0, stop=None):
        """FMI 2 alone; FMI 3 says the same as it enters initialization."""
        self.start, self.stop = start, stop
        if not self.two:
            return OK
        return self.call("SetupExperiment", 0, c_double(0), c_double(start), int(stop is not None), c_double(stop or 0))

    def enter(self):
        if self.two:
            return self.call("EnterInitializationMode")
        start, stop = getattr(self, "start", 0.0), getattr(self, "stop", None)
        return self.call("EnterInitializationMode", c_bool(0), c_double(0), c_double(start), c_bool(stop is not None),
                         c_double(stop or 0))

    def leave(self):
        return self.call("ExitInitializationMode")

    def begin(self, start=0.0, stop=None, **values):
        """From instantiated to the first step, with values set in between."""
        return [self.set_up(start, stop), self.enter(), self.set(**values), self.leave()]

    def step(self, at, length):
        if self.two:
            return self.call("DoStep", c_double(at), c_double(length), 1)
        flags, last = [c_bool() for _ in range(3)], c_double()
        return self.call("DoStep", c_double(at), c_double(length), c_bool(1), *map(byref, flags), byref(last))

    # --- variables, by name, where "_" stands for "."
    def names(self, names):
        given = [self.fmu.references.get(n, self.fmu.references.get(n.replace("_", "."))) for n in names]
        return (c_uint * max(len(given), 1))(*given)

    def set_values(self, names, values):
        count = [c_size_t(len(values))] * (1 if self.two else 2)
        return self.call("SetReal" if self.two else "SetFloat64", self.names(names), count[0], doubles(values), *count[1:])

    def set(self, **values):
        return self.set_values(list(values), list(values.values()))

    def get_values(self, names):
        values, count = doubles([0.0] * len(names)), [c_size_t(len(names))] * (1 if self.two else 2)
        status = self.call("GetReal" if self.two else "GetFloat64", self.names(names), count[0], values, *count[1:])
        return status, list(values)[:len(names)]

    def get(self, *names):
        status, values = self.get_values(names)
        if status != OK:
            raise AssertionError(self.said)
        return values

    # --- derivatives
    def derivative(self, unknowns, knowns, seed, adjoint=False):
        out = doubles([0.0] * (len(knowns) if adjoint else len(unknowns)))
        sizes = [] if self.two else [c_size_t(len(seed)), c_size_t(len(out))]
        status = self.call("GetAdjointDerivative" if adjoint else "GetDirectionalDerivative", self.names(unknowns),
                           c_size_t(len(unknowns)), self.names(knowns), c_size_t(len(knowns)), doubles(seed), *sizes[:1], out,
                           *sizes[1:])
        return status, list(out)

    # --- the whole state
    def state(self, name):
        return name.replace("State", "state").replace("Des", "DeS") if self.two else name

    def keep(self):
        state = c_void_p()
        return self.call(self.state("GetFMUState"), byref(state)), state

    def restore(self, state):
        return self.call(self.state("SetFMUState"), state)

    def drop(self, state):
        return self.call(self.state("FreeFMUState"), byref(state))

    def serialize(self, state):
        size = c_size_t()
        status = self.call(self.state("SerializedFMUStateSize"), state, byref(size))
        data = ctypes.create_string_buffer(size.value)
        return max(status, self.call(self.state("SerializeFMUState"), state, data, size)), data.raw

    def deserialize(self, data):
        state = c_void_p()
        return self.call(self.state("DeserializeFMUState"), data, c_size_t(len(data)), byref(state)), state

    # --- model exchange
    def event_mode(self):
        return self.call("EnterEventMode")

    def update(self):
        if self.two:
            return self.call("NewDiscreteStates", byref(EventInfo()))
        flags = [c_bool() for _ in range(5)]
        return self.call("UpdateDiscreteStates", *map(byref, flags), byref(c_double()))

    def continuous(self):
        return self.call("EnterContinuousTimeMode")

    def time(self, time):
        return self.call("SetTime", c_double(time))

    def states(self, values):
        return self.call("SetContinuousStates", doubles(values), c_size_t(len(values)))

    def get_states(self, count, name="ContinuousStates"):
        values = doubles([0.0] * count)
        return self.call(f"Get{name}", values, c_size_t(count)), list(values)

    def rates(self, count):
        return self.get_states(count, "Derivatives" if self.two else "ContinuousStateDerivatives")

    def completed(self):
        kind = c_int if self.two else c_bool
        return self.call("CompletedIntegratorStep", kind(1), byref(kind()), byref(kind()))


# --- the rules of modelDescription.xml -------------------------------------------------------------------------------------
# element: attributes that must be there, and those that may
TWO = {
    "fmiModelDescription": ("fmiVersion modelName guid", "description author version copyright license generationTool "
                            "generationDateAndTime variableNamingConvention numberOfEventIndicators"),
    "ModelExchange": ("modelIdentifier", "needsExecutionTool completedIntegratorStepNotNeeded canBeInstantiatedOnlyOncePerProcess "
                      "canNotUseMemoryManagementFunctions canGetAndSetFMUstate canSerializeFMUstate providesDirectionalDerivative"),
    "CoSimulation": ("modelIdentifier", "needsExecutionTool canHandleVariableCommunicationStepSize canInterpolateInputs "
                     "maxOutputDerivativeOrder canRunAsynchronuously canBeInstantiatedOnlyOncePerProcess "
                     "canNotUseMemoryManagementFunctions canGetAndSetFMUstate canSerializeFMUstate providesDirectionalDerivative"),
    "SourceFiles": ("", ""), "File": ("name", ""), "UnitDefinitions": ("", ""), "Unit": ("name", ""),
    "BaseUnit": ("", "kg m s A K mol cd rad factor offset"), "LogCategories": ("", ""), "Category": ("name", "description"),
    "DefaultExperiment": ("", "startTime stopTime tolerance stepSize"), "ModelVariables": ("", ""),
    "ScalarVariable": ("name valueReference", "description causality variability initial canHandleMultipleSetPerTimeInstant"),
    "Real": ("", "declaredType quantity unit displayUnit relativeQuantity min max nominal unbounded start derivative reinit"),
    "ModelStructure": ("", ""), "Outputs": ("", ""), "Derivatives": ("", ""), "InitialUnknowns": ("", ""),
    "Unknown": ("index", "dependencies dependenciesKind"),
}
THREE = {
    "fmiModelDescription": ("fmiVersion modelName instantiationToken", "description author version copyright license "
                            "generationTool generationDateAndTime variableNamingConvention"),
    "ModelExchange": ("modelIdentifier", "needsExecutionTool canBeInstantiatedOnlyOncePerProcess canGetAndSetFMUState "
                      "canSerializeFMUState providesDirectionalDerivatives providesAdjointDerivatives "
                      "providesPerElementDependencies needsCompletedIntegratorStep providesEvaluateDiscreteStates"),
    "CoSimulation": ("modelIdentifier", "needsExecutionTool canBeInstantiatedOnlyOncePerProcess canGetAndSetFMUState "
                     "canSerializeFMUState providesDirectionalDerivatives providesAdjointDerivatives "
                     "providesPerElementDependencies canHandleVariableCommunicationStepSize fixedInternalStepSize "
                     "maxOutputDerivativeOrder recommendedIntermediateInputSmoothness providesIntermediateUpdate "
                     "mightReturnEarlyFromDoStep canReturnEarlyAfterIntermediateUpdate hasEventMode providesEvaluateDiscreteStates"),
    "UnitDefinitions": ("", ""), "Unit": ("name", ""), "BaseUnit": ("", "kg m s A K mol cd rad factor offset"),
    "LogCategories": ("", ""), "Category": ("name", "description"),
    "DefaultExperiment": ("", "startTime stopTime tolerance stepSize"), "ModelVariables": ("", ""),
    "Float64": ("name valueReference", "description causality variability canHandleMultipleSetPerTimeInstant intermediateUpdate "
                "previous clocks declaredType initial quantity unit displayUnit relativeQuantity unbounded min max nominal start "
                "derivative reinit"),
    "ModelStructure": ("", ""), "Output": ("valueReference", "dependencies dependenciesKind"),
    "ContinuousStateDerivative": ("valueReference", "dependencies dependenciesKind"),
    "InitialUnknown": ("valueReference", "dependencies dependenciesKind"),
}
ORDER = ["ModelExchange", "CoSimulation", "UnitDefinitions", "TypeDefinitions", "LogCategories", "DefaultExperiment",
         "VendorAnnotations", "ModelVariables", "ModelStructure"]
STRUCTURE = {2: ["Outputs", "Derivatives", "InitialUnknowns"], 3: ["Output", "ContinuousStateDerivative", "InitialUnknown"]}
# causality: variabilities and whether there is an initial and a start (the tables of chapter 2.2.7 and 2.4.7.4)
KINDS = {("parameter", "fixed"): ("exact", True), ("parameter", "tunable"): ("exact", True), ("input", "continuous"): (None, True),
         ("output", "continuous"): ("calculated", False), ("independent", "continuous"): (None, False)}


def in_order(found, order):
    places = [order.index(tag) for tag in found]
    return places == sorted(places)


def faults(root):
    """What breaks the rules in a description, as a list of texts."""
    version, wrong = int(root.get("fmiVersion")[0]), []

    def need(holds, text):
        if not holds:
            wrong.append(text)

    # elements and attributes
    rules = TWO if version == 2 else THREE
    for element in root.iter():
        need(element.tag in rules, f"element {element.tag}")
        must, may = (set(names.split()) for names in rules.get(element.tag, ("", "")))
        given = set(element.keys())
        need(must <= given and given <= must | may, f"attributes of {element.tag}: {sorted(given ^ must)}")
        need(not (element.text or "").strip(), f"text in {element.tag}")
        for name, value in element.items():
            if name in ("index", "valueReference", "derivative", "numberOfEventIndicators"):
                need(re.fullmatch(r"\d+", value), f"{name} {value}")
            if name.startswith(("can", "provides", "needs", "completed", "has")):
                need(value in ("true", "false"), f"{name} {value}")
            if name in ("start", "min", "startTime", "stopTime", "stepSize"):
                float(value)
    need(root.get("fmiVersion") == {2: "2.0", 3: "3.0"}[version], "version")
    need(in_order([child.tag for child in root], ORDER), "the order of the elements")
    need(in_order([child.tag for child in root.find("ModelStructure")], STRUCTURE[version]), "the order of the structure")
    for kind in ("ModelExchange", "CoSimulation"):
        need(re.fullmatch(r"[A-Za-z_]\w*", root.find(kind).get("modelIdentifier")), "the identifier is a name in C")

    # variables
    variables = list(root.find("ModelVariables"))
    units = {unit.get("name") for unit in root.iter("Unit")}
    names = [v.get("name") for v in variables]
    need(len(set(names)) == len(names), "names are unique")
    need(not any(re.search(r"[\r\n\t]", name) for name in names), "names are of one line")
    key = {v.get("valueReference"): v for v in variables} if version == 3 else {str(n + 1): v for n, v in enumerate(variables)}
    need(len({v.get("valueReference") for v in variables}) == len(variables), "references are unique")
    unknown = {"outputs": [], "rates": [], "states": []}
    for at, v in key.items():
        kind = v if version == 3 else v[0]
        causality, variability = v.get("causality"), v.get("variability")
        rate = kind.get("derivative")
        initial, start = (("calculated", False) if rate else ("exact", True)) if causality == "local" else \
            KINDS.get((causality, variability), ("?", False))
        need(v.get("initial") == initial, f"{v.get('name')}: initial")
        need((kind.get("start") is not None) == start, f"{v.get('name')}: start")
        need(kind.get("unit") in units, f"{v.get('name')}: unit")
        if rate:
            need(key[rate].get("variability") == "continuous", f"{v.get('name')} derives a state")
            unknown["rates"].append(at)
            unknown["states"].append(rate)
        if causality == "output":
            unknown["outputs"].append(at)
    need(sum(v.get("causality") == "independent" for v in variables) == 1, "one independent variable")

    # the structure lists all of them, and the unknowns of the start
    name = "index" if version == 2 else "valueReference"
    listed = {tag: [u for u in root.find("ModelStructure").iter() if u.get(name) and
                    (u.tag == tag if version == 3 else u in list(root.find("ModelStructure").find(tag)))]
              for tag in STRUCTURE[version]}
    lists = [[u.get(name) for u in listed[tag]] for tag in STRUCTURE[version]]
    need(lists[0] == unknown["outputs"], "the outputs are listed")
    need(lists[1] == unknown["rates"], "the derivatives are listed")
    need(lists[2] == sorted(unknown["outputs"] + unknown["rates"], key=int), "the unknowns of the start are listed")
    for tag, elements in listed.items():
        for element in elements:
            for other in element.get("dependencies", "").split():
                need(other in key and (key[other].get("causality") == "input" or other in unknown["states"] or
                                       tag.startswith("Initial") and key[other].get("initial") == "exact"),
                     f"{tag} {element.get(name)} depends on {other}")
    return wrong
