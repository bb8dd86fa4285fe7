# SPDX-License-Identifier: Apache-2.0
"""The frozen values that a picture is made of: what is drawn, before it is known how.

Rule: nothing here knows a format; every writer (DOT, Mermaid, table) reads these values and nothing else.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

__all__ = ("Choice", "Initial", "Mark", "Path", "Picture", "PictureEdge", "PictureNode", "Twig")

Mark = Literal["", "+", "-", "~"]
"""In a picture of two missions: in both, only in the new one, only in the old one, or changed."""


class Path(NamedTuple):
    """How a run went through something: the numbers of the steps that did, in order, one for each time."""

    steps: tuple[int, ...] = ()

    @property
    def times(self) -> int:
        return len(self.steps)

    def words(self) -> str:
        """`3× in steps 2, 5, 9`; empty where the run never went."""
        if not self.steps:
            return ""
        shown = ", ".join(str(number) for number in self.steps[:4]) + (", …" if len(self.steps) > 4 else "")
        return f"{self.times}× in step{'s' if self.times > 1 else ''} {shown}"


class Choice(NamedTuple):
    """An option of a decision."""

    name: str
    place: str
    about: str = ""
    guard: str = ""
    """In words; empty for an option that is always open."""
    parameters: tuple[str, ...] = ()
    """The names of what an answer brings along."""
    fallback: bool = False
    mark: Mark = ""


class Twig(NamedTuple):
    """A node of a behaviour tree."""

    path: str
    """From the root of the tree: `sequence/0`; the root's own is empty."""
    parent: str | None
    """The path of the node above it; None for the root."""
    kind: str
    """Its word: `sequence`, `retry`, `call`."""
    text: str
    """What it does, in words."""
    branch: str = ""
    """The option of a decision that leads here, where one does."""
    choices: tuple[Choice, ...] = ()
    number: int = 0
    """Its place among its siblings, from 1, where they are tried or run in that order; 0 for an only child, and below a
    decision, whose options are no order."""
    mark: Mark = ""

    def numbered(self, sign: str = "") -> str:
        """The node's number, if it has one, and what it does: `2. → sequence` with a sign."""
        return f"{self.number}. {sign}{self.text}" if self.number else f"{sign}{self.text}"

    @property
    def leaf(self) -> bool:
        """Whether the node does something itself; the others arrange."""
        return self.kind in ("action", "call", "check", "wait_s", "set", "publish", "decision")


class PictureNode(NamedTuple):
    """A state."""

    name: str
    place: str
    """JSON pointer."""
    kind: str
    """The word of the format: `states`, `parallel`, `each`, `action`, `call`, `decision`, `tree`, `mission`, `history`,
    `final`; empty for a state that only waits."""
    parent: str = ""
    """The state around it; empty at the top."""
    region: bool = False
    """One of a parallel state's regions."""
    title: str = ""
    """What it runs: `action drive_alleys`."""
    lines: tuple[str, ...] = ()
    """What else a reviewer must know: goal, timeout, what counts as achieved, entry and exit effects."""
    about: str = ""
    control: str = ""
    outcome: str = ""
    """A final's outcome; a history's depth."""
    choices: tuple[Choice, ...] = ()
    fallback: str = ""
    twigs: tuple[Twig, ...] = ()
    """The nodes of its tree, outer before inner."""
    entered: Path = Path()
    ended_here: bool = False
    """It was active, with nothing active inside, after the last step."""
    mark: Mark = ""
    was: str = ""
    """Its old name, where two missions call it differently."""


class PictureEdge(NamedTuple):
    """A transition, to one of its targets."""

    place: str
    """JSON pointer of the transition."""
    source: str
    """The state whose transition it is; empty for the mission's own, which are tried from everywhere."""
    target: str
    """Empty for a transition that does not leave its state."""
    trigger: str
    """`anomaly or halt`, `after 5 s`; empty for a transition that fires as soon as its guard holds."""
    guard: str = ""
    do: tuple[str, ...] = ()
    internal: bool = False
    about: str = ""
    option: str = ""
    """The option of the source's decision that fires it, where one alone does."""
    taken: Path = Path()
    mark: Mark = ""

    @property
    def when(self) -> str:
        """The trigger as a reader wants it: never empty."""
        return self.trigger or "as soon as"


class Initial(NamedTuple):
    """Where a compound state, or the mission (`parent` empty), begins."""

    parent: str
    target: str
    taken: Path = Path()


@dataclass(frozen=True)
class Picture:
    """A mission as it is drawn, with the path that a run took."""

    name: str
    version: str
    about: str
    nodes: tuple[PictureNode, ...]
    """In document order, outer before inner."""
    edges: tuple[PictureEdge, ...]
    """A transition once for each of its targets, or once without any; in document order, the mission's own last."""
    initials: tuple[Initial, ...]
    invariants: tuple[tuple[str, str], ...] = ()
    """Name and guard in words."""
    steps: int = 0
    """How many steps its path was made of; 0 for a picture without a run."""
    outcome: str = ""
    why: str = ""
    compared: str = ""
    """The version of the mission that this one is compared with."""
    notes: tuple[str, ...] = ()
    """What a reader must not miss, above the picture."""

    @cached_property
    def by_name(self) -> Mapping[str, PictureNode]:
        """The nodes by their names."""
        return {node.name: node for node in self.nodes}

    @cached_property
    def children(self) -> Mapping[str, list[PictureNode]]:
        """State → those directly inside it; the mission's are under the empty name."""
        found = defaultdict(list)
        for node in self.nodes:
            found[node.parent].append(node)
        return found

    @cached_property
    def begins(self) -> Mapping[str, list[Initial]]:
        """State → where it begins; the mission is under the empty name."""
        found = defaultdict(list)
        for initial in self.initials:
            found[initial.parent].append(initial)
        return found

    def within(self, name: str, outer: str) -> bool:
        """Whether a state is another, or is inside it."""
        while name and name != outer:
            name = self.by_name[name].parent if name in self.by_name else ""
        return bool(name)

    @property
    def title(self) -> str:
        """The mission's name and version; of two missions, both versions."""
        return f"{self.name} {f'{self.compared} → ' if self.compared else ''}{self.version}"

    @property
    def ended(self) -> str:
        """How the run ended; empty where it has not, and for a picture without one."""
        return ", ".join(filter(None, (self.outcome, self.why)))
