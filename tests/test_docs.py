# SPDX-License-Identifier: Apache-2.0
"""What the documents show is run: their Python, and their `rai-missions` commands.

The blocks of one document run in the order written, in a folder that holds a copy of `missions/`; the Python blocks
share their names. Those of a step of the tutorial run in a copy of its folder. In a `console` or `sh` block, each line
`$ rai-missions …` is run and must exit with 0, or with what a comment at its end reports: `# exits 2`. A block under
`<!-- not run: why -->` is left alone.
"""

from __future__ import annotations

import ast
import io
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from packaging.requirements import Requirement

from rai_missions.cli.main import main

ROOT = Path(__file__).parents[1]
DOCUMENTS = [
    ROOT / "README.md",
    *sorted(ROOT.glob("docs/guide/**/*.md")),
    *sorted(ROOT.glob("docs/coming-from/*.md")),
    *sorted(ROOT.glob("docs/tutorial/**/*.md")),
    *sorted(ROOT.glob("missions/*/README.md")),
]
AS_PROCESSES = {
    ROOT / each
    for each in ("docs/guide/difference.md", "docs/tutorial/1_mission/README.md", "missions/rosbot/README.md")
}
"""Their commands run as processes of their own, as a reader's do; those of the others in this one, which is faster."""
LONG = {
    *(
        f"docs/guide/{each}.md"
        for each in ("identity", "journal", "profiles", "proofs", "recording", "review", "watching")
    ),
    "missions/rosbot/README.md",
}
OF_DEVELOPERS = {
    "audit", "bench", "browser", "dev", "docs", "fuzz", "learn", "mutate", "ros-test", "urdf-test",
}  # fmt: skip
"""Extras that no user installs."""
Run = Callable[[list[str]], tuple[int | str | None, str]]
BLOCK = re.compile(
    r"^(?P<skip><!-- not run: [^\n]+ -->\n+)?```(?P<kind>\w+)[^\n]*\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE
)
COMMAND = re.compile(r"^\$ (rai-missions (?:[^\n]*\\\n)*[^\n]*)", re.MULTILINE)
EXITS = re.compile(r"#\s*exits (\d+)")


class Block(NamedTuple):
    kind: str
    text: str
    line: int
    """Of the document: the one on which the text begins."""


def blocks(document: str) -> Iterator[Block]:
    for found in BLOCK.finditer(document):
        if not found["skip"]:
            yield Block(found["kind"], found["text"], document.count("\n", 0, found.start("text")) + 1)


def run_python(block: Block, where: str, names: dict[str, Any]) -> None:
    """Run a block so that a traceback names the document's own line."""
    exec(compile("\n" * (block.line - 1) + block.text, where, "exec", dont_inherit=True), names)


