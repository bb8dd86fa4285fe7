# SPDX-License-Identifier: Apache-2.0
"""What a program gives to a public function is of the type that it takes, or refused in a sentence that names it."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime, timedelta
from decimal import Decimal
from typing import Any

import pytest

from rai_missions import Chart, Event, Mission, Runner, UsageError, load
from rai_missions.agents import run
from rai_missions.agents.run_config import MAPPINGS
from rai_missions.check import check
from rai_missions.connectors.local import LocalConnector
from rai_missions.journal import Header, Journal, read, verify
from rai_missions.prove import prove
from rai_missions.replay.open_run import open_run
from rai_missions.runtime.clock import SimulatedClock, WallClock
from rai_missions.runtime.run_options import NewRun

MISSION = Mission.model_validate(
    {"format": 1, "name": "a", "version": "1", "initial": "x", "states": {"x": {"final": "aborted"}}}
)
WAITING = Mission.model_validate({
    "format": 1, "name": "b", "initial": "x", "events": {"go": {"fields": {"far": "boolean"}}},
    "blackboard": {"n": {"type": "number", "initial": 0}},
    "states": {"x": {"transitions": [{"on": "go", "when": {"key": "event.far", "==": True}, "to": "y"}]},
               "y": {"final": "aborted"}},
})  # fmt: skip
NO_PATHS: tuple[Any, ...] = (5, 0.5, True, b"x", [1], {"a": 1}, object(), print, Exception)
NO_NAMES: tuple[Any, ...] = (5, 0.5, True, "x", b"x", [1], {1: 2}, object(), print, Exception)
NO_NUMBERS: tuple[Any, ...] = ("3", None, True, 1j, [1], {}, object(), print, Exception)
NO_TIMES = ("3", None, 1j, [1], {}, object(), math.nan, math.inf, -math.inf, datetime.now(), timedelta(seconds=3))
NO_INSTANTS = (*NO_TIMES, True, 10**400, Decimal(3))

Door = Callable[[Any], object]


def option(word: str) -> tuple[str, Door]:
    return word, lambda given: run(MISSION, **{word: given})


def part(word: str) -> tuple[str, Door]:
    return word, lambda given: Runner(MISSION, **{word: given})


def begun() -> Chart:
    chart = Chart(WAITING)
    chart.start()
    return chart


PATHS: list[tuple[str, Door]] = [
    *map(option, ("journal", "record", "resume")),
    ("load", load),
    *(("a journal", door) for door in (read, verify, Journal.open, open_run)),
    ("a journal", lambda given: Journal.create(given, Header("{}"))),
]
NAMES: list[tuple[str, Door]] = [
    *map(option, MAPPINGS),
    ("named", lambda given: Chart(MISSION, named=given)),
    ("restore", lambda given: Chart.restore(MISSION, given)),
    ("parameters", lambda given: begun().propose(1, "x", given)),
    ("parameters", lambda given: Runner(MISSION).answer(1, "x", given)),
    ("arguments", NewRun),
    part("answerers"),
]
OTHERS: list[tuple[str, Door]] = [
    *map(option, ("waits", "on_step", "on_status", "connector", "opened", "operator", "clock")),
    *map(part, ("robot", "connector", "clock", "journal", "begin", "observer")),
    ("'agent' of answerers", lambda given: run(MISSION, answerers={"agent": given})),
    ("'agent' of answerers", lambda given: Runner(MISSION, answerers={"agent": given})),
    ("a Runner", Runner),
    ("named", lambda given: check(MISSION, named=given)),
    ("write", lambda given: Chart(MISSION).write(given, 1)),
    ("robot_facts", lambda given: prove(MISSION, robot_facts=given)),
    ("robot_facts", lambda given: Chart(MISSION, robot_facts=given)),
    ("ticker", lambda given: Chart(MISSION, given)),
    ("an answer", lambda given: Runner(MISSION).answer(1, given)),
]
NUMBERS: list[tuple[str, Door]] = [("model_memory_gib", option("model_memory_gib")[1])]
INSTANTS: list[tuple[str, Door]] = [
    ("start", lambda given: Chart(MISSION).start(given)),
    ("the time of 'go'", lambda given: Chart(WAITING).send(Event("go", given))),
    ("the time of 'go'", lambda given: Runner(MISSION).post(Event("go", given))),
    ("the time of 'agent'", lambda given: begun().send(Event("agent", given, kind="proposal"))),
]
ON_THE_SHORT_WAY: list[tuple[str, Door]] = [
    ("the time of 'go'", lambda given: begun().send(Event("go", given))),
    ("the time of 'n'", lambda given: begun().send(Event("n", given, {"value": 1}, "write"))),
]
FIELDS: dict[str, tuple[Any, ...]] = {
    "name": (5, None, b"go", ["go"], {}), "data": (5, "x", [1], None), "kind": (5, None, ["event"], {}),
    "number": ("1", 0.5, None, True, []),
}  # fmt: skip
"""A field of an event → what it is not."""


@pytest.mark.parametrize(
    ("word", "door", "given"),
    [
        (word, door, given)
        for doors, values in (
            (PATHS, NO_PATHS), (NAMES, NO_NAMES), (OTHERS, (object(),)), (NUMBERS, NO_NUMBERS), (INSTANTS, NO_INSTANTS),
            (ON_THE_SHORT_WAY, NO_TIMES),
            ([option("clock"), part("clock")], (WallClock, SimulatedClock)),
            ([option("seed")], (True, 1.5, "1")),
        )
        for word, door in doors
        for given in values
    ],
)  # fmt: skip
def test_what_a_function_does_not_take_is_refused_by_its_word(word: str, door: Door, given: Any) -> None:
    with pytest.raises(UsageError, match=rf"^(a key of )?{word} takes "):
        door(given)


class Around:
    """What hands all on to another: its class has none of the members itself."""

    def __init__(self, inner: Any) -> None:
        self._inner = inner

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


@pytest.mark.parametrize(("word", "given"), [("clock", SimulatedClock()), ("connector", LocalConnector())])
def test_what_hands_all_on_to_one_that_fits_is_taken_on_any_python(word: str, given: Any) -> None:
    part(word)[1](Around(given))
    with pytest.raises(UsageError, match=rf"^{word} takes "):
        part(word)[1](Around(object()))


@pytest.mark.parametrize("kind", ["event", "write", "proposal", "control", "command"])
@pytest.mark.parametrize(("field", "given"), [(field, given) for field, some in FIELDS.items() for given in some])
def test_an_event_whose_field_is_of_another_type_is_refused_and_changes_nothing(
    kind: Any, field: str, given: Any
) -> None:
    event = Event("go", 1.0, {"far": True}, kind)._replace(**{field: given})
    charts = (Chart(WAITING), begun()) if kind not in ("event", "write") else (Chart(WAITING),)
    for chart in charts:
        before = chart.snapshot(), chart.seq, chart.at
        with pytest.raises(UsageError, match=rf"^the {field} of an event takes "):
            chart.send(event)
        assert (chart.snapshot(), chart.seq, chart.at) == before
    with pytest.raises(UsageError, match=rf"^the {field} of an event takes "):
        Runner(WAITING).post(event)


@pytest.mark.parametrize(
    "event", [Event(["go"]), Event("n", data=5, kind="write"), Event("n", data=None, kind="write")]
)
def test_an_event_with_which_the_short_way_can_do_nothing_is_refused_and_changes_nothing(event: Any) -> None:
    chart = begun()
    before = chart.snapshot(), chart.seq, chart.at
    with pytest.raises(UsageError, match=r"^the (name|data) of an event takes "):
        chart.send(event)
    assert (chart.snapshot(), chart.seq, chart.at) == before
    assert chart.send(Event("go", 1.0, {"far": True})).outcome == "aborted"


@pytest.mark.parametrize("given", ["go", None, 5, ("go", 1.0, {}, "event", 0), {"name": "go"}])
def test_what_is_posted_to_a_run_is_an_event(given: Any) -> None:
    for door in (Runner(WAITING).post, Runner(WAITING).post_urgent):
        with pytest.raises(UsageError, match=r"^a run is sent an Event, not .*; write Event\('go', at=3.2\)"):
            door(given)


@pytest.mark.parametrize("given", [object(), math.nan, b"x", {1: 2}, [{"deep": object()}], datetime.now()])
def test_what_no_journal_could_hold_is_refused_where_it_is_posted(given: Any) -> None:
    with pytest.raises(UsageError, match="a journal"):
        Runner(WAITING).post(Event("go", data={"far": given}))


class HalfConnector:
    """What a program begins to write."""

    modes = running = None

    def start(self) -> None: ...
    def stop(self) -> None: ...


class AsyncConnector(LocalConnector):
    async def call(self, *args: Any, **words: Any) -> None: ...  # type: ignore[override]


class AsyncAnswerer:
    async def ask(self, question: Any, answer: Any) -> None: ...
    def withdraw(self, number: int) -> None: ...


def test_an_async_method_that_nothing_awaits_is_refused() -> None:
    remedy = "whose calls are not awaited: write `def`, not `async def`, for"
    with pytest.raises(UsageError, match=rf"connector takes a connector {remedy} AsyncConnector\.call$"):
        run(MISSION, connector=AsyncConnector())
    with pytest.raises(UsageError, match=rf"takes an answerer {remedy} AsyncAnswerer\.ask$"):
        run(MISSION, answerers={"agent": AsyncAnswerer()})


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (LocalConnector, r"not <class .*LocalConnector'>; write LocalConnector\(…\)$"),
        (
            HalfConnector(),
            r"; it has no call, cancel_goal, find_goal, listed, offer, publish, send_goal, serve, subscribe$",
        ),
        (3, "takes a connector, not 3$"),
    ],
)
def test_what_is_nearly_a_connector_is_refused_with_what_it_lacks(given: Any, sentence: str) -> None:
    with pytest.raises(UsageError, match=sentence):
        run(MISSION, connector=given)
