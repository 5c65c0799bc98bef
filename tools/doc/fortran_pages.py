# SPDX-License-Identifier: BSD-3-Clause
"""Sphinx extension: pages of the Fortran modules, and links to them wherever a page names a source file.

`fortran-module` shows what a module offers, `fortran-layer` lists the modules of a folder of `src`.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any
from zlib import crc32

import fortran_reader
from docutils import nodes
from fortran_reader import Binding, Generic, Module, Procedure, Type, Variable, read_modules
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

CODE = re.compile(r"^[\w./]+\.[fF]90$")


def page_of(path: Path) -> str:
    """Returns the name of the page of a source file, whose path counts from `src`."""
    return f"fortran/{path.with_suffix('')}"


class Library:
    """All modules of a source tree."""

    def __init__(self, root: Path) -> None:
        """Reads all files below `root`; ValueError if a module has a public name that it neither declares nor uses."""
        self.modules = {module.name: module for module in read_modules(root)}
        self._types = {name: module for module in self.modules.values() for name in module.types}

    def of_layer(self, layer: str) -> list[Module]:
        """Returns the modules of a folder of `src` and of the folders below it."""
        return [module for module in self.modules.values() if module.path.parts[0] == layer]

    def with_file(self, name: str) -> Module | None:
        """Returns the module whose path ends with `name`; None if there is none or more than one."""
        ending = "/" + name.removeprefix("src/")
        found = [module for module in self.modules.values() if f"/{module.path.as_posix()}".endswith(ending)]
        return found[0] if len(found) == 1 else None

    def with_type(self, name: str) -> Module | None:
        """Returns the module that declares a type; None if there is none."""
        return self._types.get(name)

    def procedure(self, module: Module, name: str) -> Procedure | None:
        """Returns a procedure that the module has or uses; None if there is none of this name."""
        if name in module.procedures:
            return module.procedures[name]
        for used, names in module.uses.items():
            if name in names and used in self.modules:
                return self.modules[used].procedures.get(name)
        return None


def id_of(module: Module, *names: str) -> str:
    """Returns the anchor of a name on the page of the module; `names` are the owner, if it has one, and the name."""
    return nodes.make_id("-".join((module.name, *names)))


def texts(line: str) -> Iterator[nodes.Node]:
    """Yields the nodes of a line: texts, and code for what stands between backticks."""
    for i, part in enumerate(line.split("`")):
        if part:
            yield nodes.literal(text=part) if i % 2 else nodes.Text(part)


def prose(doc: Iterable[str]) -> Iterator[nodes.Node]:
    """Yields the paragraphs of a docstring; lines that begin with two blanks are formulas, shown as they are."""
    blocks: list[list[str]] = [[]]
    for line in doc:
        if not line.strip() or (blocks[-1] and line.startswith("  ") != blocks[-1][-1].startswith("  ")):
            blocks.append([])
        if line.strip():
            blocks[-1].append(line)
    for block in filter(None, blocks):
        if block[0].startswith("  "):
            indent = min(len(line) - len(line.lstrip()) for line in block)
            text = "\n".join(line[indent:] for line in block)
            yield nodes.literal_block(text, text, language="text")
        else:
            yield nodes.paragraph("", "", *texts(" ".join(block)))


class ModulePage:
    """Makes the nodes of the page of a module."""

    def __init__(self, library: Library, module: Module, uri_of) -> None:
        """Takes the module; `uri_of` returns the address of a page, given by its name, as seen from this page."""
        self._library = library
        self._module = module
        self._uri_of = uri_of

    def _link(self, module: Module, text: str, *names: str) -> nodes.reference:
        anchor = f"#{id_of(module, *names)}" if names else ""
        target = self._uri_of(page_of(module.path)) + anchor
        return nodes.reference("", "", nodes.literal(text=text), refuri=target, internal=True)

    def content(self) -> list[nodes.Node]:
        """Returns all nodes below the title."""
        module = self._module
        place = nodes.paragraph()
        if len(module.path.parts) > 1:  # main.F90 belongs to no layer
            layer = module.path.parts[0]
            way = nodes.reference("", layer, refuri=self._uri_of(f"fortran/{layer}"), internal=True)
            place += [nodes.Text("Layer "), way, nodes.Text(", file ")]
        else:
            place += nodes.Text("File ")
        place += nodes.literal(text=f"src/{module.path}")
        shown = [place, *prose(module.doc)]
        for name in module.public:
            shown += self._public(name)
        return [*shown, *self._handed_on(), *self._uses()]

    def _public(self, name: str) -> list[nodes.Node]:
        module = self._module
        if name in module.types:
            return self._type(module.types[name])
        if name in module.constants:
            return self._variable(module.constants[name])
        if name in module.procedures:
            return self._entry(
                name, module.procedures[name].heading, self._procedure(module.procedures[name])
            )
        if name in module.generics:
            return self._generic(module.generics[name])
        return []

    def _handed_on(self) -> Iterator[nodes.Node]:
        """Yields a paragraph with links to the public names that stand in other modules, if there are any."""
        module = self._module
        links = [
            self._link(self._library.modules[used], name, name)
            for used, names in module.uses.items()
            for name in names
            if name in module.public and used in self._library.modules
        ]
        if links:
            yield nodes.paragraph("", "", nodes.Text("Public here, too: "), *separated(links))

    def _uses(self) -> Iterator[nodes.Node]:
        links = [
            self._link(self._library.modules[name], name)
            for name in self._module.uses
            if name in self._library.modules
        ]
        if links:
            yield nodes.paragraph("", "", nodes.Text("Uses "), *separated(links))

    def _entry(self, name: str, heading: str, content: Iterable[nodes.Node], *owner: str) -> list[nodes.Node]:
        """Returns an index entry and a description: `heading` as code, and `content` below it.

        `name` stands in the heading; `owner` is the type or interface that it belongs to, if any.
        """
        anchor = id_of(self._module, *owner, name)
        before, _, after = heading.partition(name)
        signature = addnodes.desc_signature("", "", ids=[anchor], fullname=name, module=self._module.name)
        signature += addnodes.desc_annotation("", "", *self._typed(before))
        signature += addnodes.desc_name(name, name)
        signature += addnodes.desc_annotation("", "", *self._typed(after))
        description = addnodes.desc(
            "", signature, domain="f", objtype="entry", desctype="entry", noindex=False
        )
        description["classes"] += ["f", "entry"]
        description += addnodes.desc_content("", *content)
        entry = ("single", f"{name} ({'%'.join((self._module.name, *owner))})", anchor, "", None)
        return [addnodes.index(entries=[entry]), description]

    def _typed(self, text: str) -> Iterator[nodes.Node]:
        """Yields the nodes of code in which public types are links."""
        for word in re.split(r"(\b\w+_t\b)", text):
            module = self._library.with_type(word)
            if module and word in module.public:
                reference = self._link(module, word, word)
                yield nodes.reference("", word, refuri=reference["refuri"], internal=True)
            elif word:
                yield nodes.Text(word)

    def _variables(self, variables: list[Variable]) -> Iterator[nodes.Node]:
        """Yields a list with an entry per argument or component; nothing if there are none."""
        if not variables:
            return
        rows = nodes.bullet_list()
        for variable in variables:
            kind, _, name = variable.declaration.partition(" :: ")
            line = nodes.paragraph("", "", nodes.strong("", name), nodes.Text("  "))
            line += nodes.inline("", "", *self._typed(kind), classes=["f-kind"])
            rows += nodes.list_item("", line, *prose(variable.doc))
        yield rows

    def _variable(self, constant: Variable) -> list[nodes.Node]:
        return self._entry(constant.name, constant.declaration, prose(constant.doc))

    def _procedure(self, procedure: Procedure) -> list[nodes.Node]:
        return [*prose(procedure.doc), *self._variables(procedure.arguments)]

    def _generic(self, generic: Generic) -> list[nodes.Node]:
        content = list(prose(generic.doc))
        for name in generic.procedures:
            if procedure := self._library.procedure(self._module, name):
                content += self._entry(name, procedure.heading, self._procedure(procedure), generic.name)
        return self._entry(generic.name, f"interface {generic.name}", content)

    def _type(self, type_: Type) -> list[nodes.Node]:
        content = [*prose(type_.doc), *self._variables(type_.components)]
        for binding in type_.bindings:
            content += self._binding(type_, binding)
        return self._entry(type_.name, type_.heading, content)

    def _binding(self, type_: Type, binding: Binding) -> list[nodes.Node]:
        procedure = self._library.procedure(self._module, binding.target)
        if procedure is None:
            return self._entry(binding.name, f"procedure {binding.name}", [], type_.name)
        heading = re.sub(rf"\b{procedure.name}\b", binding.name, procedure.heading, count=1)
        is_self = bool(procedure.arguments) and procedure.arguments[0].declaration.startswith("class(")
        shown = Procedure(binding.name, heading, procedure.doc, procedure.arguments[is_self:])
        deferred = "deferred " if binding.is_deferred else ""
        return self._entry(binding.name, deferred + heading, self._procedure(shown), type_.name)


def separated(links: list[nodes.reference]) -> Iterator[nodes.Node]:
    """Yields the links with commas between them and a full stop behind."""
    for i, link in enumerate(links):
        yield link
        yield nodes.Text(", " if i < len(links) - 1 else ".")


class FortranModule(SphinxDirective):
    """The directive `fortran-module`: what a module offers; the argument is its name."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Returns the nodes; KeyError if there is no such module."""
        library = self.env.app.fortran_library
        here = self.env.docname
        page = ModulePage(
            library,
            library.modules[self.arguments[0]],
            lambda target: self.env.app.builder.get_relative_uri(here, target),
        )
        return page.content()