def run_as_process(arguments: list[str]) -> tuple[int | str | None, str]:
    """Run the installed script; its exit status, and what it printed."""
    script = Path(sys.executable).with_name("rai-missions")
    ran = subprocess.run(
        [script, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=150, check=False
    )
    return ran.returncode, ran.stdout + ran.stderr


def run_here(arguments: list[str]) -> tuple[int | str | None, str]:
    """Run what the script calls in this process, which has loaded the package; its exit status, what it printed."""
    raw = io.BytesIO()
    printed = io.TextIOWrapper(raw, encoding="utf-8", write_through=True)
    with open(os.devnull, encoding="utf-8") as nothing, pytest.MonkeyPatch.context() as patch:
        for name, stream in (("stdin", nothing), ("stdout", printed), ("stderr", printed)):
            patch.setattr(sys, name, stream)
        patch.setattr(sys, "argv", ["rai-missions", *arguments])
        try:
            status: int | str | None = main(arguments)
        except SystemExit as left:
            status = left.code or 0
    return status, raw.getvalue().decode()


def run_commands(block: Block, where: str, run: Run) -> None:
    for command in COMMAND.findall(block.text):
        expected = int(found[1]) if (found := EXITS.search(command)) else 0
        _, *arguments = shlex.split(command.replace("\\\n", " "), comments=True)
        status, printed = run(arguments)
        assert status == expected, f"{where}:{block.line}: {command}\nexited {status}, not {expected}\n{printed}"


def documents() -> Iterator[Any]:
    """Each with its name, and those that take seconds for the longer suite."""
    for document in DOCUMENTS:
        name = str(document.relative_to(ROOT))
        yield pytest.param(document, id=name, marks=[pytest.mark.long] if name in LONG else [])


@pytest.mark.parametrize("document", list(documents()))
def test_what_a_document_shows_runs(document: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(ROOT / "missions", tmp_path / "missions")
    monkeypatch.chdir(tmp_path)
    if "docs/tutorial" in document.as_posix():  # a step is run in its folder
        shutil.copytree(ROOT / "docs/tutorial", tmp_path / "tutorial")
        monkeypatch.chdir(tmp_path / document.parent.relative_to(ROOT / "docs"))
    names: dict[str, Any] = {"__name__": "document"}
    run = run_as_process if document in AS_PROCESSES else run_here
    for block in blocks(document.read_text(encoding="utf-8")):
        if block.kind == "python":
            run_python(block, str(document), names)
        elif block.kind in ("console", "sh"):
            run_commands(block, str(document), run)


def test_blocks_are_found_with_their_lines_and_a_reasoned_exception() -> None:
    document = (
        "# A\n\n```python\nx = 1\n```\n\n<!-- not run: needs a robot -->\n```python\nx = 2\n```\n```sh\n$ ls\n```\n"
        "<!-- not run: needs a robot -->\n```sh\n$ cd\n```\n"
    )
    assert list(blocks(document)) == [Block("python", "x = 1\n", 4), Block("sh", "$ ls\n", 12)]


def test_only_our_own_commands_are_run() -> None:
    text = (
        "$ make run\n$ rai-missions draw a.json \\\n    -o b.svg\nwrote b.svg\n$ rai-missions check c.json  # exits 2\n"
    )
    assert COMMAND.findall(text) == [
        "rai-missions draw a.json \\\n    -o b.svg",
        "rai-missions check c.json  # exits 2",
    ]


def test_a_command_that_exits_otherwise_is_noticed() -> None:
    refused = "$ rai-missions check none.json"
    assert set(DOCUMENTS) >= AS_PROCESSES
    run_commands(Block("sh", f"{refused}  # exits 2\n", 1), "here.md", run_here)
    with pytest.raises(AssertionError, match=r"(?s)here\.md:7: .* none\.json\n.*2, not 0\n.*none\.json"):
        run_commands(Block("sh", f"{refused}\n", 7), "here.md", run_here)
    with pytest.raises(AssertionError, match="exited 2, not 1"):  # what the parser itself refuses
        run_commands(Block("sh", "$ rai-missions check --none  # exits 1\n", 7), "here.md", run_here)


def test_each_package_that_a_user_installs_has_its_licence_named() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = {name: wanted for name, wanted in project["optional-dependencies"].items() if name not in OF_DEVELOPERS}
    wanted = {Requirement(each).name for each in chain(project["dependencies"], *extras.values())} - {project["name"]}
    locks = (ROOT / "requirements" / f"{name}.lock" for name in ("voice", "voice-base", "weights"))
    wanted |= {name for lock in locks for name in re.findall(r"^([\w.-]+)==", lock.read_text(encoding="utf-8"), re.M)}
    rows = re.findall(r"^\|.*\|$", (ROOT / "docs/licences.md").read_text(encoding="utf-8"), re.M)
    named = set(re.findall(r"`([\w.-]+)`", "\n".join(rows)))
    assert sorted(wanted - named) == []


def test_links_between_documents_lead_somewhere() -> None:
    for document in [*DOCUMENTS, *sorted(ROOT.glob("docs/**/*.md")), ROOT / "CHANGELOG.md"]:
        for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8")):
            assert (document.parent / target).exists(), f"{document.relative_to(ROOT)} links to {target}"


def anchors(document: str) -> set[str]:
    """What GitHub makes of a document's headings."""
    headings = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```$", "", document, flags=re.DOTALL | re.MULTILINE), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_anchors_of_links_are_headings() -> None:
    for document in [*DOCUMENTS, *sorted(ROOT.glob("docs/**/*.md")), ROOT / "CHANGELOG.md"]:
        text = document.read_text(encoding="utf-8")
        for target, anchor in re.findall(r"\]\(([^)#:\s]*)#([^)]*)\)", text):
            page = (document.parent / target).read_text(encoding="utf-8") if target else text
            assert anchor in anchors(page), f"{document.relative_to(ROOT)} links to {target}#{anchor}"


@cache
def public_names(module: str) -> frozenset[str]:
    """What a module of ours offers, methods as `Class.method`; nothing is imported. Empty where there is no module."""
    file = ROOT / module.replace(".", "/")
    path = next((each for each in (file / "__init__.py", file.with_suffix(".py")) if each.is_file()), None)
    body = ast.parse(path.read_text(encoding="utf-8")).body if path is not None else []
    offered = next(
        (n.value for n in body if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == "__all__"), None
    )
    names = set(ast.literal_eval(offered)) if offered is not None else set()
    for owner in (node for node in body if isinstance(node, ast.ClassDef) and node.name in names):
        names |= {f"{owner.name}.{each.name}" for each in owner.body if isinstance(each, ast.FunctionDef)}
    return frozenset({"", *names}) if path is not None else frozenset()


def is_offered(name: str) -> bool:
    """Whether there is a public module, class, method or function of that name; `rai_missions.` may be left out."""
    full = name if name.startswith(("rai_missions", "visualize")) else f"rai_missions.{name}"
    steps = full.split(".")
    return any(".".join(steps[at:]) in public_names(".".join(steps[:at])) for at in range(1, len(steps) + 1))


def test_what_the_changelog_moved_is_there() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    moved = re.findall(r"^\| `([\w.]+)` \| `([\w.]+)`[^|]* \|$", text, re.M)
    assert len(moved) > 500
    assert [f"CHANGELOG.md names {new}" for _, new in moved if not is_offered(new)] == []
    assert [f"{old} is as it was" for old, new in moved if old == new] == []


@pytest.mark.parametrize(
    ("name", "there"),
    [
        ("rai_missions.engine.chart", True),
        ("engine.chart.Chart.propose", True),
        ("visualize.live.PageAddress", True),
        ("rai_missions.chart", False),
        ("engine.chart.Core", False),
        ("engine.chart.Chart.flee", False),
    ],
)
def test_a_name_that_is_not_there_is_noticed(name: str, there: bool) -> None:
    assert is_offered(name) == there


def test_prose_is_measured_as_its_definition_reads() -> None:
    measure = runpy.run_path(str(ROOT / "scripts/prose.py"))["measure"]
    page = "# Not a sentence\n\nIt does not `rain or` pour. [Never mind](x.md#no), it can't.\n\n- Four words are here\n"
    table = "\n| short cell | this cell is a whole sentence |\n|---|---|\n\n```\nno no no\n```\n"
    found = measure(page + table + "x" * 121)
    assert (found.sentences, found.sentence_words) == (5, 5 + 4 + 4 + 6 + 1)
    assert found.negations == 4, "the heading's and each sentence's; those of code are left out"
    assert found.long_lines == (len((page + table).splitlines()) + 1,)


def test_a_decision_has_a_noun_as_title() -> None:
    verbs = re.compile(r"\b(what|is|are|was|has|have|does|do|can|may|must|matters?)\b", re.IGNORECASE)
    titles = {
        path.name: path.read_text(encoding="utf-8").partition("\n")[0]
        for path in (ROOT / "docs/decisions").glob("[0-9]*.md")
    }
    assert [title for name, title in titles.items() if not title.startswith(f"# {name[:4]} ")] == []
    assert [title for title in titles.values() if verbs.search(title)] == []


def test_a_decision_has_a_line_in_the_list_of_its_folder() -> None:
    folder = ROOT / "docs/decisions"
    listed = re.findall(
        r"^- \[(\d{4})\]\((\1-[^)]+)\): \S", (folder / "README.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert sorted(name for _, name in listed) == sorted(path.name for path in folder.glob("[0-9]*.md"))


def test_nothing_installs_this_package_by_a_name_on_an_index() -> None:
    files = [*ROOT.glob("rai_missions/**/*.py"), *ROOT.glob("visualize/**/*.py"), *ROOT.glob("docs/**/*.md")]
    for file in [*files, *DOCUMENTS]:
        found = re.search(r"pip install [\"']?rai[-_]missions(?!\[\w+\] @ git)", file.read_text(encoding="utf-8"))
        assert found is None, f"{file.relative_to(ROOT)}: {found and found[0]}"


def test_each_comparison_shows_the_same_mission() -> None:
    pages = [path.read_text(encoding="utf-8") for path in ROOT.glob("docs/coming-from/*.md")]
    ours = {page.partition("## Here")[2].partition("## Words")[0] for page in pages}
    assert len(pages) == 6 and len(ours) == 1
