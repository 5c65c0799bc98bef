# SPDX-License-Identifier: BSD-3-Clause
"""Writes a model as a Functional Mock-up Unit (FMU) of FMI 3.0, for simulators of systems."""

import hashlib
import html
import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from signorom_post import __version__
from signorom_post.answer import Answer, NoAnswerError
from signorom_post.errors import InputError
from signorom_post.fmu_units import moment_unit, unit_definitions
from signorom_post.library import loaded_library
from signorom_post.online import DISPLACEMENT_NONE, Model

PLATFORM = "x86_64-linux"
WRAPPER = "libsignorom_fmu.so"
#: numbers of the kinds of outputs, as src/fmu/unit.h has them
AREA, FORCE, MOMENT, DISPLACEMENT, BOUND, DISPLACEMENT_BOUND, ESTIMATE, INSIDE = range(8)
#: libraries that each Linux has, or that must not be there twice in a process
OF_THE_SYSTEM = re.compile(
    r"^(linux-vdso|ld-linux|libc|libm|libdl|libpthread|librt|libresolv|libgcc_s|libstdc\+\+)(?=[.-])"
)


@dataclass(frozen=True)
class Output:
    """An output of the FMU, and what the binary of the FMU needs to find its value."""

    name: str
    #: unit of measure; empty: none
    unit: str
    description: str
    #: one of AREA, FORCE, MOMENT, DISPLACEMENT, BOUND, DISPLACEMENT_BOUND, ESTIMATE, INSIDE
    kind: int
    #: number of the contact of the deck, or of the node among the chosen nodes, from 0
    entry: int = 0
    #: direction of a vector, from 0
    component: int = 0


def write_fmu(model: Model, path: Path, output: Path, tags: list[int]) -> str:
    """Writes the FMU `output` of a model whose file is `path`; returns why it has no derivatives, empty if it has them.

    Its outputs are area, force and moment of each contact of the deck, the displacements of the nodes `tags` (numbers
    of the mesh file), the relative bounds of the errors of contact forces and displacements and the estimate of the
    error if the model gives them in the middle of its box, and is_inside_box. Where the model remembers
    (Model.remembers) they are those of the last step, and the inputs are the tables; the parameters of the deck stay as
    they are. InputError if a node is unknown, is named twice or has no displacement, or if a library that the FMU needs
    is missing. NoAnswerError if the model has no answer in the middle of its box. OSError if the model
    file cannot be read or the FMU cannot be written.
    """
    content = path.read_bytes()
    token = hashlib.sha256(content).hexdigest()
    nodes = places_of(model, path, tags)
    outputs = outputs_of(model, tags)
    name = identifier(model.title)
    libraries = libraries_of_unit()
    refusal = refusal_of_gradient(model)
    partial = output.with_name(output.name + ".partial")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as unit:
        unit.writestr("modelDescription.xml", description(model, name, token, outputs, not refusal))
        unit.writestr("resources/model.h5", content)
        unit.writestr("resources/outputs.txt", table(token, nodes, outputs))
        unit.writestr("documentation/index.html", documentation(model))
        unit.writestr("documentation/licenses/license.spdx", "BSD-3-Clause\n")
        for target, source in libraries.items():
            unit.write(source, f"binaries/{PLATFORM}/{target.format(name=name)}")
    partial.replace(output)
    return refusal


def identifier(text: str) -> str:
    """Returns a valid name for C and FMI from a text: ASCII letters, digits and underscores; it starts with a letter.

    Each run of other characters becomes one underscore, and underscores at both ends are removed. The text is cut to 60
    characters; if it does not start with a letter then, `m_` comes before it. If nothing is left, the name is `m`.
    """
    word = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")[:60]
    return word if re.match(r"[A-Za-z]", word) else f"m_{word}".rstrip("_")


def places_of(model: Model, path: Path, tags: list[int]) -> list[int]:
    """Returns the positions, from 0, of the nodes `tags` (numbers of the mesh file) in the model's list of nodes.

    InputError, with `path` as the file, if a node is unknown, has no displacement or is named twice.
    """
    repeated = {tag for tag in tags if tags.count(tag) > 1}
    if repeated:
        raise InputError(path, f"the node {min(repeated)} is named more than once")
    all_tags, sources = model.nodes[0], model.displacement_sources
    places = []
    for tag in tags:
        found = np.flatnonzero(all_tags == tag)
        if len(found) == 0:
            raise InputError(path, f"the mesh of the model has no node {tag}")
        if sources[found[0]] == DISPLACEMENT_NONE:
            raise InputError(
                path,
                f"the model has no displacement of node {tag}; choose another node, or train again with a "
                "reduction.displacement that covers it",
            )
        places.append(int(found[0]))
    return places


