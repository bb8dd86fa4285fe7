# SPDX-License-Identifier: Apache-2.0
"""An exploration ends: after a refutation, out of time, out of memory; and reports what it has covered."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Space

Json = dict[str, Any]


def counting(**invariants: Any) -> Json:
    """A counter that goes up and down without end: it has no end of states."""
    return {
        "format": 1, "name": "counting", "initial": "here", "blackboard": {"n": {"type": "integer", "initial": 0}},
        "events": {"up": {}, "down": {}, "stop": {}}, "invariants": invariants,
        "states": {
            "here": {"transitions": [{"on": "up", "do": [{"set": "n", "add": 1}]},
                                     {"on": "down", "do": [{"set": "n", "add": -1}]}, {"on": "stop", "to": "over"}]},
            "over": {"final": "aborted"},
        },
        "transitions": [{"on": "stop", "when": {"key": "n", "==": 7}, "to": "over"}],
    }  # fmt: skip


@pytest.mark.parametrize("word", ["most", "seconds", "memory_mb", "work"])
@pytest.mark.parametrize("limit", [0, -1, "x", float("nan"), None])
def test_a_limit_that_leaves_nothing_to_explore_is_refused(word: str, limit: Any) -> None:
    words: dict[str, Any] = {word: limit}
    with pytest.raises(UsageError, match=f"{word}=.* leaves nothing to explore; give a number above 0"):
        prove(Mission.model_validate(counting()), **words)


def test_a_refutation_ends_the_search_for_more_of_its_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rai_missions.prove.limits.STATES_AFTER", 1000)
    proof = prove(Mission.model_validate(counting(positive={"key": "n", ">=": 0})))
    assert [scene.words for scene in proof.ways["invariants"]] == ["the mission starts", "event 'down'"]
    assert (proof.stopped, proof.verdict) == ("refuted", "refuted") and proof.states < 3_000
    assert {each.name: each.verdict for each in proof.claims}["ends"] == "explored"


def test_a_refutation_leaves_the_limits_as_they_are_where_that_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rai_missions.prove.limits.STATES_AFTER", 1000)
    proof = prove(Mission.model_validate(counting(positive={"key": "n", ">=": 0})), most=1_500, continues=True)
    assert (proof.stopped, proof.states) == ("states", 1_500)


@pytest.mark.parametrize(
    ("limit", "stopped"), [({"seconds": 0.05}, "seconds"), ({"memory_mb": 1}, "memory"), ({"most": 50}, "states")]
)
def test_a_limit_ends_an_exploration(limit: Any, stopped: str) -> None:
    proof = prove(Mission.model_validate(counting()), **limit)
    assert (proof.stopped, proof.verdict, proof.is_whole) == (stopped, "explored", False)
    assert 0 < proof.done < proof.states and not any(claim.verdict == "proved" for claim in proof.claims)


@pytest.mark.parametrize(("given", "reason"), [
    (["--max-seconds", "0.05"], "out of time"), (["--max-memory", "1"], "out of memory"),
    (["--states", "50"], "as many states as were allowed"),
])  # fmt: skip
def test_the_command_reports_its_limit_and_what_is_open(
    given: list[str], reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "counting.json").write_text(json.dumps(counting()), encoding="utf-8")
    assert main(["prove", str(tmp_path / "counting.json"), *given]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert reason in lines[0] and "were explored with all that can happen in them" in lines[1]
    assert lines[2:4] == ["refuted: none", "proved: none"] and lines[4].startswith("open: ends, comes to rest")


def test_a_limit_names_the_keys_that_multiply_and_what_would_help(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "counting.json").write_text(json.dumps(counting()), encoding="utf-8")
    assert main(["prove", str(tmp_path / "counting.json"), "--states", "50"]) == 1
    lines = capsys.readouterr().out.splitlines()
    (most,) = [line for line in lines if line.startswith("what multiplies most: ")]
    assert most == "what multiplies most: n: 50 values" and lines[lines.index(most) + 1].startswith("fewer: ")


@pytest.mark.parametrize("given", [["--max-seconds", "0"], ["--max-memory", "-1"], ["--states", "0"]])
def test_a_limit_of_nothing_is_refused(given: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "counting.json").write_text(json.dumps(counting()), encoding="utf-8")
    assert main(["prove", str(tmp_path / "counting.json"), *given]) == 2
    assert f"give {given[0]} a number above 0" in capsys.readouterr().err


def test_a_step_is_made_once_for_values_that_no_guard_distinguishes() -> None:
    """The counter has 31 values, of which the guards of the other steps distinguish three."""
    more: Json = {"on": "up", "when": {"key": "n", "<": 30}, "do": [{"set": "n", "add": 1}]}
    looks = [{"on": f"look{number}", "when": {"key": "n", ">=": 2}, "to": "there"} for number in range(10)]
    space = Space(
        Environment(
            Mission.model_validate(
                {
                    "format": 1,
                    "name": "counted",
                    "initial": "here",
                    "blackboard": {"n": {"type": "integer", "initial": 0}},
                    "events": {"up": {}, "stop": {}, **{f"look{number}": {} for number in range(10)}},
                    "states": {
                        "here": {"transitions": [more, *looks]},
                        "over": {"final": "aborted"},
                        "there": {"transitions": [{**each, "to": "here"} for each in looks]},
                    },
                    "transitions": [{"on": "stop", "to": "over"}],
                }
            )
        )
    )
    space.explore()
    assert space.is_whole and space.meter.work - space.steps < 100
