# SPDX-License-Identifier: Apache-2.0
"""`docs/architecture.md` is what the code is: its rooms, and the walks through them."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture
def walks(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """`scripts/walks.py`."""
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    import walks as module  # a script, not a module of ours

    monkeypatch.delitem(sys.modules, "walks")
    return module


def test_every_walk_leads_down_through_functions_that_are_there(walks: ModuleType) -> None:
    assert [fault for walk in walks.read_walks() for fault in walks.faults(walk)] == []


def test_the_page_is_what_the_code_makes_of_it(walks: ModuleType) -> None:
    written = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    made = walks.page(walks.read_walks(), walks.read_changes(), walks.read_doors())
    assert written == made, "run: python scripts/walks.py --write"


def test_a_file_of_a_change_that_is_not_there_is_a_fault(walks: ModuleType) -> None:
    assert list(walks.absent(walks.read_changes())) == []
    change = walks.Change("a guard", ("rai_missions/guards/near.py", "rai_missions/guards/far.py"), (), "")
    assert list(walks.absent((change,))) == ["to change a guard: there is no rai_missions/guards/far.py"]


def test_each_room_has_a_door_that_is_there(walks: ModuleType) -> None:
    doors = dict(walks.read_doors())
    assert list(walks.closed(doors)) == []
    doors |= {"gate": (), "prove": ("rai_missions.prove:proof",)}
    assert list(walks.closed(doors)) == [
        "the room gate has no door",
        "the door of prove: there is no rai_missions.prove:proof",
    ]


CHART, RUNNER = "rai_missions.engine.chart:Chart.send", "rai_missions.runtime.runner:Runner"
VALUE, SINK = "rai_missions.engine.semantics.short_way:short_step", "rai_missions.journal.buffer:JournalSink.write"


@pytest.mark.parametrize(
    ("stays", "fault"),
    [
        ([(RUNNER, False), ("rai_missions.engine.chart:Chart.sent", False)], "there is no rai_missions.engine.chart:"),
        (
            [(RUNNER, False), ("rai_missions.prove:no_such", False)],
            "there is no rai_missions.prove",
        ),
        ([(CHART, False), (RUNNER, False)], "rai_missions.engine.chart does not import rai_missions.runtime.runner"),
        ([(CHART, False), (RUNNER, False)], "does not name Runner"),
        ([(CHART, False), (RUNNER, False)], "may not know rai_missions.runtime.runner:Runner"),
        ([(RUNNER, False), ("visualize.build:picture", False)], "does not import visualize.build"),
        ([(VALUE, False), ("rai_missions.engine.semantics.stepping:close", False)], "does not name close"),
        ([(SINK, False), ("rai_missions.journal.codec:encode", True)], "does not import rai_missions.journal.buffer"),
        ([(SINK, False), ("rai_missions.journal.reader:Record", True)], "does not import rai_missions.journal.buffer"),
    ],
)
def test_what_is_not_so_in_the_code_is_a_fault(walks: ModuleType, stays: list[tuple[str, bool]], fault: str) -> None:
    walk = walks.Walk("a walk", "", tuple(walks.Stay(name, "", up=up) for name, up in stays))
    assert any(fault in each for each in walks.faults(walk))


@pytest.mark.parametrize(
    ("one", "other"),
    [(CHART, RUNNER), (SINK, "rai_missions.journal.writer:Journal.write")],
    ids=["its class is named", "its class has each method of a protocol"],
)
def test_a_callback_leads_up(walks: ModuleType, one: str, other: str) -> None:
    stays = (walks.Stay(one, ""), walks.Stay(other, "", up=True))
    assert list(walks.faults(walks.Walk("a walk", "", stays))) == []