def outputs_of(model: Model, tags: list[int]) -> list[Output]:
    """Returns the outputs of the FMU in their order; `write_fmu` says what they are.

    NoAnswerError if the model has no answer in the middle of its box.
    """
    length, force = model.length_unit, model.force_unit
    mechanics = (yaml.safe_load(model.deck).get("mesh") or {}).get("model", "")
    axes = "rz" if mechanics == "axisymmetric" else "xyz"
    area = length if mechanics.startswith("plane") else f"{length}^2"
    answer = answer_in_middle(model)
    n_dimensions, n_moments = answer.resultants.forces.shape[1], answer.resultants.moments.shape[1]
    turns = axes if n_moments > 1 else ["z" if mechanics.startswith("plane") else "rz"]
    outputs = []
    for entry, surfaces in enumerate(model.contact_names):
        name = f"contact_{entry + 1}"
        outputs.append(Output(f"{name}.area", area, f"Area of {surfaces} that touches", AREA, entry))
        for k in range(n_dimensions):
            text = f"Force on the first surface of {surfaces}, {axes[k]}"
            outputs.append(Output(f"{name}.force_{axes[k]}", force, text, FORCE, entry, k))
        for k in range(n_moments):
            text = f"Moment of this force about the origin, {turns[k]}"
            outputs.append(
                Output(f"{name}.moment_{turns[k]}", moment_unit(force, length), text, MOMENT, entry, k)
            )
    for i, tag in enumerate(tags):
        for k in range(n_dimensions):
            text = f"Displacement of node {tag}, {axes[k]}"
            outputs.append(Output(f"node_{tag}.displacement_{axes[k]}", length, text, DISPLACEMENT, i, k))
    if answer.relative_bound is not None:
        text = "Certificate: bound of the error of the contact forces, relative, in the norm of their energy"
        outputs.append(Output("relative_bound", "", text, BOUND))
    if answer.relative_displacement_bound is not None:
        text = "Certificate: bound of the error of the displacement, relative, in the norm of the stiffness"
        outputs.append(Output("relative_displacement_bound", "", text, DISPLACEMENT_BOUND))
    if answer.error_estimate is not None:
        text = "Estimate (no bound) of the error of the contact forces, relative to their size"
        outputs.append(Output("error_estimate", "", text, ESTIMATE))
    outputs.append(Output("is_inside_box", "", "The inputs lie in the trained box", INSIDE))
    return outputs


def middle(model: Model) -> dict[str, float]:
    """Returns the middle of the trained box, parameter name -> value. These are the start values of the FMU."""
    return {p.name: p.minimum + (p.maximum - p.minimum) / 2 for p in model.parameters}


def answer_in_middle(model: Model) -> Answer:
    """Returns the answer in the middle of the box; where the model remembers, after the deck's steps.

    NoAnswerError if there is none.
    """
    values = middle(model)
    if not model.remembers:
        return model.query(nodes=[], **values)
    with model.start(**given_of(model, values)) as history:
        return [history.advance(time, nodes=[]) for time in model.times][-1]


def given_of(model: Model, values: dict[str, float]) -> dict[str, float]:
    """Returns the values of the deck's parameters alone, without time and tables."""
    return dict(list(values.items())[: model.n_given])


def refusal_of_gradient(model: Model) -> str:
    """Returns why the model has no derivatives in the middle of its box, where the FMU starts; empty if it has them.

    Where the model remembers, derivatives are those of one step with respect to the tables: here the first one, which
    goes to the last trained time.
    """
    values = middle(model)
    try:
        if model.remembers:
            tables = dict(list(values.items())[model.n_given + 1 :])
            with model.start(**given_of(model, values)) as history:
                _ = history.advance(model.times[-1], nodes=[], **tables).gradient
        else:
            _ = answer_in_middle(model).gradient
    except NoAnswerError as error:
        return str(error)
    return ""


def table(token: str, nodes: list[int], outputs: list[Output]) -> str:
    """Returns the content of outputs.txt, which the binary of the FMU reads.

    It has the token, the number of nodes and the nodes, the number of outputs, and a line with kind, entry and
    component of each output.

    `token` is the checksum of the model file; `nodes` are positions, from 0, in the model's list of nodes.
    """
    lines = [f"signorom outputs 1 {token}", " ".join(map(str, [len(nodes), *nodes])), str(len(outputs))]
    lines += [f"{output.kind} {output.entry} {output.component}" for output in outputs]
    return "\n".join(lines) + "\n"


