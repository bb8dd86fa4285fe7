# SPDX-License-Identifier: Apache-2.0
"""The layout that a reader relies on: tests lie where the code does, and a class name means one thing."""

from __future__ import annotations

import ast
import importlib
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.rigs.sources import nodes, parsed

ROOT = Path(__file__).parents[1]
OURS = ("rai_missions", "visualize")

ELSEWHERE = {
    "bad_missions": "missions with faults, each with its message",
    "benchmarks": "how benchmarks are run, and the page of what they measured",
    "browser": "pages in a real browser",
    "data": "recorded runs and examples that several tests read",
    "drills": "long runs of many parts",
    "desk": "the shipped missions `missions/desk`",
    "fuzz": "inputs by chance for everything that opens a file",
    "hostile": "the whole of a mission against a model that misbehaves",
    "interfaces": "the ROS packages in `interfaces/`",
    "laws": "what holds for every mission, whichever package does it",
    "mutants": "the list of parts that are broken on purpose",
    "oracles": "other engines that read the same charts",
    "plugins": "a package from outside that adds kinds",
    "providers": "a provider's package from outside, for processes of models",
    "readings": "ages of readings, from the profile over the run to the journal",
    "recorded": "stored runs, which every version repeats",
    "rigs": "what tests share",
    "ros": "the package for colcon in `ros/`",
    "rosbot": "the shipped mission `missions/rosbot`",
    "tutorial": "the steps of `docs/tutorial`",
    "security": "secrets and hostile files, in every package",
    "tractor": "the shipped mission `missions/tractor`",
    "typing": "what type checkers see of the public names",
}
"""A folder of `tests` that is no package → what it holds."""

INNER = {
    "answerers/model_process": "`answerers/model/process`, one level up: pytest's paths stay short",
    "gate/ros": "a gate on a ROS graph",
    "mission/examples": "the profile of the mission that the guides explain",
    "node/ros": "a node on a ROS graph",
    "visualize/stored": "pictures to compare with",
}
"""A folder in a package's tests that is no package → what it holds."""
ROS = frozenset({"action_msgs", "geometry_msgs", "nav2_msgs", "rclpy", "std_msgs", "std_srvs", "test_msgs"})
"""Packages that only a machine with ROS 2 has."""
IMPORTS_ROS = re.compile(rf"^(?:import|from) .*\b(?:{'|'.join(sorted(ROS))})\b", re.MULTILINE)
"""What only a file has that may import one at its top: the others are not parsed."""

SHARED_NAMES = {
    "Call": "`call` of the format: a state that calls a service, and an effect that does",
    "Goal": "of an action, in the ledger of the engine; and of a request, an arrangement of things",
    "Limits": "public in both packages: of one answer, and of one proof",
    "NavigateToPose": "the action of nav2_msgs, served by each world, and the arguments of the tool of that name",
    "Plan": "`plan` of the format: a state that orders moves; and the moves",
}  # fmt: skip
"""A class name that several modules have → why."""

PARTICIPLE = re.compile(
    r"(?:.*[a-df-z]ed|.*[a-z]ing|Built|Done|Found|Given|Held|Kept|Known|Made|Meant|Met|Read"
    r"|Seen|Sent|Shown|Taken)$"
)
NOUNS = frozenset(
    ("Crossing", "Drawing", "Finding", "Meaning", "Naming", "Ordering", "Pairing", "Reading", "Recording",
     "Sighting", "Spending", "Thing"),
)  # fmt: skip
"""Last words that only look like participles."""
WORDS_OF_THE_FORMAT = frozenset(
    ("Elapsed", "Grouped", "Held", "Named", "Read", "Shifted", "Swapped", "FailureIsRunning", "SuccessIsRunning"),
)  # fmt: skip
OTHERWISE = {
    "BudgetExceeded": "an exception, which states what has happened",
    "SkillStopped": "an exception, which states what has happened",
    "Stamped": "a value with its time, in the words of ROS (`geometry_msgs/PoseStamped`)",
}
"""A name that ends like a participle → why it does."""


def class_names() -> Iterator[tuple[str, str]]:
    """Each public class at the top of a module: its name, and the module's path."""
    for folder in OURS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            for node in parsed(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    yield node.name, str(path.relative_to(ROOT))


def test_a_class_name_means_one_thing() -> None:
    places = defaultdict(list)
    for name, path in class_names():
        places[name].append(path)
    assert {name: paths for name, paths in places.items() if len(paths) > 1 and name not in SHARED_NAMES} == {}


def test_a_class_is_named_by_a_noun() -> None:
    names = {
        node.name
        for folder in OURS
        for path in (ROOT / folder).rglob("*.py")
        for node in nodes(parsed(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
    }
    participles = {
        name
        for name in names
        if PARTICIPLE.match(last := re.findall(r"[A-Z][a-z]*|[a-z]+", name)[-1]) and last not in NOUNS
    }
    assert participles - WORDS_OF_THE_FORMAT == OTHERWISE.keys()


def test_no_reason_for_a_shared_name_is_left_over() -> None:
    names = [name for name, _ in class_names()]
    assert [name for name in SHARED_NAMES if names.count(name) < 2] == []


def test_tests_lie_where_the_packages_do() -> None:
    packages = {path.parent.name for path in (ROOT / "rai_missions").glob("*/__init__.py")} | {"visualize"}
    folders = {path.name for path in (ROOT / "tests").iterdir() if any(path.rglob("*.py"))}
    assert folders - ELSEWHERE.keys() == packages, "each package has a folder, and each folder a package or a reason"
    assert packages & ELSEWHERE.keys() == set()


def test_no_test_needs_ros_to_be_collected() -> None:
    """Without ROS 2 installed its tests are skipped; an import at the top would be an error instead."""
    tops = [
        f"{path.relative_to(ROOT)}: {node.lineno}"
        for path in sorted((ROOT / "tests").rglob("*.py"))
        if path.name.startswith(("test_", "conftest"))
        if IMPORTS_ROS.search(text := path.read_text(encoding="utf-8"))
        for node in parsed(text).body
        for name in imported(node)
        if name.partition(".")[0] in ROS
    ]
    assert tops == []


def imported(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.Import):
        return [each.name for each in node.names]
    return [node.module or ""] if isinstance(node, ast.ImportFrom) else []


def test_a_folder_inside_is_one_of_its_package() -> None:
    for folder in (ROOT / "tests").glob("*/*/"):
        name = str(folder.relative_to(ROOT / "tests"))
        if not any(folder.rglob("*.py")) or folder.parent.name in ELSEWHERE or name in INNER:
            continue
        assert (ROOT / name if name.startswith("visualize") else ROOT / "rai_missions" / name).is_dir(), name


@pytest.mark.parametrize("builder", ["sdist", "wheel"])
def test_a_distribution_has_every_file_of_both_packages(builder: str) -> None:
    """A folder that a link in `ros/` leads to is walked once, under the name that comes first."""
    pytest.importorskip("hatchling", reason="hatchling comes with the extra `dev`")
    module = importlib.import_module(f"hatchling.builders.{builder}")
    made = getattr(module, f"{builder.title()}Builder")(str(ROOT))
    packed = {each.distribution_path for each in made.recurse_included_files()}
    ours = {path.relative_to(ROOT).as_posix() for package in OURS for path in (ROOT / package).rglob("*.*")}
    sources = {path for path in ours if not path.endswith((".pyc", ".so")) and (ROOT / path).is_file()}
    assert len(sources) > 500 and sources - packed == set()
