# SPDX-License-Identifier: Apache-2.0
"""What every activity must do, as a function that a kind's tests call."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.chart import Chart
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.engine.step import Ask, CallService, StartGoal, Step
from rai_missions.event import Event
from rai_missions.guards.contract import check_kind
from rai_missions.keys import Key
from rai_missions.mission.mission import Mission
from rai_missions.states import Final, State, Transition

__all__ = ("check_activity",)

MOST = 300
"""After so many instants of runs everything that may happen next is tried."""
ChartInput = Callable[[Chart], Step]
Awaited = tuple[str, str, int]
"""What a reply is waited for: `goal`, `call` or `option`, the option's name, and the number."""


def check_activity(
    state: State,
    keys: Mapping[str, Key],
    facts: Sequence[Mapping[str, Any]] = (),
    *,
    ticker: Trees | None = None,
    most: int = MOST,
) -> None:
    """Hold the activity of a state to the contract of its kind, in every run of a few hundred instants.

    Args:
        state: One of the kind; where its outcomes lead does not count.
        keys: The keys that it reads and writes, and others.
        facts: What may be written while it runs, key → value.
        ticker: What ticks its tree, if it runs one.
        most: After so many instants everything that may happen next is tried.

    Raises:
        AssertionError: A promise is broken; the text names it.
    """
    check_kind(state, "activity", lambda: (state.activity(), *state.lines()))
    assert state.made() == state.made(), f"'{state.word}' makes another tree each time"
    ends = state.outcomes()
    away = (Transition(on=sorted(ends), to="over"),) if ends else ()
    mission = Mission(
        "contract",
        keys=dict(keys),
        initial="it",
        uses=_uses(state),
        states={
            "it": state.model_copy(update={"transitions": away}),
            "over": Final("aborted"),
        },
    )
    instant, chart = _Instant(state, mission, ticker), Chart(mission, ticker=ticker)
    waiting = [(chart.start(0.0), chart, frozenset[Awaited]())]
    for _ in range(most):
        if not waiting:
            return
        step, chart, awaited = waiting.pop(0)
        awaited |= frozenset(_asked(step))
        if chart.outcome is not None or "it" not in chart.active:
            continue
        for stimulus in _stimuli(step, awaited, chart, facts):
            waiting.append((*instant.after(chart, stimulus), awaited))


def _uses(state: State) -> tuple[str, ...]:
    offer = state.offer(state.word)
    return (offer.package,) if offer is not None else ()


class _Instant:
    """Compares what charts make of something that has happened."""

    def __init__(self, state: State, mission: Mission, ticker: Trees | None) -> None:
        self._word, self._mission, self._ticker = state.word, mission, ticker
        named = (reference for each in state.everything() for reference in each.references())
        self._named = {name for refers, name, _ in named if refers.sort == "key"}

    def after(self, chart: Chart, stimulus: ChartInput) -> tuple[Step, Chart]:
        """The step and the chart after it, the same for a chart that was restored and for one that was stored."""
        saved, stored = chart.snapshot(), unpacked(packed(chart.snapshot()))
        first, second = (Chart.restore(self._mission, each, ticker=self._ticker) for each in (saved, stored))
        assert first.snapshot() == saved, f"'{self._word}' is not restored as it was"
        step, again = stimulus(first), stimulus(second)
        assert step == again, f"'{self._word}' does something else once it was stored: {step} and {again}"
        assert first.snapshot() == second.snapshot(), f"'{self._word}' remembers something else once it was stored"
        assert chart.snapshot() == saved, f"'{self._word}' changes what it remembers in place"
        written = {key for key, _ in step.writes} - self._named if step.event.kind != "write" else set()
        assert not written, f"'{self._word}' writes what none of its fields names: {sorted(written)}"
        assert first.outcome in (None, "aborted"), f"'{self._word}' reports what it does not declare: {first.why}"
        return step, first


def _asked(step: Step) -> Iterator[Awaited]:
    """What a step waits for."""
    for effect in step.effects:
        if isinstance(effect, StartGoal):
            yield "goal", "", effect.number
        elif isinstance(effect, CallService):
            yield "call", "", effect.number
        elif isinstance(effect, Ask):
            yield from (("option", offer.name, effect.question.number) for offer in effect.question.options)


def _stimuli(
    step: Step, awaited: frozenset[Awaited], chart: Chart, facts: Sequence[Mapping[str, Any]]
) -> Iterator[ChartInput]:
    """What may happen next: a reply of each kind, the next instant that it asks for, and what may be written."""
    at = chart.at + 0.1
    for sort, option, number in sorted(awaited):
        if sort == "option":
            yield lambda chart, number=number, name=option: chart.propose(number, name, at=at)  # type: ignore[misc]
        else:
            for name in ("succeeded", "failed"):
                yield _sending(Event(name, at, {}, "result", number))
    if step.wake_at is not None and step.wake_at < float("inf"):
        yield _sending(Event("tick", max(at, step.wake_at), {}, "tick"))
    for fact in facts:
        for key, value in fact.items():
            yield lambda chart, key=key, value=value: chart.write(key, value, at=at)  # type: ignore[misc]


def _sending(event: Event) -> ChartInput:
    return lambda chart: chart.send(event)
