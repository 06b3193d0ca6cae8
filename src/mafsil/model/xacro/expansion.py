"""A xacro file expanded into the plain URDF tree that it stands for, every element with the place it came from."""

from __future__ import annotations

import re
from collections.abc import Iterator
from keyword import iskeyword

from mafsil.model.asset_path import Assets
from mafsil.model.faults import (
    PACKAGE_NOT_FOUND,
    TOO_DEEP,
    TOO_MANY_ELEMENTS,
    XACRO_ATTRIBUTE,
    XACRO_BLOCK,
    XACRO_BLOCKS,
    XACRO_FOREIGN_PARAMETER,
    XACRO_LEFT_OVER,
    XACRO_MACRO,
    XACRO_NAME,
    XACRO_PACKAGE,
    XACRO_PARAMETER,
)
from mafsil.model.reading import Reading
from mafsil.model.vocabulary import nearest_words
from mafsil.model.xacro.files import Files
from mafsil.model.xacro.methods import global_names
from mafsil.model.xacro.scope import Macro, Scope, Substitution
from mafsil.model.xacro.values import Budget, Reported, XacroFault, parameters_of, truth
from mafsil.model.xacro.vocabulary import CONSTRUCTS, DEFINITIONS, PREFIX, is_construct, is_source
from mafsil.model.xml_tree import Element, ReadLimits, Refusal

UNREAD = ("gazebo", "ros2_control")
"""Elements that say nothing about the mechanism: neither expanded nor read."""
STEPS = 2_000_000
CALL = 60
"""Steps of a macro call itself."""
DEEPEST = 80
"""Macro calls inside one another."""
_NAME = re.compile(r"[^\W\d]\w*")


def is_xacro(root: Element) -> bool:
    """Whether a document holds anything that xacro would expand."""
    return any(element.tag.startswith(PREFIX) or _asks(element) for element in _read_elements(root))


def _asks(element: Element) -> bool:
    """Whether an attribute asks for a value."""
    return any("${" in text or "$(" in text for text in element.attributes.values())


def left_over(root: Element) -> list[Element]:
    """What a finished document still holds: definitions that nothing uses, or calls of macros that nothing defines.

    Returns:
        The elements, or nothing if the document is no finished one.
    """
    found = [element for element in _read_elements(root) if element.tag.startswith(PREFIX)]
    if not any(map(is_construct, found)):
        asks = any(_asks(element) for element in _read_elements(root))
        return [] if asks or root.first("link") is None else found
    if any(element.tag.removeprefix(PREFIX) not in DEFINITIONS for element in root.children if element in found):
        return []
    if _asks(root):
        return []
    outside = [child for child in root.children if child not in found]
    if not any(child.tag == "link" for child in outside) or any(is_xacro(child) for child in outside):
        return []
    return [child for child in root.children if child in found]


def expand(reading: Reading, assets: Assets, limits: ReadLimits) -> Element | None:
    """The expanded root element of a reading's document, or None after an error that was reported.

    Elements keep the place of what they came from; none offers repairs, as none stands in the file as it is.

    Args:
        reading: of the file; its `arguments` are those of `$(arg name)`.
        assets: where included files and packages may lie.
        limits: of the expanded document.
    """
    return _Expansion(reading, assets, limits).run()


def _read_elements(root: Element) -> Iterator[Element]:
    """The element and all below it, but those that no reader looks at."""
    waiting = [root]
    while waiting:
        element = waiting.pop()
        if element.tag not in UNREAD and element.tag != "plugin":
            yield element
            waiting.extend(reversed(element.children))


