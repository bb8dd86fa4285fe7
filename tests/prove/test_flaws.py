# SPDX-License-Identifier: Apache-2.0
"""Small missions with a fault each, as a stranger may write them: each is refuted by its shortest run, and replayed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main

Json = dict[str, Any]
KEYS: Json = {
    "battery": {"type": "number", "source": "robot", "max_age_s": 5},
    "at_home": {"type": "boolean", "source": "robot", "max_age_s": 5},
    "tries": {"type": "integer", "initial": 0},
}
ENDS = ["failed", "timed_out", "rejected", "unverified"]
DRIVING: Json = {
    "action": "drive", "timeout_s": 60, "achieved": {"key": "at_home", "==": True},
    "transitions": [{"on": "succeeded", "to": "done"},
                    {"on": ENDS, "to": "aborted"}],
}  # fmt: skip
DONE: Json = {"final": "succeeded", "requires": {"key": "at_home", "==": True}}
ABORTED: Json = {"final": "aborted"}


def asking(options: Json, transitions: list[Json], **words: Any) -> Json:
    asked = {"question": "What now?", "options": options, "ask": ["agent"], "deadline_s": 10, **words}
    return {"decision": asked, "transitions": transitions}


def mission(states: Json, **words: Any) -> Json:
    reported = json.dumps([states, words])
    keys = {name: key for name, key in KEYS.items() if f'"{name}' in reported}
    return {
        "format": 1, "name": "flawed", "version": "1.0.0", "blackboard": keys, "initial": next(iter(states)),
        "states": states, **words,
    }  # fmt: skip


DEADLOCK = mission({
    "driving": {**DRIVING, "transitions": [{"on": "succeeded", "to": "done"}, {"on": ENDS, "to": "stuck"}]},
    "stuck": {"about": "waits for what never is", "transitions": [{"when": {"key": "tries", ">": 0}, "to": "aborted"}]},
    "done": DONE, "aborted": ABORTED,
})  # fmt: skip
LIVELOCK = mission(
    {
        "here": {"transitions": [{"after_s": 5, "to": "there"}]},
        "there": {"transitions": [{"after_s": 5, "to": "here"}]},
        "aborted": ABORTED,
    },
    events={"stop": {}},
    transitions=[{"on": "stop", "to": "aborted"}],
)
INVARIANT = mission(
    {"driving": DRIVING, "done": DONE, "aborted": ABORTED},
    invariants={"charged": {"not": {"all": [{"in": "driving"}, {"key": "battery", "<": 0.1}]}}},
)


def choosing(when: Json) -> Json:
    return mission({
        "choosing": {**asking(
            {"drive": {"about": "drive", "when": when}, "stop": {"about": "stop"}},
            [{"on": "drive", "to": "driving"}, {"on": "stop", "to": "aborted"}], fallback="stop",
        ), "entry": [{"set": "tries", "add": 1}]},
        "driving": DRIVING, "done": DONE, "aborted": ABORTED,
    })  # fmt: skip


DEAD_OPTION = choosing({"key": "tries", ">": 3})
NEVER = choosing({"all": [{"key": "battery", ">": 0.8}, {"key": "battery", "<": 0.2}]})
DEAD_REQUIRES = mission({
    "driving": DRIVING,
    "done": {"final": "succeeded", "requires": {"all": [{"key": "at_home", "==": True}, {"key": "tries", ">": 3}]}},
    "aborted": ABORTED,
})  # fmt: skip
BY_WORD = mission({
    "choosing": asking({"finished": {"about": "it is done"}, "stop": {"about": "stop"}},
                       [{"on": "finished", "to": "done"}, {"on": "stop", "to": "aborted"}], fallback="stop"),
    "done": {"final": "succeeded", "requires": {"any": [{"key": "at_home", "==": True}, {"key": "tries", "==": 0}]}},
    "aborted": ABORTED,
})  # fmt: skip
NO_END = mission({
    "choosing": asking({"wait": {"about": "wait"}, "stop": {"about": "stop"}},
                       [{"on": "wait", "to": "waiting"}, {"on": "stop", "to": "aborted"}], fallback="stop"),
    "waiting": {"transitions": [{"when": {"key": "tries", ">": 0}, "to": "aborted"}]},
    "aborted": ABORTED,
})  # fmt: skip
CIRCLE = mission(
    {
        "here": {
            "transitions": [{"when": {"key": "battery", "<": 0.5}, "to": "there"}, {"on": "stop", "to": "aborted"}]
        },
        "there": {"transitions": [{"when": {"key": "battery", "<": 0.7}, "to": "here"}]},
        "aborted": ABORTED,
    },
    events={"stop": {}},
)
CANCEL = mission(
    {
        "driving": DRIVING,
        "tidying": {"transitions": [{"after_s": 5, "to": "again"}]},
        "again": {"transitions": [{"after_s": 5, "to": "tidying"}]},
        "done": DONE,
        "aborted": ABORTED,
    },
    on_cancel="tidying",
)
REFUTED: dict[str, tuple[Json, str, list[str]]] = {
    "deadlock": (DEADLOCK, "ends", ["the mission starts", "'drive' of 'driving' ended: succeeded"]),
    "livelock": (LIVELOCK, "comes to rest", ["the mission starts"]),
    "an option without an end": (NO_END, "ends", ["the mission starts", "answer of the model to 'choosing': wait"]),
    "an invariant that no rule keeps": (INVARIANT, "invariants", ["the mission starts"]),
    "an option that is never offered": (DEAD_OPTION, "options", []),
    "a requires that is never true": (DEAD_REQUIRES, "rules", []),
}


@pytest.fixture
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path / "flawed.json"


@pytest.mark.parametrize(("given", "claim", "run"), REFUTED.values(), ids=REFUTED)
def test_a_flaw_is_refuted_by_its_shortest_run_replayed_and_drawn(
    given: Json, claim: str, run: list[str], written: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written.write_text(json.dumps(given), encoding="utf-8")
    assert main(["prove", str(written), "--json", "-o", "flaw.journal"]) == 1
    report = {each["claim"]: each for each in json.loads(capsys.readouterr().out)["claims"]}
    assert report[claim]["verdict"] == "refuted" and [each["happens"] for each in report[claim]["run"]] == run
    assert all(report[name]["verdict"] == "proved" for name in ("stop", "cancel", "stopped"))
    if run:
        assert report[claim]["shows"] is True
        assert main(["replay", "flaw.journal"]) == 0
        assert main(["draw", str(written), "--journal", "flaw.journal", "-o", "flaw.dot"]) == 0


REFUSED = {
    "transitions that follow one another": (CIRCLE, "follow one another for ever"),
    "a success that the robot has no part in": (BY_WORD, "without a word of the robot"),
    "an option that excludes itself": (NEVER, "this can never be true"),
}


@pytest.mark.parametrize(("given", "sentence"), REFUSED.values(), ids=REFUSED)
def test_what_check_sees_is_reported_without_exploring(
    given: Json, sentence: str, written: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written.write_text(json.dumps(given), encoding="utf-8")
    assert main(["prove", str(written)]) == 2
    assert sentence in capsys.readouterr().err


def test_a_cancel_that_goes_round_is_ended_by_its_time(written: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written.write_text(json.dumps(CANCEL), encoding="utf-8")
    assert main(["prove", str(written)]) == 0
    assert "cancel: a cancel ends the mission from every state" in capsys.readouterr().out
