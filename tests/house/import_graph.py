"""Which module of the package needs which: imports of every kind, those for type checkers and late ones counted.

A name that comes from a package counts as an import of the module that holds it, by the package's stub.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "mafsil"
MODULES = {
    ".".join(("mafsil", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(SOURCE.rglob("*.py"))
}


@cache
def import_graph() -> dict[str, set[str]]:
    """Modules, and the modules that each of them imports."""
    homes = {name: _homes(path.with_suffix(".pyi")) for name, path in MODULES.items() if path.stem == "__init__"}
    return {
        name: {module for module in _imports(path, homes) if module in MODULES and module not in homes} - {name}
        for name, path in MODULES.items()
        if name not in homes
    }


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Sets of modules that need each other, by Tarjan's algorithm."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(module: str) -> None:
        index[module] = low[module] = len(index)
        stack.append(module)
        for needed in sorted(graph[module]):
            if needed not in index:
                visit(needed)
                low[module] = min(low[module], low[needed])
            elif needed in stack:
                low[module] = min(low[module], index[needed])
        if low[module] == index[module]:
            start = stack.index(module)
            if len(stack) > start + 1:
                found.append(sorted(stack[start:]))
            del stack[start:]

    for module in graph:
        if module not in index:
            visit(module)
    return found


def _homes(stub: Path) -> dict[str, str]:
    """The module of each public name of a package."""
    statements = ast.parse(stub.read_text("utf-8")).body if stub.exists() else []
    return {
        alias.name: str(node.module) for node in statements if isinstance(node, ast.ImportFrom) for alias in node.names
    }


def _imports(path: Path, homes: dict[str, dict[str, str]]) -> Iterator[str]:
    tree = ast.parse(path.read_text("utf-8"))
    packages: dict[str, str] = {}
    for node in ast.walk(tree):
        for module, local in _statement(node):
            yield module
            if module in homes:
                packages[local] = module
        if isinstance(node, ast.ImportFrom) and node.module in homes:
            for alias in node.names:
                yield from _home(node.module, alias.name, homes)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in packages:
            yield from _home(packages[node.value.id], node.attr, homes)


def _statement(node: ast.AST) -> Iterator[tuple[str, str]]:
    """Modules that a statement names, and what they are called there."""
    if isinstance(node, ast.Import):
        yield from ((alias.name, alias.asname or alias.name) for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        yield node.module, ""
        yield from ((f"{node.module}.{alias.name}", alias.asname or alias.name) for alias in node.names)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in MODULES:
        yield node.value, ""


def _home(package: str, name: str, homes: dict[str, dict[str, str]]) -> Iterator[str]:
    """The module that holds a public name of a package, through the packages that pass it on."""
    home = homes[package].get(name, package)
    if home != package and home in homes:
        yield from _home(home, name, homes)
    else:
        yield f"{package}.{name}" if home == package else home
