# SPDX-License-Identifier: Apache-2.0
"""Laws of the gate: one holder, no one else gets through, silence costs control, every refusal is counted."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Sequence

import pytest
from hypothesis import given

from rai_missions.gate.config import gate_words
from rai_missions.gate.rules import step
from rai_missions.gate.state import (
    COMMANDERS,
    ActuatorCommand,
    Alive,
    Answer,
    ControlChange,
    Gate,
    GateEffect,
    GateEvent,
    GateRules,
    Pass,
    PublishStatus,
    Refuse,
    Request,
    TimeUpdate,
    status_of,
)
from rai_missions.runtime.lifecycle import Control
from rai_missions.states.control import HOLDERS
from tests.gate.happenings import happenings, live, rules

AGENT_ALONE = GateRules(leases={"agent": 0.5})


def effects(rules: GateRules, happened: Sequence[GateEvent]) -> list[GateEffect]:
    return [effect for moment in live(rules, happened) for effect in moment.done]


@given(rules, happenings)
def test_control_goes_from_one_holder_to_another_without_gap_or_overlap(
    given_: GateRules, happened: Sequence[GateEvent]
) -> None:
    holder, revision = given_.safe, 0
    for effect in effects(given_, happened):
        if isinstance(effect, ControlChange):
            assert effect.former == holder != effect.holder and effect.holder in HOLDERS
            assert effect.revision == revision + 1
            holder, revision = effect.holder, effect.revision
        elif not isinstance(effect, PublishStatus):
            assert effect.revision == revision, "what is done under a grant carries its number"


@given(rules, happenings)
def test_only_the_holder_s_commands_go_through_and_none_made_before_its_grant(
    given_: GateRules, happened: Sequence[GateEvent]
) -> None:
    holder, since = given_.safe, 0.0
    for moment in live(given_, happened):
        for effect in moment.done:
            if isinstance(effect, ControlChange):
                holder, since = effect.holder, moment.after.at
            if isinstance(effect, Pass):
                assert effect.command.who == holder and effect.command.made >= since


@given(rules, happenings)
def test_a_command_goes_through_or_is_refused_once_and_each_is_counted(
    given_: GateRules, happened: Sequence[GateEvent]
) -> None:
    lived = live(given_, happened)
    passed, refused = Counter[str](), Counter[str]()
    for moment in lived:
        verdicts = [each for each in moment.done if isinstance(each, Pass | Refuse)]
        assert len(verdicts) == isinstance(moment.happened, ActuatorCommand)
        for verdict in verdicts:
            (passed if isinstance(verdict, Pass) else refused)[verdict.command.who] += 1
    if lived:
        last = status_of(lived[-1].after, given_)
        assert last["passed"] == {who: passed[who] for who in COMMANDERS}
        assert last["refused"] == {who: refused[who] for who in COMMANDERS}


@given(rules, happenings)
def test_whose_lease_has_run_out_loses_control_before_anything_else_is_done(
    given_: GateRules, happened: Sequence[GateEvent]
) -> None:
    for before, _, after, done in live(given_, happened):
        if after.at >= before.lapses_at(given_):
            safe = given_.safe if before.holder not in (given_.safe, "operator") else "nobody"
            assert isinstance(done[0], ControlChange) and (done[0].former, done[0].holder) == (before.holder, safe)


@given(rules, happenings)
def test_control_changes_by_a_granted_request_or_by_silence_alone(
    given_: GateRules, happened: Sequence[GateEvent]
) -> None:
    for before, what, after, done in live(given_, happened):
        changes = [each for each in done if isinstance(each, ControlChange)]
        lapsed = after.at >= before.lapses_at(given_)
        granted = any(isinstance(each, Answer) and not each.why for each in done)
        assert len(changes) <= lapsed + granted
        if isinstance(what, Request) and granted:
            assert after.holder == what.to


@given(rules, happenings)
def test_requests_are_judged_as_the_lifecycle_judges_them(given_: GateRules, happened: Sequence[GateEvent]) -> None:
    for before, what, after, done in live(given_, happened):
        if isinstance(what, Request) and what.by in COMMANDERS and what.to in HOLDERS:
            control = Control(before.holder, kept=before.kept)
            if after.at >= before.lapses_at(given_):
                control.acknowledge(given_.safe if before.holder not in (given_.safe, "operator") else "nobody")
            (answer,) = [each for each in done if isinstance(each, Answer)]
            assert answer.why == control.request(what.to, "operator" if what.by == "operator" else "software")


@given(rules, happenings)
def test_only_the_operator_lifts_control_from_no_one_and_gives_back_what_it_took(
    given_: GateRules, happened: Sequence[GateEvent]
) -> None:
    for before, what, after, done in live(given_, happened):
        if any(isinstance(each, Answer) and not each.why for each in done) and isinstance(what, Request):
            if before.holder == "nobody":
                assert what.by == "operator" or what.to == "nobody" == after.holder
            if before.kept and after.at < before.lapses_at(given_):
                assert what.by == "operator" or what.to == "nobody"


@given(rules, happenings)
def test_every_change_and_every_answer_is_reported_and_the_status_is_never_older_than_promised(
    given_: GateRules, happened: Sequence[GateEvent]
) -> None:
    for moment in live(given_, happened):
        if any(isinstance(each, ControlChange | Answer) for each in moment.done):
            assert moment.done[-1] == PublishStatus(moment.after)
        assert moment.after.at < moment.after.published + given_.status_s
        assert moment.after.wake_at(given_) > moment.after.at


@given(rules, happenings)
def test_reporting_the_time_more_often_changes_no_verdict(given_: GateRules, happened: Sequence[GateEvent]) -> None:
    ticked = [each for one in happened for each in (TimeUpdate(one.at), one, TimeUpdate(one.at))]
    plain, often = (
        [each for each in effects(given_, all_) if not isinstance(each, PublishStatus)] for all_ in (happened, ticked)
    )
    assert plain == often


def test_a_silent_holder_loses_control_and_its_next_command_is_refused() -> None:
    done = effects(
        AGENT_ALONE,
        [
            Request(1.0, "agent", "agent"),
            ActuatorCommand(1.4, "agent", "/c", {}),
            TimeUpdate(1.8),
            TimeUpdate(1.9),
        ],
    )
    assert [type(each) for each in done if not isinstance(each, PublishStatus)] == [
        ControlChange,
        Answer,
        Pass,
        ControlChange,
    ]
    late = [Request(1.0, "agent", "agent"), ActuatorCommand(1.5, "agent", "/c", {})]
    *_, change, refusal, _ = effects(AGENT_ALONE, late)
    assert isinstance(change, ControlChange) and change.why == "agent was silent for 0.5 s"
    assert isinstance(refusal, Refuse) and refusal.why == "autonomy holds control"


def test_a_heartbeat_keeps_control_and_a_stranger_s_does_not() -> None:
    asked = Request(0.0, "agent", "agent")
    assert live(AGENT_ALONE, [asked, Alive(0.4, "agent"), TimeUpdate(0.8)])[-1].after.holder == "agent"
    assert live(AGENT_ALONE, [asked, Alive(0.4, "operator"), TimeUpdate(0.8)])[-1].after.holder == "autonomy"


def test_the_safe_one_that_falls_silent_leaves_no_one() -> None:
    lived = live(GateRules(leases={"autonomy": 1.0}), [TimeUpdate(1.0)])
    assert lived[-1].after.holder == "nobody"


@pytest.mark.parametrize("safe", ["autonomy", "nobody"])
def test_an_operator_who_fell_silent_leaves_no_one_and_only_the_operator_lifts_it(safe: str) -> None:
    given_ = GateRules(leases={"operator": 1.0}, safe=safe)
    happened = [Request(0.0, "operator", "operator"), Request(0.5, "agent", "agent"), Request(2.0, "agent", "agent")]
    happened.append(Request(3.0, "agent", "operator"))
    answers = [each.why for each in effects(given_, happened) if isinstance(each, Answer)]
    lifts = "control is with 'nobody' since the stop; only the operator can lift it"
    assert answers == ["", "the operator has control and has not given it back", lifts, ""]


def test_a_command_made_before_the_grant_is_refused_though_its_maker_holds_control() -> None:
    *_, refusal = effects(AGENT_ALONE, [Request(1.0, "agent", "agent"), ActuatorCommand(1.1, "agent", "/c", {}, 0.8)])
    assert isinstance(refusal, Refuse)
    assert refusal.why == "it was made 0.2 s before control was handed over, or by another clock"


@pytest.mark.parametrize(
    ("to", "by", "why"),
    [
        ("bob", "agent", "nobody called 'bob' can hold control; there is: autonomy, agent, operator, nobody"),
        ("agent", "eve", "no one called 'eve' can ask for control; there is: autonomy, agent, operator"),
        ("agent", "nobody", "no one called 'nobody' can ask for control; there is: autonomy, agent, operator"),
    ],
)
def test_a_request_of_strangers_or_for_strangers_is_refused_with_who_there_is(to: str, by: str, why: str) -> None:
    gate, (answer, _) = step(AGENT_ALONE, Gate(), Request(0.0, to, by))
    assert isinstance(answer, Answer) and answer.why == why
    assert gate.holder == "autonomy" and gate.requests_refused == ({by: 1} if by in COMMANDERS else {})


def test_a_request_of_the_holder_for_what_it_has_changes_no_grant() -> None:
    gate, done = step(AGENT_ALONE, Gate(), Request(0.0, "autonomy", "autonomy"))
    assert gate.revision == 0 and not any(isinstance(each, ControlChange) for each in done)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_a_number_that_is_not_finite_goes_no_further_and_is_counted(number: float) -> None:
    holds = Gate(holder="agent")
    data = {"linear": {"x": 0.1}, "points": [{"effort": array("d", [1.0, number])}]}
    after, done = step(AGENT_ALONE, holds, ActuatorCommand(0.1, "agent", "/arm", data))
    assert [type(each) for each in done if not isinstance(each, PublishStatus)] == [Refuse]
    assert after.refused == {"agent": 1} and after.passed == {}
    assert after.last_refusal == f"agent on /arm: 'points.0.effort.1' is {number}, which is no finite number"
    assert after.alive == {"agent": 0.1}, "who commands nonsense is there all the same"


def test_a_topic_may_let_numbers_through_that_are_not_finite() -> None:
    words = gate_words(
        {"commands": [{"topic": "/arm", "type": "a/msg/B", "finite": False}, {"topic": "/b", "type": "t"}]}
    )
    for topic, sort in (("/arm", Pass), ("/b", Refuse)):
        _, done = step(words.rules, Gate(holder="agent"), ActuatorCommand(0.1, "agent", topic, {"x": float("nan")}))
        assert sort in map(type, done)
