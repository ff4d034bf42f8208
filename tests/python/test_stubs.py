# SPDX-License-Identifier: MIT
"""The type stubs and the docstrings are those of the module."""
import ast
import inspect
import pathlib
import re

import pytest

import poise
from poise import _core, results

STUB = ast.parse((pathlib.Path(poise.__file__).parent / "_core.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
# What every object has, and how Python shows it.
OF_PYTHON = {"__init__", "__repr__", "__eq__", "__hash__"}


def names_of(node):
    """The members that a class has in the stub."""
    names = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
    return names | {item.target.id for item in node.body if isinstance(item, ast.AnnAssign)}


def members_of(kind):
    """The members that a class has itself, private ones left out."""
    own = {name for name in vars(kind) if not name.startswith("_")}
    return own | {name for name in ("__bool__", "__len__", "__contains__", "__iter__", "__next__") if name in vars(kind)}


def test_every_public_name_of_the_module_is_in_the_stub_or_annotated():
    stubbed = set(CLASSES) | {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
    public = {name for name in vars(_core) if not name.startswith("_")} | {"__version__"}
    aliases = {node.targets[0].id for node in STUB.body if isinstance(node, ast.Assign)}
    assert stubbed == public, "the compiled module and its stub differ"
    assert not aliases & public
    for name in poise.__all__:
        thing = getattr(poise, name)
        if inspect.isfunction(thing):
            assert set(inspect.signature(thing).parameters) | {"return"} == set(thing.__annotations__), name
        else:
            assert name in public or name in ("Error", "results"), name


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_every_member_of_a_class_is_in_the_stub(name):
    assert names_of(CLASSES[name]) - OF_PYTHON == members_of(getattr(_core, name)) - OF_PYTHON


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_arguments_in_the_stub_are_those_of_the_module(name):
    for item in CLASSES[name].body:
        if not isinstance(item, ast.FunctionDef) or item.decorator_list and item.decorator_list[0].__class__ is ast.Attribute:
            continue
        member = vars(getattr(_core, name)).get(item.name)
        if isinstance(member, property) or item.name in OF_PYTHON - {"__init__"}:
            continue
        stubbed = [arg.arg for arg in item.args.args + item.args.kwonlyargs if arg.arg != "self"]
        signature = getattr(getattr(_core, name), item.name).__doc__.splitlines()[0]
        actual = [arg for arg in re.findall(r"[(,] (?=\w)?(\w+):|\((\w+):", signature)]
        actual = [a or b for a, b in actual if (a or b) not in ("self", "arg0")]
        if not item.name.startswith("__") or item.name == "__init__":
            assert stubbed == actual, "%s.%s: %s" % (name, item.name, signature)


def test_every_public_thing_has_a_docstring():
    assert "Names carry units" in poise.__doc__ and results.__doc__
    for name in poise.__all__:
        thing = getattr(poise, name)
        if not isinstance(thing, str):
            assert (inspect.getdoc(thing) or "").strip(), name
        if isinstance(thing, type) and name in CLASSES:
            for member in members_of(thing):
                if member.startswith("__"):
                    continue
                doc = inspect.getdoc(getattr(thing, member)) or ""
                # pybind11 gives every function its signature; that alone says nothing.
                text = doc.split("\n\n", 1)[1] if re.match(r"\w+\(", doc) and "\n\n" in doc else doc
                assert len(text) > 5 and not re.match(r"\w+\(.*\) -> \S+$", text), "%s.%s" % (name, member)


def test_help_reads_without_names_of_the_inside():
    import pydoc
    text = pydoc.plain(pydoc.render_doc(poise))
    for inside in ("poise::", "_core.", "WorldValue", "SettingsValue", "PolicyValue"):
        assert inside not in text, [line for line in text.splitlines() if inside in line][:3]
    assert "class World(" in text and "class Error(" in text and "frames_table(" in text
