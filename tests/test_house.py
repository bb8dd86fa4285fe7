# SPDX-License-Identifier: Apache-2.0
"""The habits of the house that no linter knows: what is at the top of every file."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections import Counter
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

from tests.rigs.sources import nodes, parsed

ROOT = Path(__file__).parents[1]
OURS = ("rai_missions", "visualize")
FOLDERS = (*OURS, "missions", "benchmarks", "tests")
POINTS_BACK = re.compile(r"(?:The same|Its?|They|Those|That|Of|So (?:much|many)|All but)\b")
"""How a docstring begins that is read only after another one."""
AS_A_FIELD = re.compile(r"(?:The same|They|Those|That|So (?:much|many)|All but)\b")
"""How the text under a field or an attribute begins that is read only after another one."""
ITSELF = re.compile(r" +\w+: It\.$")
LICENCE = "# SPDX-License-Identifier: Apache-2.0"


def files(folder: str) -> Iterator[tuple[str, str]]:
    """The name and the text of each that has one."""
    for path in sorted((ROOT / folder).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if text.strip():
            yield str(path.relative_to(ROOT)), text


def text_of(node: ast.AST) -> str:
    """The text that is a statement by itself; empty for any other statement."""
    value = node.value if isinstance(node, ast.Expr) else None
    return value.value if isinstance(value, ast.Constant) and isinstance(value.value, str) else ""


def offers(text: str) -> list[ast.expr | None]:
    """What is given to `__all__`, each time."""
    return [
        node.value
        for node in parsed(text).body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        and any(isinstance(t, ast.Name) and t.id == "__all__" for t in getattr(node, "targets", [node]))
    ]


def docstring_of(text: str) -> str:
    """What a file is for: the text with which it begins. Most of the tests are parsed for nothing else."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in (tokenize.COMMENT, tokenize.NL):
            return str(ast.literal_eval(token.string)) if token.type == tokenize.STRING else ""
    return ""


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_file_begins_with_its_licence_and_its_role(folder: str) -> None:
    faults = list[str]()
    for name, text in files(folder):
        if LICENCE not in text.splitlines()[:2]:
            faults.append(f"{name}:1: begin with {LICENCE!r}")
        if not docstring_of(text).strip():
            faults.append(f"{name}:2: give the room's role in a docstring")
    assert faults == []


@pytest.mark.parametrize("folder", OURS)
def test_a_docstring_begins_with_what_it_explains(folder: str) -> None:
    faults = [
        f"{name}:{node.lineno}: {first!r}: name what is meant; a reader may have seen nothing of what is above"
        for name, text in files(folder)
        for node in nodes(parsed(text))
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        for first in (ast.get_docstring(node) or "").splitlines()[:1]
        if POINTS_BACK.match(first)
    ]
    faults += [
        f"{name}:{after.lineno}: {text!r}: name what is meant"
        for name, source in files(folder)
        for node in nodes(parsed(source))
        for before, after in pairwise(
            node.body if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) else ()
        )
        if isinstance(before, ast.Assign | ast.AnnAssign) and (text := text_of(after))
        if AS_A_FIELD.match(text) or (isinstance(node, ast.Module) and POINTS_BACK.match(text))
    ]
    faults += [
        f"{name}: {line.strip()!r}: an argument is described by its noun"
        for name, text in files(folder)
        for line in text.splitlines()
        if ITSELF.match(line)
    ]
    assert faults == []


@pytest.mark.parametrize("folder", OURS)
def test_every_files_public_names_are_a_tuple_of_what_it_has(folder: str) -> None:
    faults = list[str]()
    for name, text in files(folder):
        offered = offers(text)
        if len(offered) != 1:
            faults.append(f"{name}: name what is public in `__all__`")
        elif not isinstance(offered[0], ast.Tuple):
            faults.append(f"{name}: `__all__` is a tuple")
    assert faults == []


PASSED_ON = {
    "rai_missions/agents/mission.py": "a program that runs missions imports from here",
    "rai_missions/engine/activities/factory.py": "its import registers the machines",
    "rai_missions/conversation/language/language.py": "what a sentence is read and spoken by is one import",
    "rai_missions/prove/exploration/explorer.py": "what it explores is a graph of these",
}
"""A module that offers names of others → why."""


def passed_on(text: str) -> set[str]:
    """The public names of a module that it imports from another of ours."""
    imported = {
        alias.asname or alias.name
        for node in parsed(text).body
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in OURS
        for alias in node.names
    }
    return imported & {ast.literal_eval(each) for each in offers(text)[0].elts}  # type: ignore[union-attr]


def test_a_name_is_imported_from_where_it_is_made() -> None:
    """A package offers names of its modules; what else passes names on gives them a second home."""
    found = {
        name for folder in OURS for name, text in files(folder) if not name.endswith("__init__.py") and passed_on(text)
    }
    assert found == PASSED_ON.keys()


