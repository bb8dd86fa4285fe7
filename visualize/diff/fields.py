# SPDX-License-Identifier: Apache-2.0
"""The fields of two written things of a kind, compared one by one.

Rule: a field that is not compared elsewhere is compared here, whatever it is; what is unclear counts as `safety`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Literal, NamedTuple

from rai_missions.guards.guard import Guard
from rai_missions.guards.implication import form, implies
from rai_missions.model import MissionModel, alike
from rai_missions.model.references import template_words
from rai_missions.plain_data import is_number
from rai_missions.states.decision import Budget, Option
from rai_missions.states.tree import TreeNode
from visualize.diff.change import Change, Severity
from visualize.diff.originals import AS_THEY_ARE, Originals
from visualize.text import child_pointer, effects

__all__ = (
    "FieldRef",
    "Relation",
    "as_words",
    "effects_changed",
    "fields",
    "guards",
    "relation",
    "reordered",
    "severity_if",
)

Relation = Literal["same", "weakened", "strengthened", "changed"]


def relation(old: Guard | None, new: Guard | None) -> Relation:
    """What became of a guard; none at all is always true."""
    before, after = form(old), form(new)
    down, up = implies(before, after), implies(after, before)
    if down and up:
        return "same"
    return "weakened" if down else "strengthened" if up else "changed"


LIMITS = (
    "timeout_s", "deadline_s", "max_age_s", "settle_s", "handover_s", "cancel_s", "ready_s", "within_s", "attempts",
    "calls", "tokens", "seconds", "num_failures", "duration_s",
)  # fmt: skip
"""What bounds something: to raise or to drop it loosens."""
PROOFS = ("requires", "achieved")
TOPIC_OF = {
    "control": "control", "source": "trust", "type": "trust", "frame": "trust", "fields": "trust",
    "on_cancel": "transition",
    "parameters": "asked", "initial": "form", "each": "form", "item": "form", "history": "form", "action": "does",
    "call": "does", "goal": "does", "request": "does", "result": "does", "message": "does", "publish": "does",
    "question": "asked", "evidence": "asked", "read": "does", "plan": "does", "over": "does", "into": "does",
}  # fmt: skip
"""Field → what a change of it is about; of another field of a tree's node `tree`, else `form`."""
TO_A_MODEL = ("question", "evidence")
"""What matters where a model is asked, and elsewhere is for people, who see more than that."""
WHEN_SET = {"over_orphan": "control", "optional": "trust"}
"""What loosens when it is reported, and tightens when it is not."""
APART = (
    "transitions", "states", "parallel", "decision", "tree", "options", "blackboard", "events", "invariants", "format",
    "entry", "exit",
)  # fmt: skip
"""Fields that are compared by hand."""


class FieldRef(NamedTuple):
    """Where two things that are compared are."""

    old: str
    """JSON pointer into the old mission."""
    new: str
    whose: str
    """How a sentence begins: `crossing`, `key 'battery'`."""
    subject: str = ""
    own: Originals = AS_THEY_ARE
    """Things of the old mission in their own words."""

    def inside(self, *words: str, whose: str = "") -> FieldRef:
        """A part of it."""
        old, new = (child_pointer(each, *words) for each in (self.old, self.new))
        return self._replace(old=old, new=new, whose=whose or self.whose)

    def changed(self, topic: str, sentence: str, severity: Severity, *, before: str = "", after: str = "") -> Change:
        return Change(
            "~", topic, f"{self.whose}: {sentence}", self.old, self.new, before, after, severity, self.subject
        )

    def came(self, topic: str, sentence: str, severity: Severity, *, after: str = "") -> Change:
        return Change("+", topic, f"{self.whose}: {sentence}", None, self.new, "", after, severity, self.subject)

    def went(self, topic: str, sentence: str, severity: Severity, *, before: str = "") -> Change:
        return Change("-", topic, f"{self.whose}: {sentence}", self.old, None, before, "", severity, self.subject)


def severity_if(yes: bool) -> Severity:
    return "safety" if yes else "other"


def fields(
    old: MissionModel,
    new: MissionModel,
    spot: FieldRef,
    also_apart: Sequence[str] = (),
    *,
    of: type[MissionModel] | None = None,
    asks_a_model: bool = False,
) -> Iterator[Change]:
    """What is otherwise in two models, but for what they hold of states, transitions and options.

    Args:
        old: As it was.
        new: As it is.
        spot: Where they are.
        also_apart: More fields that are compared by hand.
        of: The kind whose fields both have, where they are not of one.
        asks_a_model: They are what a model is asked, or part of it.
    """
    for name, field in (of or type(new)).model_fields.items():
        before, after = getattr(old, name), getattr(new, name)
        if name in APART or name in also_apart or alike(before, after) or _same_program(before, after):
            continue
        word = field.alias or name
        here = spot.inside(word)
        if isinstance(before, Guard) or isinstance(after, Guard):
            called = "guard" if word == "when" else word
            yield from guards(before, after, here, called, topic="proof" if name in PROOFS else "guard")
        elif isinstance(before, Budget) and isinstance(after, Budget):
            yield from fields(before, after, here)
        elif name in LIMITS:
            yield _limit(before, after, here, word, either=isinstance(new, TreeNode))
        else:
            own = getattr(spot.own.of(old), name)
            topic, severity = _weighed(name, new, after, asks_a_model=asks_a_model)
            yield here.changed(topic, f"'{word}' changed", severity, before=as_words(own), after=as_words(after))


