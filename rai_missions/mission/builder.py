# SPDX-License-Identifier: Apache-2.0
"""Missions in Python: keys as attributes, and transitions by what triggers them. What is built is what JSON has.

Rule: nothing here is kept in the mission; the models' own words are all there is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Any, ParamSpec

from rai_missions.errors import DefinitionError, Fault, escaped, suggestion
from rai_missions.guards.guard import GuardOrKey
from rai_missions.keys import Key
from rai_missions.mission.references import Ref
from rai_missions.redaction import shown
from rai_missions.states.effects import Effect
from rai_missions.states.transition import Transition

__all__ = (
    "After",
    "Keys",
    "On",
    "When",
)

P = ParamSpec("P")


class Keys:
    """The keys of a mission; each is an attribute, a reference to its value in guards, effects and goals.

    ```python
    k = Keys(battery=Key(float, source="robot", max_age_s=10), laps=Key(int, initial=0))
    low = (k.battery < 0.15) | ~k.battery.fresh
    ```
    """

    __keys__: Mapping[str, Key]

    def __init__(self, /, **keys: Key) -> None:
        """Name the keys.

        Args:
            keys: Name → the key.

        Raises:
            DefinitionError: Something else than a `Key` is given.
        """
        given: Mapping[str, Any] = keys
        wrong = {name: value for name, value in given.items() if not isinstance(value, Key)}
        if wrong:
            faults = (Fault(f"/{name}", f"{shown(value)} is no key; write Key(…)") for name, value in wrong.items())
            raise DefinitionError(faults, "Keys(…)")
        self.__keys__ = keys

    def __getattr__(self, name: str) -> Ref:
        if name.startswith("__"):
            raise AttributeError(name)
        return self[name]

    def __getitem__(self, name: str) -> Ref:
        if name not in self.__keys__:
            raise AttributeError(f"no key '{name}'{suggestion(name, self.__keys__)}")
        return Ref(name, self.__keys__[name])

    def __dir__(self) -> list[str]:
        return sorted(self.__keys__)

    def __repr__(self) -> str:
        return f"Keys({', '.join(self.__keys__)})"


def _transition(function: Callable[P, Transition]) -> Callable[P, Transition]:
    """A constructor of transitions, named in what it refuses; for a word that it does not have, with the nearest."""
    known = function.__code__.co_varnames[: function.__code__.co_argcount + function.__code__.co_kwonlyargcount]

    @wraps(function)
    def made(*given: P.args, **words: P.kwargs) -> Transition:
        unknown = [word for word in words if word not in known]
        if unknown:
            what = f"'{function.__name__}' has no"
            faults = [Fault(f"/{escaped(word)}", f"{what} {shown(word)}{suggestion(word, known)}") for word in unknown]
            raise DefinitionError(faults, f"{function.__name__}(…)")
        try:
            return function(*given, **words)
        except DefinitionError as error:
            raise DefinitionError(error.faults, f"{function.__name__}(…)") from None

    return made


@_transition
def On(  # noqa: N802 - reads as the transition that it makes
    *on: str | Sequence[str],
    to: str | Sequence[str] = (),
    when: GuardOrKey | None = None,
    do: Effect | Sequence[Effect] = (),
    of: str | None = None,
    internal: bool = False,
    about: str = "",
) -> Transition:
    """A transition that one of these events or outcomes fires: `On("failed", "timed_out", to="assessing")`.

    Args:
        on: Events or outcomes; `*` is any declared event.
        to: The target, or one a region; without one the state is not left.
        when: What must be true for it to fire.
        do: What is done on the way: one effect or several, in this order.
        of: The state whose outcome is meant, if not that of the state it is written in.
        internal: From a compound state into itself without leaving it. Default: False.
        about: What it is for, in a sentence.
    """
    words = [word for each in on for word in ([each] if isinstance(each, str) else each)]
    return Transition(words, of=of, to=to, when=when, do=do, internal=internal, about=about)


@_transition
def When(  # noqa: N802
    when: GuardOrKey,
    *,
    to: str | Sequence[str] = (),
    do: Effect | Sequence[Effect] = (),
    internal: bool = False,
    about: str = "",
) -> Transition:
    """A transition that fires as soon as its guard holds: `When(k.battery < 0.2, to="returning")`.

    Args:
        when: A guard, or a reference to a boolean key.
        to: The target, or one a region; without one the state is not left.
        do: What is done on the way: one effect or several, in this order.
        internal: From a compound state into itself without leaving it. Default: False.
        about: What it is for, in a sentence.
    """
    return Transition(when=when, to=to, do=do, internal=internal, about=about)


@_transition
def After(  # noqa: N802
    after_s: float,
    *,
    to: str | Sequence[str] = (),
    when: GuardOrKey | None = None,
    do: Effect | Sequence[Effect] = (),
    internal: bool = False,
    about: str = "",
) -> Transition:
    """A transition that fires once, some time after the entry: `After(5, to="signalling")`.

    Args:
        after_s: Seconds since the state was entered.
        to: The target, or one a region; without one the state is not left.
        when: What must be true then; if it is not, the transition is lost.
        do: What is done on the way: one effect or several, in this order.
        internal: From a compound state into itself without leaving it. Default: False.
        about: What it is for, in a sentence.
    """
    return Transition(after_s=after_s, to=to, when=when, do=do, internal=internal, about=about)
