# SPDX-License-Identifier: Apache-2.0
"""A dialogue sees a run as it was after one of its steps: never the mode of one with the outcome of another."""

from __future__ import annotations

import random
import threading
from functools import partial
from typing import Any

import pytest

from rai_missions.agents.talk.run_status import RunStatus
from rai_missions.conversation import StatusView
from rai_missions.engine.step import Step
from tests.rigs.runs import ManualServer, ReplyingAnswerer, Rig, mission

pytestmark = pytest.mark.usefixtures("changes_threads_often")
READERS = 3
ROUND: dict[str, Any] = {
    "moving": {
        "action": "move", "timeout_s": 0.4, "control": "agent", "entry": [{"set": "count", "add": 1}],
        "achieved": {"key": "count", ">=": 3},
        "transitions": [{"on": ["succeeded", "timed_out", "failed", "unverified", "refused"], "to": "asking"}],
    },
    "asking": {
        "decision": {
            "question": "Which way?", "options": {"again": {"about": "once more"}, "home": {"about": "go home"}},
            "ask": ["operator"], "deadline_s": 0.3, "fallback": "again",
        },
        "transitions": [{"on": "again", "to": "moving"}, {"on": "home", "to": "over"}],
    },
    "over": {"final": "aborted"},
}  # fmt: skip


def timeless(view: StatusView) -> StatusView:
    """A view without what passes with time alone."""
    keys = {name: key._replace(age_s=None, is_fresh=False) for name, key in view.keys.items()}
    return view._replace(at=0.0, keys=keys)


class Watched:
    """A run that some read; what happens to it is drawn by a seed."""

    def __init__(self, seed: int) -> None:
        rng = random.Random(seed)
        self.published = list[StatusView]()
        self.read, self.looks = list[StatusView](), 0
        self.rig = Rig(mission(ROUND), on_step=self._step, on_status=lambda status: self._status.status(status))
        self.rig.move = ManualServer("accepted", rng.choice(["succeeded", "failed"]))
        self._status = RunStatus(self.rig.runner)
        self._publish()
        run, at = self.rig.runner, 0.0
        for _ in range(rng.randint(4, 12)):
            at += rng.choice([0.1, 0.1, 0.2, 0.5])
            do = rng.choice(
                [
                    run.pause,
                    run.resume,
                    run.resume,
                    partial(run.answer, rng.randint(1, 4), "again"),
                    partial(run.answer, rng.randint(1, 4), "home"),
                    *(partial(run.control, to) for to in ("operator", "agent", "agent", "autonomy", "nobody")),
                ]
            )
            self.rig.stage.play({at: do})
        self.rig.stage.play({at + 1.0: rng.choice([run.cancel, run.kill])})
        self.rig.stage.play({at + 2.0: run.kill})

    def _step(self, step: Step) -> None:
        self._status.step(step)
        self._publish()
        enough = self.looks + READERS + 1
        while len(self.read) < 2 and self.looks < enough:  # on a busy machine no reader may have had its turn
            threading.Event().wait(0.001)

    def _publish(self) -> None:
        self.published.append(timeless(self._status.view()))

    def run(self) -> None:
        over = threading.Event()

        def read() -> None:
            while not over.is_set():
                self.looks += 1
                view = timeless(self._status.view())
                if not self.read or view != self.read[-1]:
                    self.read.append(view)

        readers = [threading.Thread(target=read, daemon=True) for _ in range(READERS)]
        for reader in readers:
            reader.start()
        self.rig.run()
        over.set()
        for reader in readers:
            reader.join()


def torn(run: Watched) -> list[dict[str, Any]]:
    """What was read and is no view after a step: in what it differs from the one that is nearest."""
    found = []
    for view in run.read:
        if view not in run.published:
            differs = (
                {name: (was, now) for name, was, now in zip(view._fields, each, view, strict=True) if was != now}
                for each in run.published
            )
            found.append(min(differs, key=len))
    return found


@pytest.mark.parametrize("seed", range(6))
def test_what_a_reader_sees_of_a_run_is_how_it_was_after_one_step(seed: int) -> None:
    run = Watched(seed)
    run.run()
    assert len(run.read) > 1 and torn(run) == []


@pytest.mark.parametrize("is_there", [False, True])
def test_a_question_is_the_operator_s_where_there_is_one(is_there: bool) -> None:
    asked = {"question": "Which way?", "options": {"on": {"about": "drive on"}}, "ask": ["operator", "rules"],
             "within_s": 1.0}  # fmt: skip
    states = {
        "asking": {"decision": asked, "transitions": [{"on": "on", "to": "over"}, {"after_s": 9, "to": "over"}]},
        "over": {"final": "aborted"},
    }
    seen = list[tuple[str, ...]]()

    def look(step: Step) -> None:
        status.step(step)
        seen.append(tuple(each.text for each in status.view().questions))

    answerers = {"rules": ReplyingAnswerer("on")} | ({"operator": ReplyingAnswerer(lambda _: None)} if is_there else {})
    rig = Rig(mission(states), answerers=answerers, on_step=look)
    status = RunStatus(rig.runner)
    rig.run()
    assert (("Which way?",) in seen) == is_there and () in seen