def _weighed(name: str, new: MissionModel, after: Any, *, asks_a_model: bool) -> tuple[str, Severity]:
    """What a field is about, and whether a change of it is for a reviewer to judge."""
    if name in WHEN_SET:
        return WHEN_SET[name], severity_if(bool(after))
    if isinstance(new, Option) and name == "about":
        return ("asked" if asks_a_model else "words"), severity_if(asks_a_model)
    if name in TO_A_MODEL and not asks_a_model:
        return "words" if name == "question" else "rest", "other"
    if name == "about":
        return "words", "other"
    if name == "name":
        return "rest", "other"
    return TOPIC_OF.get(name, "tree" if isinstance(new, TreeNode) else "form"), "safety"


def reordered(before: Iterable[str], after: Iterable[str]) -> bool:
    """Whether the names that both have are in another order."""
    was, now = dict.fromkeys(before), dict.fromkeys(after)
    return [name for name in was if name in now] != [name for name in now if name in was]


def _same_program(before: Any, after: Any) -> bool:
    """A function is known by its name: that of a file which is loaded twice is not the same object."""
    names = [getattr(each, "__qualname__", None) for each in (before, after) if callable(each)]
    return len(names) == 2 and names[0] == names[1] is not None


def _limit(before: Any, after: Any, spot: FieldRef, word: str, *, either: bool) -> Change:
    """What became of a bound; `either`: to lower it may loosen as well, as in a tree that continues."""
    topic = "trust" if word == "max_age_s" else "limit"
    was, now = (_bound(value, word) for value in (before, after))
    grew = after is None or (before is not None and after > before)
    how = "removed" if after is None else "added" if before is None else "grew" if grew else "shrank"
    return spot.changed(topic, f"'{word}' {how}", severity_if(grew or either), before=was, after=now)


def _bound(value: float | None, word: str) -> str:
    unit = " s" if word.endswith("_s") or word in ("seconds", "timeout") else ""
    return "without a limit" if value is None else f"{as_words(value)}{unit}"


def guards(
    before: Guard | None,
    after: Guard | None,
    spot: FieldRef,
    called: str,
    *,
    topic: str = "guard",
    grave_if: Sequence[str] = ("weakened", "changed"),
) -> Iterator[Change]:
    """What became of a guard; `grave_if`: which of weakened, strengthened and changed a reviewer must judge."""
    how = relation(before, after)
    severity = severity_if(how in grave_if)
    topic = "transition" if how == "strengthened" and severity == "safety" else topic
    was = spot.own.of(before).words() if before is not None else "always"
    now = after.words() if after is not None else "always"
    if how != "same":
        less = "narrowed, it fires less often" if topic == "transition" and how == "strengthened" else how
        verb = "added" if before is None else "removed" if after is None else less
        yield spot.changed(topic, f"{called} {verb}", severity, before=was, after=now)
    elif before != after:
        yield spot.changed("rest", f"{called} written otherwise, means the same", "other", before=was, after=now)


def effects_changed(before: Any, after: Any, spot: FieldRef, word: str, why: Sequence[str]) -> Change:
    """What is done on the way is otherwise; `why` it matters to more than a reader."""
    was, now = as_words(spot.own.of(before)), as_words(after)
    because = f": {', '.join(dict.fromkeys(why))}" if why else ""
    topic = "effect" if why else "rest"
    return spot.changed(topic, f"'{word}' changed{because}", severity_if(bool(why)), before=was, after=now)


def as_words(value: Any) -> str:
    """A value as a list of changes has it: texts in quotes, effects in one line, `nothing` where there is none."""
    if isinstance(value, MissionModel):
        return template_words(value.written())
    if isinstance(value, tuple) and value and all(hasattr(item, "words") for item in value):
        return f"“{'; '.join(effects(value))}”"
    if value in (None, "", (), {}):
        return "nothing"
    if isinstance(value, tuple):
        return ", ".join(map(template_words, value))
    if is_number(value):
        return f"{value:g}"
    if callable(value):
        return str(getattr(value, "__qualname__", value))
    return f"“{value}”" if isinstance(value, str) else template_words(value)
