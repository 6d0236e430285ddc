"""What of the product nothing of the product comes to: definitions that only tests, studies or benches would use.

A definition is a function or class at the top of a file. From what runs when a file is imported, from entry points and
from what a page of the documentation names, whatever is named is reached, and whatever that names.
"""

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

Definition = tuple[str, str]
"""Module and name."""
_MAKERS = {"dataclass", "contextmanager", "cache", "remembered", "runtime_checkable"}
"""Decorators that hand what they are given to nobody."""


@dataclass
class _Module:
    """What the names of a file stand for."""

    defined: dict[str, ast.stmt] = field(default_factory=dict)
    names: dict[str, Definition] = field(default_factory=dict)
    """Local names of definitions elsewhere."""
    modules: dict[str, str] = field(default_factory=dict)
    """Local names of modules."""


def unreached(trees: Mapping[str, ast.Module], roots: set[Definition]) -> list[str]:
    """Return ``module:name`` of definitions that nothing comes to; ``trees`` by dotted name of their module."""
    modules = {name: _module(tree, trees) for name, tree in trees.items()}
    reached: set[Definition] = set()
    waiting = list(roots)
    for name, tree in trees.items():
        for statement in tree.body:
            if not _is_definition(statement):
                waiting += _named(statement, name, modules)
            elif any(_is_registered(decorator) for decorator in statement.decorator_list):
                waiting.append((name, statement.name))
    while waiting:
        definition = waiting.pop()
        module = modules.get(definition[0])
        if definition in reached or module is None:
            continue
        reached.add(definition)
        if definition[1] in module.defined:
            waiting += _named(module.defined[definition[1]], definition[0], modules)
        elif definition[1] in module.names:
            waiting.append(module.names[definition[1]])
    everything = {(name, defined) for name, module in modules.items() for defined in module.defined}
    return sorted(f"{module}:{name}" for module, name in everything - reached)


def _module(tree: ast.Module, trees: Mapping[str, ast.Module]) -> _Module:
    found = _Module()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            for alias in node.names:
                local, whole = alias.asname or alias.name, f"{node.module}.{alias.name}"
                if whole in trees:
                    found.modules[local] = whole
                elif node.module in trees:
                    found.names[local] = (node.module, alias.name)
        elif isinstance(node, ast.Import):
            found.modules |= {alias.asname: alias.name for alias in node.names if alias.asname is not None}
    found.defined = {statement.name: statement for statement in tree.body if _is_definition(statement)}
    return found


def _is_definition(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)


def _is_registered(decorator: ast.expr) -> bool:
    """Return whether a decorator may keep what it is given, as commands and event listeners are kept."""
    while isinstance(decorator, ast.Call):
        decorator = decorator.func
    return ast.unparse(decorator).rpartition(".")[2] not in _MAKERS


def _named(node: ast.AST, name: str, modules: Mapping[str, _Module]) -> Iterator[Definition]:
    module = modules[name]
    of_attributes = {id(inner.value) for inner in ast.walk(node) if isinstance(inner, ast.Attribute)}
    for inner in ast.walk(node):
        if isinstance(inner, ast.Name):
            if inner.id in module.defined:
                yield name, inner.id
            if inner.id in module.names:
                yield module.names[inner.id]
            if inner.id in module.modules and id(inner) not in of_attributes:
                whole = module.modules[inner.id]
                yield from ((whole, defined) for defined in (modules[whole].defined if whole in modules else ()))
        elif isinstance(inner, ast.Attribute):
            source = _module_of(inner.value, module)
            if source is not None:
                yield source, inner.attr
        elif isinstance(inner, ast.Constant) and isinstance(inner.value, str):
            yield from _by_text(inner.value, name, modules)


def _module_of(value: ast.expr, module: _Module) -> str | None:
    """Return the module that an expression is: one that was imported by a name, or is by ``import_module``."""
    match value:
        case ast.Name(name):
            return module.modules.get(name)
        case ast.Call(ast.Name("import_module"), [ast.Constant(str(name))]):
            return name
    return None


def _by_text(text: str, name: str, modules: Mapping[str, _Module]) -> Iterator[Definition]:
    """Return what a text names: ``part.of.module:name``, or a name of the same file, as quoted annotations have it."""
    where, colon, attribute = text.partition(":")
    if colon and attribute.isidentifier():
        yield from ((module, attribute) for module in modules if module == where or module.endswith(f".{where}"))
    elif text.isidentifier() and text in modules[name].defined:
        yield name, text
