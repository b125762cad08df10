"""Mitsuba's XML as a tree of nodes that know their line: parameters, includes and aliases resolved, nothing else.

The parser is expat's, and a document with a DOCTYPE is refused, so that it can define no entities.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from woodcock.importing.report import SourceError, shown

MAX_BYTES = 64 << 20
MAX_NODES = 1 << 20
MAX_DEPTH = 64
MAX_VALUE = 1 << 20
MAX_INCLUDES = 15


@dataclass
class Node:
    """An element as it is written; `folder` is where its file looks for others."""

    tag: str
    attributes: dict[str, str]
    where: str
    folder: Path
    children: list[Node] = field(default_factory=list)


class Document:
    """The whole of a scene: `root`, and the nodes that have an id."""

    def __init__(self, path: Path) -> None:
        self.ids: dict[str, Node] = {}
        self._defaults: dict[str, str] = {}
        self._aliases: list[Node] = []
        self._count = self._depth = 0
        self._top = path.parent
        self._files: list[Path] = []
        self.root = self._read(path, str(path))
        for alias in self._aliases:
            self.ids[_attribute(alias, "as")] = self.find(_attribute(alias, "id"), alias.where)
        self._refuse_circles()

    def find(self, name: str, where: str) -> Node:
        if name not in self.ids:
            raise SourceError(f"{where}: refers to {shown(name)}, but nothing has this id")
        return self.ids[name]

    def _read(self, path: Path, where: str) -> Node:
        if path in self._files or len(self._files) > MAX_INCLUDES:
            raise SourceError(f"{where}: files include each other in a circle, or more than {MAX_INCLUDES} deep")
        self._files.append(path)
        root = self._expand(_parse(path, where, path.name if path.parent == self._top else str(path)))
        self._files.pop()
        if root.tag != "scene":
            raise SourceError(f"{root.where}: the outermost element must be <scene>, not <{root.tag[:40]}>")
        return root

    def _expand(self, node: Node) -> Node:
        """With $names replaced, and <include>, <default>, <alias> and <path> carried out."""
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise SourceError(f"{node.where}: elements are nested more than {MAX_DEPTH} deep")
        node.attributes = {key: self._replaced(value, node.where) for key, value in node.attributes.items()}
        if (name := node.attributes.get("id")) and node.tag != "ref":
            if name in self.ids:
                raise SourceError(f"{node.where}: the id {shown(name)} is there already, at {self.ids[name].where}")
            self.ids[name] = node
        written, node.children = node.children, []
        folder = node.folder
        for child in written:
            child.folder = folder
            if child.tag == "path":
                folder = folder / _file(self._replaced(_attribute(child, "value"), child.where), child.where)
            elif child.tag == "default":
                name, value = _attribute(child, "name"), _attribute(child, "value")
                self._defaults.setdefault(name, self._replaced(value, child.where))
            elif child.tag == "include":
                name = _file(self._replaced(_attribute(child, "filename"), child.where), child.where)
                node.children += self._read(folder / name, child.where).children
            elif child.tag == "alias":
                child.attributes = {k: self._replaced(v, child.where) for k, v in child.attributes.items()}
                self._aliases.append(child)
            else:
                node.children.append(self._expand(child))
        self._depth -= 1
        self._count += 1
        if self._count > MAX_NODES:
            raise SourceError(f"{node.where}: the scene has more than {MAX_NODES} elements")
        return node

    def _replaced(self, text: str, where: str) -> str:
        def value(match: re.Match[str]) -> str:
            if match[1] not in self._defaults:
                raise SourceError(
                    f'{where}: {shown("$" + match[1])} has no <default name="{match[1][:40]}" value="…"/>'
                )
            return self._defaults[match[1]]

        text = re.sub(r"\$(\w+)", value, text)
        if len(text) > MAX_VALUE:
            raise SourceError(f"{where}: a value is longer than {MAX_VALUE} letters")
        return text

    def _refuse_circles(self) -> None:
        """What follows references may rely on their end, and that it is not far."""
        done: set[int] = set()
        path: list[int] = []

        def visit(node: Node) -> None:
            if id(node) in path or len(path) > MAX_DEPTH:
                raise SourceError(f"{node.where}: references run in a circle, or more than {MAX_DEPTH} deep")
            if id(node) in done:
                return
            path.append(id(node))
            for child in node.children:
                visit(self.find(_attribute(child, "id"), child.where) if child.tag == "ref" else child)
            path.pop()
            done.add(id(node))

        visit(self.root)


def _attribute(node: Node, name: str) -> str:
    if name not in node.attributes:
        raise SourceError(f"{node.where}: <{node.tag}> needs the attribute {name}")
    return node.attributes[name]


def _file(name: str, where: str) -> str:
    if not name or "\0" in name:
        raise SourceError(f"{where}: {shown(name)} is no name of a file")
    return name


def _parse(path: Path, where: str, name: str) -> Node:
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise SourceError(f"{where}: {shown(name)} cannot be read: {getattr(error, 'strerror', error)}") from None
    if len(data) > MAX_BYTES:
        raise SourceError(f"{name}: is larger than {MAX_BYTES >> 20} MiB")
    top = Node("", {}, name, path.parent)
    stack = [top]
    parser = expat.ParserCreate()

    def here() -> str:
        return f"{name}:{parser.CurrentLineNumber}"

    def start(tag: str, attributes: dict[str, str]) -> None:
        node = Node(tag, attributes, here(), path.parent)
        stack[-1].children.append(node)
        stack.append(node)
        if len(stack) > MAX_DEPTH:
            raise SourceError(f"{node.where}: elements are nested more than {MAX_DEPTH} deep")

    def end(_: str) -> None:
        stack.pop()

    def text(letters: str) -> None:
        if letters.strip():
            raise SourceError(f"{here()}: text between elements means nothing: {shown(letters.strip())}")

    def doctype(*_: object) -> None:
        raise SourceError(f"{here()}: a DOCTYPE is not allowed")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = text, doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise SourceError(f"{name}:{error.lineno}: is no XML: {expat.ErrorString(error.code)}") from None
    except (ValueError, LookupError) as error:  # an encoding that Python or expat does not know
        if isinstance(error, SourceError):
            raise
        raise SourceError(f"{name}: cannot be decoded: {error}") from None
    return top.children[0]
