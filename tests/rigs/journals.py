# SPDX-License-Identifier: Apache-2.0
"""Steps as they come, generated: every effect, every kind of value."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from rai_missions.engine.decision import Evidence, Limits, Offer, Question
from rai_missions.engine.step import (
    Ask,
    CallService,
    CancelGoal,
    Handover,
    LogLine,
    Move,
    PublishMessage,
    SayAloud,
    StartGoal,
    Step,
    Withdraw,
)
from rai_missions.event import Event, Image

__all__ = ("blackboard_writes", "steps", "values")

names = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
words = st.text(max_size=12)
instants = st.floats(min_value=0, max_value=1e9, allow_nan=False)
numbers = st.integers(0, 10_000)
images = st.builds(
    Image,
    names.map("camera@{}".format),
    st.integers(1, 4),
    st.integers(1, 4),
    st.sampled_from(["rgb8", "png"]),
    st.binary(max_size=48),
)
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False),
    words,
    st.text(alphabet="\ud800a\x00é", max_size=3),
    images,
)


def _nested(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    keys = words | st.sampled_from(["$image", "$tuple", "$object", "$", "number"])
    return st.one_of(
        st.lists(inner, max_size=3), st.lists(inner, max_size=2).map(tuple), st.dictionaries(keys, inner, max_size=3)
    )


values = st.recursive(scalars, _nested, max_leaves=6)
"""Whatever a blackboard or an event can hold."""
objects = st.dictionaries(words, values, max_size=3)
texts = st.lists(words, max_size=3).map(tuple)

kinds = ("event", "tick", "write", "accepted", "feedback", "result", "proposal", "control", "behaviour", "command")
events = st.builds(Event, words, instants, objects, st.sampled_from(kinds), numbers)
moves = st.builds(Move, texts, texts, texts, words)
offers = st.builds(Offer, names, words, st.none() | objects)
evidence = st.builds(Evidence, names, values, st.none() | instants, st.booleans())
limits = st.builds(Limits, numbers, numbers, st.none() | instants)
endings = instants | st.just(float("inf"))
offered, shown = (st.lists(part, max_size=3).map(tuple) for part in (offers, evidence))
questions = st.builds(
    Question, numbers, words, names, words, offered, shown, numbers, instants, endings, texts, texts, limits
)
effects = st.one_of(
    st.builds(StartGoal, numbers, words, names, objects),
    st.builds(CancelGoal, numbers, names),
    st.builds(CallService, numbers, words, names, objects, st.none() | instants),
    st.builds(PublishMessage, names, objects),
    st.builds(SayAloud, words),
    st.builds(LogLine, words),
    st.builds(Ask, questions),
    st.builds(Withdraw, numbers),
    st.builds(Handover, names),
)
steps = st.builds(
    Step, numbers, instants, events, st.lists(moves, max_size=3).map(tuple),
    st.lists(st.tuples(words, st.sampled_from([True, False, None])), max_size=3).map(tuple),
    st.lists(st.tuples(names, values), max_size=3).map(tuple),
    st.none() | st.sampled_from(["succeeded", "failed", "aborted", "canceled"]),
    st.none() | instants, st.lists(effects, max_size=4).map(tuple), words, texts,
)  # fmt: skip
blackboard_writes = st.lists(st.tuples(names, values, instants), max_size=3, unique_by=lambda write: write[0])
