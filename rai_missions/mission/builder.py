# SPDX-License-Identifier: Apache-2.0
"""Missions in Python: keys as attributes, and transitions by what triggers them. What is built is what JSON has.

Rule: nothing here is kept in the mission; the models' own words are all there is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from rai_missions.errors import suggestion
from rai_missions.guards.guard import Guard
from rai_missions.keys import Key
from rai_missions.mission.references import Ref, answer, event
from rai_missions.states.effects import Effect
from rai_missions.states.state import Transition

__all__ = ("After", "Keys", "On", "Ref", "When", "answer", "event")

Condition: TypeAlias = Guard | Ref
States: TypeAlias = str | Sequence[str]
Effects: TypeAlias = Effect | Sequence[Effect]


class Keys:
    """The keys of a mission; each is an attribute, a reference to its value in guards, effects and goals.

    ```python
    k = Keys(battery=Key(float, source="robot", max_age_s=10), laps=Key(int, initial=0))
    low = (k.battery < 0.15) | ~k.battery.fresh
    ```
    """

    __keys__: Mapping[str, Key]

    def __init__(self, /, **keys: Key) -> None:
        self.__keys__ = keys

    def __getattr__(self, name: str) -> Ref:
        if name.startswith("__"):
            raise AttributeError(name)
        return self[name]

    def __getitem__(self, name: str) -> Ref:
        if name not in self.__keys__:
            raise AttributeError(f"no key '{name}'{suggestion(name, self.__keys__)}")
        return Ref(name, self.__keys__[name])

    def __repr__(self) -> str:
        return f"Keys({', '.join(self.__keys__)})"


def On(  # noqa: N802 - reads as the transition that it makes
    *on: str | Sequence[str], to: States = (), when: Condition | None = None, do: Effects = (), of: str | None = None,
    internal: bool = False, about: str = "",
) -> Transition:  # fmt: skip
    """A transition that one of these events or outcomes fires: `On("failed", "timed_out", to="assessing")`."""
    words = [word for each in on for word in ([each] if isinstance(each, str) else each)]
    return _transition(on=words, of=of, to=to, when=when, do=do, internal=internal, about=about)


def When(  # noqa: N802
    when: Condition, *, to: States = (), do: Effects = (), internal: bool = False, about: str = ""
) -> Transition:
    """A transition that fires as soon as its guard holds."""
    return _transition(when=when, to=to, do=do, internal=internal, about=about)


def After(  # noqa: N802
    after_s: float, *, to: States = (), when: Condition | None = None, do: Effects = (), internal: bool = False,
    about: str = "",
) -> Transition:  # fmt: skip
    """A transition that fires once, so many seconds after the entry."""
    return _transition(after_s=after_s, to=to, when=when, do=do, internal=internal, about=about)


def _transition(*, do: Effects, **words: Any) -> Transition:
    return Transition(do=[do] if isinstance(do, Effect) else list(do), **words)
