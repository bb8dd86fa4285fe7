# SPDX-License-Identifier: Apache-2.0
"""What a person reports about a gate, and what is reported back where it is wrong."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.gate import CommandTopic, GateWords, gate_words, read_gate
from rai_missions.gate.config import command_topic, leases_of


def test_a_gate_of_which_nothing_is_reported_guards_a_twist_and_gives_the_agent_a_lease() -> None:
    words = gate_words({})
    assert words == GateWords()
    assert [(each.topic, each.stop_message) for each in words.commands] == [("/cmd_vel", {})]
    assert words.rules.leases == {"agent": 0.5} and words.rules.safe == "autonomy"


def test_only_a_velocity_is_stopped_by_zeros_unless_the_file_states_it() -> None:
    arm = "trajectory_msgs/msg/JointTrajectory"
    assert CommandTopic("/arm", arm).stop_message is None
    assert CommandTopic("/arm", arm, stop={}).stop_message == {}


def test_a_lease_of_zero_is_none() -> None:
    assert gate_words({"leases": {"agent": 0.0, "operator": 2.0}}).rules.leases == {"operator": 2.0}


def test_the_shortest_lease_is_one() -> None:
    assert gate_words({"leases": {"agent": 0.01}}).rules.leases == {"agent": 0.01}


@pytest.mark.parametrize(
    ("data", "why"),
    [
        ({"leases": {"agnet": 1.0}}, "/leases/agnet: no one called 'agnet' commands actuators; did you mean 'agent'?"),
        (
            {"leases": {f"agent_{number}": 1.0 for number in range(30)}},
            "/leases/agent_0: no one called 'agent_0' commands actuators; did you mean 'agent'?",
        ),
        (
            {"leases": {"agent": 0.001}},
            "/leases/agent: 0.001 s for 'agent' is shorter than a message's way; give 0.01 or more",
        ),
        ({"commands": []}, "a gate without command topics guards nothing; give at least one"),
        ({"commands": [{"topic": "/a", "type": "x"}] * 2}, "'/a' is here twice; drop one"),
        ({"commands": [{"topic": "/a", "type": "x", "stop": 3}]}, "3 is no message; give its fields, or {} for zeros"),
        (
            {"commands": [{"topic": "cmd_vel", "type": "x"}]},
            "/commands/0/topic: 'cmd_vel' is no topic's name from the root on; write it like '/cmd_vel'",
        ),
        ({"name": "my gate"}, "/name: 'my gate' is no topic's name from the root on; write it like '/robot/cmd_vel'"),
        ({"safe": "operator"}, "/safe: no such choice: 'operator'"),
        ({"saef": "nobody"}, "/saef"),
    ],
)
def test_what_is_wrong_is_reported_with_its_place_and_its_remedy(data: dict[str, Any], why: str) -> None:
    with pytest.raises(DefinitionError) as reported:
        gate_words(data)
    assert why in str(reported.value)


def test_words_given_here_count_instead_of_the_file_s(tmp_path: Path) -> None:
    file = tmp_path / "gate.json"
    file.write_text(json.dumps({"name": "/guard", "safe": "nobody"}))
    assert read_gate(file, safe="autonomy") == gate_words({"name": "/guard"})
    file.write_text("[]")
    with pytest.raises(DefinitionError, match="a gate is a JSON object, not"):
        read_gate(file)


def test_a_gate_reads_as_it_is_written() -> None:
    words = gate_words({"commands": [{"topic": "/a", "type": "x", "stop": {"b": 1}}], "leases": {"operator": 2.0}})
    assert gate_words(words.written()) == words


@pytest.mark.parametrize("text", ["", "/cmd_vel", "=x", "/cmd_vel="])
def test_a_command_topic_has_a_type(text: str) -> None:
    with pytest.raises(UsageError, match="write TOPIC=TYPE"):
        command_topic(text)


def test_a_lease_has_seconds() -> None:
    assert leases_of(["agent=0.5", "operator=2"]) == {"agent": 0.5, "operator": 2.0}
    with pytest.raises(UsageError, match="write HOLDER=SECONDS"):
        leases_of(["agent"])


@pytest.mark.parametrize("words", [["--command", "cmd_vel"], ["--lease", "bob=1"], ["--file", "nowhere.json"]])
def test_a_gate_that_is_wrong_on_the_command_line_exits_with_2(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["gate", *words]) == 2
    assert capsys.readouterr().err
