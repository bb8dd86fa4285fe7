# SPDX-License-Identifier: Apache-2.0
"""References: a key, a field, what an event or an answer brought, as Python authors write them in guards and effects.

Rule: a reference has no value. Comparing it makes a guard; writing it where the format has a path gives that path.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NoReturn

from rai_missions.errors import nearest, suggestion

if TYPE_CHECKING:
    from rai_missions.guards.guard import Guard
    from rai_missions.keys import Key

__all__ = ("Ref", "answer", "event")

POSE = ("x", "y", "z", "yaw", "frame")
OFFERS = ("fresh", "held_for", "is_false", "is_in", "is_true", "near", "or_unknown")
"""What a reference makes guards by, next to operators."""


def _guard(word: str, **words: Any) -> Guard:
    # The package's front door offers `event` and `answer` and stays light: guards are imported when one is made.
    from rai_missions import guards

    guard: Guard = guards.Guard.kinds[word](**words)
    return guard


class Ref:
    """A place that a value is read from: `k.battery`, `k.obstacle.height_m`, `event.distance_m`.

    A field whose name is taken here (`fresh`, `near`, `is_in`, `is_true`, `is_false`, `held_for`, `or_unknown`) is
    reached as `k.obstacle["fresh"]`.
    """

    __slots__ = ("__key__", "__path__")

    __path__: str
    __key__: Key | None

    def __init__(self, path: str, key: Key | None = None) -> None:
        self.__path__, self.__key__ = path, key

    def __getattr__(self, field: str) -> Ref:
        if field.startswith("__"):
            raise AttributeError(field)
        return self[field]

    def __getitem__(self, field: str) -> Ref:
        known = self._fields()
        if known is not None and field not in known:
            from rai_missions.redaction import shown  # heavy, and needed for this sentence alone

            what = f"'{self.__path__}' has no field {shown(field)}"
            near = nearest(field, (*known, *OFFERS))
            hint = f"; did you mean '{near}'?" if near else suggestion(field, known)
            raise AttributeError(what + (hint or f"; it is no object, a reference has: {', '.join(OFFERS)}"))
        return Ref(f"{self.__path__}.{field}")

    def _fields(self) -> Iterable[str] | None:
        """The fields that there are; None where that is not declared."""
        key = self.__key__
        if key is None or (key.type == "object" and key.fields is None):
            return None
        return POSE if key.type == "pose" else key.fields or ()

    def _compared(self, operator: str, other: Any) -> Guard:
        value = {"key": other.__path__} if isinstance(other, Ref) else other
        return _guard("key", **{"key": self.__path__, operator: value})

    def __lt__(self, other: Any) -> Guard:
        return self._compared("<", other)

    def __le__(self, other: Any) -> Guard:
        return self._compared("<=", other)

    def __gt__(self, other: Any) -> Guard:
        return self._compared(">", other)

    def __ge__(self, other: Any) -> Guard:
        return self._compared(">=", other)

    def __eq__(self, other: object) -> Guard:  # type: ignore[override]
        return self._compared("==", other)

    def __ne__(self, other: object) -> Guard:  # type: ignore[override]
        return self._compared("!=", other)

    def __hash__(self) -> int:
        return hash(self.__path__)

    def is_in(self, values: Iterable[Any] | Ref) -> Guard:
        """True where the value is one of these, or of those that another key holds.

        Args:
            values: The values, or a reference to a key that holds a list.
        """
        return self._compared("in", values if isinstance(values, Ref) else list(values))

    def near(self, other: Ref, *, within_m: float) -> Guard:
        """True where this pose lies within so many metres of another.

        Args:
            other: A pose in the same frame.
            within_m: The largest distance, in metres.
        """
        return _guard("near", near=(self.__path__, other.__path__), within_m=within_m)

    @property
    def fresh(self) -> Guard:
        """True where the key was received and is not older than its `max_age_s`."""
        return _guard("fresh", fresh=self.__path__)

    @property
    def is_true(self) -> Guard:
        """`== true`, which a reference means among `&` and `|`."""
        return self._compared("==", True)

    @property
    def is_false(self) -> Guard:
        """`== false`, which `~` means too."""
        return self._compared("==", False)

    def held_for(self, seconds: float) -> Guard:
        """True once this has been `== true` for so long without a break."""
        return self.is_true.held_for(seconds)

    @property
    def or_unknown(self) -> Guard:
        """True where this is `== true` or unknown."""
        return self.is_true.or_unknown

    def __invert__(self) -> Guard:
        return self.is_false

    def __and__(self, other: Guard | Ref) -> Guard:
        return self.is_true & _condition(other)

    def __or__(self, other: Guard | Ref) -> Guard:
        return self.is_true | _condition(other)

    def __rand__(self, other: Guard) -> Guard:
        return _condition(other) & self.is_true

    def __ror__(self, other: Guard) -> Guard:
        return _condition(other) | self.is_true

    def __bool__(self) -> NoReturn:
        raise TypeError(f"'{self.__path__}' has no truth of its own; combine with & | ~, not with and, or, not, in")

    def __contains__(self, item: object) -> NoReturn:
        raise TypeError(f"what '{self.__path__}' holds is known in a run; compare with `ref.is_in(…)`")

    def __iter__(self) -> NoReturn:
        raise TypeError(f"'{self.__path__}' is a value that is known in a run; it has no items here")

    def __dir__(self) -> list[str]:
        return sorted({*(self._fields() or ()), *OFFERS})

    def __repr__(self) -> str:
        return f"<{self.__path__}>"


def _condition(given: Any) -> Guard:
    """A guard, or a reference as the guard that it means."""
    from rai_missions.guards.guard import BRACKETS, Guard

    if isinstance(given, Ref):
        return given.is_true
    if isinstance(given, Guard):
        return given
    raise TypeError(f"{given!r} is no guard; {BRACKETS}")


event = Ref("event")
"""What the event in hand brought: `event.distance_m`, in the transition that it fires."""
answer = Ref("answer")
"""What the answer in hand brought: `answer.alley`, in the transition of its option."""