def description(model: Model, name: str, token: str, outputs: list[Output], has_gradient: bool) -> bytes:
    """Returns the content of modelDescription.xml.

    `name` is the identifier of the FMU, `token` the checksum of the model file, `outputs` those of `outputs_of`.
    `has_gradient` tells whether the FMU provides derivatives.
    """
    n_inputs = len(model.parameters)
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=model.title,
        instantiationToken=token,
        description=f"Reduced contact model of Signorom: {model.title}",
        generationTool=f"signorom-post {__version__}",
        license="BSD-3-Clause (the binary); the model belongs to who made it",
    )
    differentiates = str(has_gradient).lower()
    flags = {
        "modelIdentifier": name,
        "canGetAndSetFMUState": "true",
        "providesDirectionalDerivatives": differentiates,
        "providesAdjointDerivatives": differentiates,
    }
    if not model.remembers:
        ET.SubElement(root, "ModelExchange", flags)
    ET.SubElement(root, "CoSimulation", flags | {"canHandleVariableCommunicationStepSize": "true"})
    units = [parameter.unit for parameter in model.parameters] + [output.unit for output in outputs]
    root.append(unit_definitions(units))
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize="0.1")
    variables = ET.SubElement(root, "ModelVariables")
    time = {"name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous"}
    ET.SubElement(variables, "Float64", time)
    add_inputs(variables, model)
    for k, output in enumerate(outputs):
        add_output(variables, output, 1 + n_inputs + k)
    structure = ET.SubElement(root, "ModelStructure")
    first = model.n_given + 1 if model.remembers else 0
    dependencies = " ".join(str(1 + i) for i in range(first, n_inputs))
    for tag in ("Output", "InitialUnknown"):
        for k in range(len(outputs)):
            reference = str(1 + n_inputs + k)
            # before the first step nothing has happened, whatever the inputs are
            known = "" if model.remembers and tag == "InitialUnknown" else dependencies
            ET.SubElement(structure, tag, valueReference=reference, dependencies=known)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def add_inputs(variables: ET.Element, model: Model) -> None:
    """Adds the parameters of the model to the element `variables` as inputs, which may change at any time.

    Their value references count from 1. A parameter `time` gets the name `parameter.time`. Where the model remembers,
    those of the deck are parameters, and the time is the independent variable of the FMU.
    """
    start = middle(model)
    for i, parameter in enumerate(model.parameters):
        is_fixed = model.remembers and i < model.n_given
        if model.remembers and i == model.n_given:
            continue
        attributes = {
            "name": parameter.name if parameter.name != "time" else "parameter.time",
            "valueReference": str(1 + i),
            "causality": "parameter" if is_fixed else "input",
            "variability": "fixed" if is_fixed else "continuous",
            "start": repr(start[parameter.name]),
            "min": repr(parameter.minimum),
            "max": repr(parameter.maximum),
            "description": f"Parameter of the model, trained from {parameter.minimum:g} to {parameter.maximum:g}",
        }
        if parameter.unit not in ("", "-", "1"):
            attributes["unit"] = parameter.unit
        ET.SubElement(variables, "Float64", attributes)


def add_output(variables: ET.Element, output: Output, reference: int) -> None:
    """Adds one output to the element `variables`: a Boolean if its kind is INSIDE, else a Float64.

    `reference` is its value reference.
    """
    attributes = {
        "name": output.name,
        "valueReference": str(reference),
        "causality": "output",
        "variability": "discrete" if output.kind == INSIDE else "continuous",
        "description": output.description,
    }
    if output.unit:
        attributes["unit"] = output.unit
    ET.SubElement(variables, "Boolean" if output.kind == INSIDE else "Float64", attributes)


def documentation(model: Model) -> str:
    """Returns a page in HTML that describes the model: its title and the text that `signorom describe` prints."""
    text = html.escape(model.describe())
    inputs = "The inputs are its parameters."
    if model.remembers:
        inputs = (
            "Its answers depend on earlier ones: a step of the master is a step of the history, which begins at the "
            "time 0, where nothing has happened. Inputs are the tables at the end of the step, outputs are those of the "
            "last step. Parameters stay as they are from the first step on."
        )
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(model.title)}</title></head>'
        f"<body><h1>{html.escape(model.title)}</h1><p>A reduced contact model of Signorom. "
        f"{inputs} Outside their ranges the outputs are extrapolations, and is_inside_box is false. Where the model "
        f"has no answer, the FMU returns fmi3Discard.</p><pre>{text}</pre></body></html>\n"
    )


def libraries_of_unit() -> dict[str, Path]:
    """Returns the shared libraries that the FMU must contain: name in the FMU -> file on this machine.

    The first is the FMU's own binary, `{name}.so`: the caller puts the identifier for `{name}`. The others are all
    that it needs but those of OF_THE_SYSTEM. InputError if a library is missing.
    """
    online = loaded_library()
    wrapper = online.parent / WRAPPER
    if not wrapper.is_file():
        raise InputError(
            "signorom-post fmu",
            f"{WRAPPER} is missing beside {online}; both must be in one folder: build and install both again",
        )
    found = {"{name}.so": wrapper}
    said = subprocess.run(["ldd", wrapper], capture_output=True, text=True, check=True).stdout
    for line in said.splitlines():
        name, _, place = line.strip().partition(" => ")
        if not place or OF_THE_SYSTEM.match(name):
            continue
        if place == "not found":
            raise InputError("signorom-post fmu", f"the library {name}, which the FMU needs, is missing here")
        found[name] = Path(place.rpartition(" (")[0])
    return found