def functions_and_constants(text: str) -> set[str]:
    """What a module makes of its own; a class or an alias of a type is named by what has it."""
    found = {node.name for node in parsed(text).body if isinstance(node, ast.FunctionDef)}
    named = {node.id for node in nodes(parsed(text)) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    return found | {name for name in named if name.isupper()}


def test_what_a_module_offers_is_named_elsewhere() -> None:
    """A function or constant that its own file alone names is its own affair."""
    pages = [path.read_text(encoding="utf-8") for path in ROOT.glob("docs/**/*.md") if "decisions" not in path.parts]
    texts = [*pages, *(text for folder in (*FOLDERS, "scripts") for _, text in files(folder))]
    words = Counter(word for text in texts for word in set(re.findall(r"\w+", text)))
    found = {
        (name, each.value)
        for folder in OURS
        for name, text in files(folder)
        if not name.endswith("__init__.py") and "/commands/" not in name
        for each in offers(text)[0].elts  # type: ignore[union-attr]
        if words[each.value] < 2 and each.value in functions_and_constants(text)
    }
    assert found == set()


@pytest.mark.parametrize("folder", OURS)
def test_what_was_raised_is_put_in_words_in_one_place(folder: str) -> None:
    """`errors.raised_text` has the type and the text; the text of a stranger's exception may itself raise."""
    by_hand = re.compile(r"type\([^()]+\)\.__name__\}: \{")
    assert [name for name, text in files(folder) if by_hand.search(text)] == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_nothing_is_left_to_do(folder: str) -> None:
    assert [
        f"{name}:{number}: {comment}"
        for name, text in files(folder)
        for number, line in enumerate(text.splitlines(), start=1)
        if (comment := line.partition("#")[2].strip()).startswith(("TODO", "FIXME", "XXX", "HACK"))
    ] == []


def tables(text: str) -> set[int]:
    """The last lines of the statements that give a table of literals: where the formatter would spread words."""
    found = set[int]()
    for node in ast.walk(parsed(text)):
        value = getattr(node, "value", None) if isinstance(node, ast.Assign | ast.AnnAssign | ast.Return) else None
        if isinstance(value, ast.Call) and len(value.args) == 1 and not value.keywords:
            value = value.args[0]
        if isinstance(value, ast.Tuple | ast.List | ast.Set | ast.Dict) and all(
            isinstance(each, OF_TABLES) for each in ast.walk(value)
        ):
            found.add(getattr(node, "end_lineno", 0))
    return found


OF_TABLES = (ast.Constant, ast.Tuple, ast.List, ast.Set, ast.Dict, ast.UnaryOp, ast.unaryop, ast.expr_context)


@pytest.mark.parametrize("folder", [*OURS, "missions", "benchmarks", "scripts"])
def test_the_formatter_leaves_out_tables_of_literals_alone(folder: str) -> None:
    assert [
        f"{name}:{number}: let ruff format what is no table of literals"
        for name, text in files(folder)
        if "# fmt:" in text
        for number, line in enumerate(text.splitlines(), start=1)
        if "# fmt:" in line and number not in tables(text)
    ] == []


def test_there_are_files_to_look_at() -> None:
    assert all(any(files(folder)) for folder in FOLDERS)


# -- texts from outside are cut at one door ----------------------------------------------------------------------------

DOORS = {"rai_missions/redaction.py"}
OF_NO_TEXT_FROM_OUTSIDE = {
    "rai_missions/connectors/sound/": "samples of sound",
    "rai_missions/journal/verify.py": "a hash",
    "rai_missions/journal/reader.py": "a hash",
    "rai_missions/mission/python_file.py": "a hash",
    "rai_missions/check/": "the mission's own words, by its author",
    "rai_missions/mission/mission.py:Mission": "the mission's own words, by its author",
    "rai_missions/prove/": "the mission's own words, by its author",
    "rai_missions/cli/progress.py": "steps, which were redacted before they became steps",
    "rai_missions/recording/json_messages.py": "steps, which were redacted before they became steps",
    "visualize/": "steps, which were redacted before they became steps",
    "rai_missions/answerers/model/parse_reply.py:callable_name": "an option, by the mission's author",
}
PURE = ("rai_missions/mission/option_parameters.py", "rai_missions/keys.py", "rai_missions/states/",
        "rai_missions/engine/", "rai_missions/guards/", "rai_missions/planning/")  # fmt: skip
"""What a step depends on: these must not ask what is secret here and now, and so may use `clipped` alone."""


def exempted(name: str, tree: ast.Module) -> ast.Module:
    """Without the functions that are listed as cutting no text from outside."""
    body = [each for each in tree.body if f"{name}:{getattr(each, 'name', '')}" not in OF_NO_TEXT_FROM_OUTSIDE]
    return ast.Module(body, [])


def cuts(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Where a text may be cut: a precision of a format, a slice from the start, the first of its lines."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FormattedValue) and node.format_spec is not None:
            spec = "".join(str(getattr(part, "value", "{}")) for part in getattr(node.format_spec, "values", ()))
            if re.fullmatch(r".*\.[\d{}]+s?", spec):
                yield node.lineno, f"a format cuts: {spec}"
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and node.slice.lower is None:
            end = node.slice.upper
            is_count = isinstance(end, ast.Constant) and isinstance(end.value, int) and end.value > 20
            if is_count or (isinstance(end, ast.Name) and re.match(r"LONGEST|CUT|CHARACTERS|SHORT", end.id)):
                yield node.lineno, "a slice cuts"
        if isinstance(node, ast.Attribute) and node.attr in ("shorten",):
            yield node.lineno, "textwrap cuts"
        if (
            isinstance(node, ast.Subscript)
            and isinstance(node.slice, ast.Constant)
            and node.slice.value in (0, -1)
            and isinstance(node.value, ast.Call)
            and getattr(node.value.func, "attr", "") in ("splitlines", "split")
            and not node.value.args
        ):
            yield node.lineno, "one line is taken of several"


@pytest.mark.parametrize("folder", OURS)
def test_a_text_from_outside_is_cut_at_the_door_that_redacts_it(folder: str) -> None:
    faults = [
        f"{name}:{line}: {what}; use rai_missions.redaction"
        for name, text in files(folder)
        if name not in DOORS and not name.startswith(tuple(OF_NO_TEXT_FROM_OUTSIDE))
        for line, what in cuts(exempted(name, parsed(text)))
    ]
    assert faults == []


def test_what_a_step_depends_on_asks_for_no_secret() -> None:
    for name, text in files("rai_missions"):
        taken = [
            alias.name
            for node in nodes(parsed(text))
            if isinstance(node, ast.ImportFrom) and node.module == "rai_missions.redaction"
            for alias in node.names
        ]
        if name.startswith(PURE):
            assert set(taken) <= {"clipped", "shown"}, name
            assert text.count("shown(") == text.count("by=clipped") or "shown" not in taken, name
        elif not name.startswith("rai_missions/redaction.py"):
            assert "clipped" not in taken, name


# -- the rooms ---------------------------------------------------------------------------------------------------------

MOST_MODULES, MOST_PACKAGES = 9, 26


def rooms(home: Path) -> tuple[set[str], set[str]]:
    """The modules and the packages in a package; a folder of data only is neither, and its two doors are no rooms."""
    modules = {path.stem for path in home.glob("*.py")} - {"__init__", "__main__"}
    return modules, {path.name for path in home.iterdir() if any(path.rglob("*.py"))}


def test_the_root_has_few_rooms() -> None:
    modules, packages = rooms(ROOT / "rai_missions")
    assert len(modules) <= MOST_MODULES, sorted(modules)
    assert len(packages) <= MOST_PACKAGES, sorted(packages)


@cache  # a file is in each package around it
def taken_by(path: Path) -> frozenset[str]:
    """The packages of ours that a file imports."""
    return frozenset(
        part
        for node in nodes(parsed(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in OURS
        for part in (str(node.module).split(".")[:2] if "." in str(node.module) else [each.name for each in node.names])
    )


def undeclared(package: Path) -> set[str]:
    """The packages that a package imports and that its docstring does not name, itself not counted."""
    docstring = ast.get_docstring(parsed((package / "__init__.py").read_text(encoding="utf-8"))) or ""
    sentence = next((part for part in docstring.split("\n\n")[1:] if part.startswith("Imports ")), None)
    if sentence is None:
        return {"a paragraph that begins with 'Imports'"}
    packages = rooms(ROOT / "rai_missions")[1] | {"visualize"}
    taken = {part for path in package.rglob("*.py") for part in taken_by(path)}
    return (taken & packages) - set(re.findall(r"`(\w+)`", sentence)) - set(package.relative_to(ROOT).parts[:2])


def test_the_modules_that_a_package_names_are_there() -> None:
    root = {path.stem for path in (ROOT / "rai_missions").iterdir()} | {"visualize"}
    absent = {
        (str(package.relative_to(ROOT)), name)
        for folder in OURS
        for package in (path.parent for path in (ROOT / folder).rglob("__init__.py"))
        for name in re.findall(r"`([a-z]\w+)`", docstring_of((package / "__init__.py").read_text(encoding="utf-8")))
        if name not in root and not any(path.stem == name for path in package.rglob("*"))
    }
    assert absent == set()


def test_each_package_reports_what_is_inside_and_what_it_may_import() -> None:
    packages = [path.parent for folder in OURS for path in (ROOT / folder).rglob("__init__.py")]
    lacking = {
        str(path): missing for path in packages if path != ROOT / "rai_missions" if (missing := undeclared(path))
    }
    assert lacking == {}