class _Expansion:
    """The state of one expansion."""

    def __init__(self, reading: Reading, assets: Assets, limits: ReadLimits) -> None:
        self.reading = reading
        self.budget = Budget(STEPS)
        self.elements = limits.elements
        self.limits = limits
        self.calls = 0
        self.files = Files(reading, assets, limits, self.budget)
        self.substitution = Substitution(self.files.commands(), self.budget)
        self.top = Scope(self.substitution.value, global_names(self.files.functions()))
        self.missing: set[str] = set()
        self.finished = not any(map(is_source, _read_elements(reading.document.root)))

    def run(self) -> Element | None:
        """The expanded root, or None after an error."""
        root = self.files.begin()
        result = self._made(root, {}, [])
        try:
            result.children = self._contents(root, self.top, result)
            result.attributes |= self._evaluate(root, self.top)  # last: they may use arguments declared inside
        except XacroFault as fault:
            self.reading.report(fault.fault, root, None, None, **fault.details)
            return None
        except Reported:
            return None
        except RecursionError:
            raise Refusal(self.files.diagnostic(TOO_DEEP, root, limit=DEEPEST)) from None
        self.files.report_unused_arguments(root)
        return result

    def _contents(self, element: Element, scope: Scope, holder: Element) -> list[Element]:
        """The children of an element, expanded; `holder` is what they will stand in."""
        result: list[Element] = []
        for child in element.children:
            result.extend(self._place(child, scope, holder))
        return result

    def _place(self, element: Element, scope: Scope, holder: Element) -> list[Element]:
        """What an element becomes; a fault gets the place of the innermost element that has one."""
        try:
            return self._one(element, scope, holder)
        except XacroFault as fault:
            self.reading.report(fault.fault, element, None, None, **fault.details)
            raise Reported from None

    def _one(self, element: Element, scope: Scope, holder: Element) -> list[Element]:
        self.budget.spend()
        if element.tag in UNREAD:
            return [self._made(element, {}, [])]
        if not element.tag.startswith(PREFIX):
            made = self._copy(element, scope)
            made.children = self._contents(element, scope, made)
            return [made]
        name = element.tag.removeprefix(PREFIX)
        match name:
            case "property":
                self._define_property(element, scope)
            case "macro":
                self._define_macro(element, scope)
            case "arg":
                self.files.declare(self._attribute(element, "name", scope), self._attribute(element, "default", scope))
            case "if" | "unless":
                condition = self._require(element, "value")
                holds = truth(self.substitution.value(condition, scope), condition)
                return self._contents(element, scope, holder) if holds is (name == "if") else []
            case "include":
                return self._include(element, scope, holder)
            case "insert_block":
                return self._insert_block(element, scope, holder)
            case "element":
                named = self._made(element, self._evaluate(element, scope), [])
                named.tag = self.substitution.text(self._require(element, "xacro:name"), scope)
                named.children = self._contents(element, scope, named)
                return [named]
            case "attribute":
                holder.attributes[self._attribute(element, "name", scope)] = self._attribute(element, "value", scope)
            case "call":
                return self._call(element, self._attribute(element, "macro", scope), scope, holder)
            case _:
                return self._call(element, name, scope, holder)
        return []

    def _copy(self, element: Element, scope: Scope) -> Element:
        """An ordinary element with its attributes and its text evaluated, still without children."""
        text = self.substitution.text(element.text, scope) if not element.children else ""
        made = self._made(element, self._evaluate(element, scope), [])
        made.text = text
        return made

    def _evaluate(self, element: Element, scope: Scope) -> dict[str, str]:
        attributes: dict[str, str] = {}
        for key, value in element.attributes.items():
            if key.startswith((PREFIX, "xmlns:xacro")):
                continue
            try:
                attributes[key] = self.substitution.text(value, scope)
            except XacroFault as fault:
                if fault.fault is not XACRO_PACKAGE or element.tag not in ("mesh", "texture"):
                    raise
                attributes[key] = value
                self._say_missing(element, str(fault.details["package"]))
        return attributes

    def _say_missing(self, element: Element, package: str) -> None:
        """A mesh in an unknown package does not stop the mechanics; said once for each package."""
        if package not in self.missing:
            self.missing.add(package)
            self.reading.report(PACKAGE_NOT_FOUND, element, "filename", None, reference="", package=package)

    def _made(self, element: Element, attributes: dict[str, str], children: list[Element]) -> Element:
        """A new element at the place of another one."""
        self.budget.spend(len(attributes))
        self.elements -= 1
        if self.elements < 0:
            raise XacroFault(TOO_MANY_ELEMENTS, limit=self.limits.elements)
        return Element(
            element.tag, attributes, element.line, element.column, element.start, element.close, children,
            element.text, element.file,
        )  # fmt: skip

    def _require(self, element: Element, name: str) -> str:
        """The unevaluated text of an attribute that must be there."""
        if name not in element.attributes:
            raise XacroFault(XACRO_ATTRIBUTE, element=element.tag, attribute=name)
        return element.attributes[name]

    def _attribute(self, element: Element, name: str, scope: Scope) -> str:
        return self.substitution.text(self._require(element, name), scope)

    def _define_property(self, element: Element, scope: Scope) -> None:
        """Rules of scope: `global` and `parent` are evaluated at once, everything else when it is first used."""
        name = self._attribute(element, "name", scope)
        if not _NAME.fullmatch(name) or iskeyword(name) or name.startswith("__"):
            raise XacroFault(XACRO_NAME, name=name)
        given = element.attributes
        if truth(self.substitution.value(given.get("remove", "false"), scope), "remove"):
            scope.remove(name)
            return
        value = given.get("value")
        if value is None and "default" in given:
            if scope.defines(name):
                return
            value = given["default"]
        lazy = truth(self.substitution.value(given.get("lazy_eval", "true"), scope), "lazy_eval")
        target = self._target(given.get("scope", ""), scope)
        lazy &= target is scope
        if value is None:
            target.blocks["**" + name] = element
        else:
            target.put(name, value if lazy else self.substitution.value(value, scope), lazy=lazy)

    def _target(self, where: str, scope: Scope) -> Scope:
        """The scope in which a property is put."""
        if where == "global":
            return self.top
        if where != "parent" or scope.parent is None:
            return scope
        target = scope.parent
        while not scope.is_namespace and target.is_namespace and target.parent is not None:
            target = target.parent
        return target

    def _define_macro(self, element: Element, scope: Scope) -> None:
        name = self._require(element, "name").removeprefix(PREFIX)
        if not name or "." in name or name == "call":
            raise XacroFault(XACRO_NAME, name=name)
        scope.macros[name] = Macro(element, *parameters_of(element.get("params")))

    def _include(self, element: Element, scope: Scope, holder: Element) -> list[Element]:
        reference = self._attribute(element, "filename", scope)
        optional = truth(self.substitution.value(element.get("optional", "false"), scope), "optional")
        inside = scope
        if "ns" in element.attributes:
            inside = scope.inner(is_namespace=True)
            scope.spaces[self._attribute(element, "ns", scope)] = inside
        result: list[Element] = []
        for root in self.files.included_roots(reference, optional=optional):
            result.extend(self._contents(root, inside, holder))
            self.files.end()
        return result

    def _insert_block(self, element: Element, scope: Scope, holder: Element) -> list[Element]:
        name = self._attribute(element, "name", scope)
        several = scope.block("**" + name)
        if several is not None:
            return self._contents(several, scope, holder)
        single = scope.block("*" + name)
        if single is None:
            raise XacroFault(XACRO_BLOCK, name=name)
        return self._place(single, scope, holder)

    def _call(self, element: Element, name: str, scope: Scope, holder: Element) -> list[Element]:
        """A macro call.

        1. Attributes are evaluated where the call stands; each must be a parameter.
        2. The elements inside the call are expanded there too, and become the blocks, in order.
        3. Parameters left take their defaults: the caller's property of the same name, or the default's text.
        4. The body is expanded in a new scope inside the macro's.
        """
        found = scope.macro(name)
        if found is None and self.finished:
            self.reading.report(XACRO_LEFT_OVER, element, None, None, element=element.tag)
            return []
        if found is None:
            known = tuple(sorted(_macros(scope)))
            near = nearest_words(name, (*known, *CONSTRUCTS)) or known
            raise XacroFault(XACRO_MACRO, name=name, known=", ".join(near) or "-")
        around, macro = found
        self.budget.spend(CALL + 2 * len(macro.parameters))
        inner = around.inner()
        missing = list(macro.parameters)
        for key, text in element.attributes.items():
            if key == "macro" and element.tag == "xacro:call":
                continue
            if key not in missing:
                raise XacroFault(XACRO_FOREIGN_PARAMETER, macro=name, name=key, known=", ".join(macro.parameters))
            missing.remove(key)
            inner.put(key, self.substitution.value(text, scope), lazy=False)
        self._take_blocks(element, name, scope, inner, missing)
        for parameter in missing:
            if parameter.startswith("*"):
                continue
            inherits, default = macro.defaults.get(parameter, (False, None))
            if inherits and scope.defines(parameter):
                inner.put(parameter, scope.lookup(parameter), lazy=False)
            elif default is not None:
                inner.put(parameter, self.substitution.value(default, scope), lazy=False)
            else:
                raise XacroFault(XACRO_PARAMETER, macro=name, name=parameter)
        return self._body(macro, inner, holder)

    def _take_blocks(self, element: Element, name: str, scope: Scope, inner: Scope, missing: list[str]) -> None:
        """The elements inside a call, as the blocks that the macro asks for."""
        given = self._contents(element, scope, self._made(element, {}, []))
        expected = [parameter for parameter in missing if parameter.startswith("*")]
        if len(given) != len(expected):
            raise XacroFault(XACRO_BLOCKS, macro=name, expected=len(expected), got=len(given))
        inner.blocks |= dict(zip(expected, given, strict=True))

    def _body(self, macro: Macro, inner: Scope, holder: Element) -> list[Element]:
        self.calls += 1
        if self.calls > DEEPEST:
            raise XacroFault(TOO_DEEP, limit=DEEPEST)
        try:
            return self._contents(macro.body, inner, holder)
        finally:
            self.calls -= 1


def _macros(scope: Scope) -> Iterator[str]:
    for around in scope.around():
        yield from around.macros
        for space, inner in around.spaces.items():
            yield from (f"{space}.{name}" for name in inner.macros)
