# SPDX-License-Identifier: Apache-2.0
"""A gate that is started again: what the operator had, only the operator gives back."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.local import LocalConnector
from rai_missions.gate import GateAgent, gate_words
from rai_missions.gate.memory import Memory, usual_path
from rai_missions.states.control import HOLDERS
from tests.rigs.files import largest_file


def begun(memory: Memory, *handed: tuple[str, str], safe: str = "autonomy", ends: bool = True) -> str:
    """Who holds control as a gate begins; then control is asked for, and the gate ends or is killed."""
    connector = LocalConnector()
    connector.start()
    gate = GateAgent(gate_words({"safe": safe, "leases": {"agent": 0}}), connector, memory=memory)
    gate.open()
    first = gate.gate.holder
    for to, by in handed:
        assert gate.ask(to, by)["success"]
    if ends:
        gate.close()
    return first


@pytest.mark.parametrize("ends", [True, False])
@pytest.mark.parametrize(
    ("handed", "first"),
    [
        ([("operator", "operator")], "nobody"),
        ([("nobody", "agent")], "nobody"),
        ([("operator", "operator"), ("autonomy", "operator")], "autonomy"),
        ([("agent", "agent")], "autonomy"),
        ([], "autonomy"),
    ],
)
def test_a_gate_begins_again_by_who_held_control_last(
    tmp_path: Path, handed: list[tuple[str, str]], first: str, ends: bool
) -> None:
    memory = Memory(tmp_path / "state" / "gate.json")
    assert begun(memory, *handed, ends=ends) == "autonomy"
    assert begun(Memory(memory.path)) == first
    assert begun(Memory(memory.path)) == first, "and again"


def test_a_holder_that_cannot_be_kept_is_logged(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "file").touch()
    Memory(tmp_path / "file" / "gate.json").note("operator")
    assert "will not know that operator holds control" in caplog.text


@given(st.binary(max_size=40))
def test_a_gate_that_does_not_know_its_last_holder_begins_with_no_one(
    tmp_path_factory: pytest.TempPathFactory, message: bytes
) -> None:
    path = tmp_path_factory.mktemp("gate") / "gate.json"
    path.write_bytes(message)
    assert Memory(path).first("autonomy") == "nobody"


def test_a_memory_that_is_a_pipe_holds_up_no_gate(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "gate.json")
    assert Memory(tmp_path / "gate.json").first("autonomy") == "nobody"


def test_a_memory_that_cannot_be_written_holds_up_no_handover(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert begun(Memory(tmp_path / "file" / "gate.json"), ("operator", "operator")) in ("autonomy", "nobody")


@pytest.mark.parametrize("stored", [None, *HOLDERS])
@pytest.mark.parametrize("holder", HOLDERS)
def test_on_a_full_disk_no_holder_from_before_counts(tmp_path: Path, stored: str | None, holder: str) -> None:
    memory = Memory(tmp_path / "gate.json")
    if stored is not None:
        memory.note(stored)
    with largest_file(0):
        memory.note(holder)
    assert Memory(memory.path).first("autonomy") == "nobody"
    assert [path.name for path in tmp_path.iterdir()] == ["gate.json"]
    memory.note("agent")
    assert memory.first("autonomy") == "autonomy", "once there is room"


def test_each_name_and_domain_has_a_file_of_its_own() -> None:
    state = {"XDG_STATE_HOME": "/s"}
    assert usual_path("/gate", None, state) == Path("/s/rai_missions/gate-gate-0.json")
    assert usual_path("/a/gate", 7, state) == Path("/s/rai_missions/gate-a.gate-7.json")
    assert usual_path("/gate", None, state | {"ROS_DOMAIN_ID": "3"}) == Path("/s/rai_missions/gate-gate-3.json")