class FortranLayer(SphinxDirective):
    """The directive `fortran-layer`: the modules of a layer, each with its first paragraph.

    The argument is the folder of the layer.
    """

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Returns a list with links to the modules."""
        rows = nodes.bullet_list()
        for module in self.env.app.fortran_library.of_layer(self.arguments[0]):
            address = self.env.app.builder.get_relative_uri(self.env.docname, page_of(module.path))
            link = nodes.reference("", "", nodes.literal(text=module.name), refuri=address, internal=True)
            first = next(iter(prose(module.doc)), nodes.paragraph())
            rows += nodes.list_item("", nodes.paragraph("", "", link, nodes.Text("  "), *first.children))
        return [rows]


def link_files(app: Sphinx, doctree: nodes.document) -> None:
    """Makes links of the Fortran files that a page names as code, except of its own file."""
    library: Library = app.fortran_library
    docname = app.env.docname
    for literal in list(doctree.findall(nodes.literal)):
        name = literal.astext()
        if not CODE.match(name) or isinstance(literal.parent, nodes.reference):
            continue
        if module := library.with_file(name):
            target = page_of(module.path)
            if target != docname:
                address = app.builder.get_relative_uri(docname, target)
                literal.replace_self(
                    nodes.reference("", "", literal.deepcopy(), refuri=address, internal=True)
                )


def read_library(app: Sphinx) -> None:
    """Reads all modules, once per run, before the first page."""
    app.fortran_library = Library(Path(app.config.fortran_root))


def share_navigation(
    app: Sphinx, page: str, _template: str, context: dict[str, Any], _doctree: nodes.document | None
) -> None:
    """Gives all orphans of a folder one sidebar: no entry of it is theirs, and it takes longer than the rest of them."""
    if "orphan" not in app.env.metadata.get(page, {}):
        return
    make_tree = context["toctree"]
    folder = page.rpartition("/")[0]

    def toctree(**options: bool | int) -> str:
        key = (folder, *sorted(options.items()))
        if key not in app.navigation_trees:
            app.navigation_trees[key] = make_tree(**options)
        return app.navigation_trees[key]

    context["toctree"] = toctree


def setup(app: Sphinx) -> dict[str, int]:
    """Registers the directives and the procedures above; Sphinx calls it."""
    app.add_config_value("fortran_root", "", "env", str)
    app.add_directive("fortran-module", FortranModule)
    app.add_directive("fortran-layer", FortranLayer)
    app.connect("builder-inited", read_library)
    app.connect("doctree-read", link_files)
    app.navigation_trees = {}
    app.connect("html-page-context", share_navigation, priority=400)  # before the theme asks for the sidebar
    # pages of an earlier run that other code made are made again
    code = b"".join(Path(file).read_bytes() for file in (__file__, fortran_reader.__file__))
    return {"env_version": crc32(code), "parallel_read_safe": True, "parallel_write_safe": True}
