# SPDX-License-Identifier: Apache-2.0
"""What is seen as a whole, left open as far as no rule has asked: each question leaves those that answer it alike.

Rule: a sight is the set of the values that agree in all that was asked. A question is a field (`get`), what is asked of
a goal by the sight (`judge`, which `guards.goal.judged` calls), or an `all` or `any` of comparisons of its fields
(`find`). Every guard asks by one of these.

Why this loses no run, and adds none within a step: two values of a set differ only in what no guard has asked. A step
depends on a sight through the answers alone, so it is the same step for all values of the set; and each answer that
some value of the set gives is an alternative. So the ways of a step, chosen answer by answer, are those of all values,
chosen at once, without those that are the same way. Between steps `Abstraction` forgets answers that nothing that waits
asks for, as it does with the fields of other objects: a robot that reports another value of the set then changes
nothing now, so a run in which it does is a run of the mission. What can be reported in a state is one value for each
combination of answers to what is asked there.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import product
from typing import Any

from rai_missions.guards.analysis import OpenObject
from rai_missions.guards.goal import judged
from rai_missions.guards.view import Truth
from rai_missions.prove.abstraction.nondeterminism import OpenFields

__all__ = ("OpenSight", "Sights")


Answers = Sequence[tuple[Any, int]]


class Sights:
    """All that one key can show.

    Args:
        values: One of each kind that guards can distinguish.
        pick: Chooses one of several answers.
    """

    def __init__(self, values: Sequence[Mapping[str, Any]], pick: Callable[[Sequence[Any]], Any]) -> None:
        self.values, self.pick = values, pick
        self.fields = frozenset[str]().union(*values)
        self.about_goals: set[str] = set()
        """The questions about goals."""
        self._answers: dict[str, Answers] = {}

    def answers(self, question: str) -> Answers:
        """Each answer that a value gives, None for unknown, and which values give it."""
        found = self._answers.get(question)
        if found is None:
            found = self._answers[question] = _grouped(value.get(question) for value in self.values)
        return found

    def judge(self, aspect: str, wanted: Any, request: Any) -> str:
        """The question whether a goal is reached, feasible or asked for."""
        question = f"{aspect} {json.dumps([wanted, request], default=repr)}"
        self.about_goals.add(question)
        if question not in self._answers:
            found = {scene: judged(aspect, wanted, value, request) for scene, value in self._by_scene.items()}
            self._answers[question] = _grouped(found[scene] for scene in self._scenes)
        return question

    def ask(self, question: str, test: Callable[[Mapping[str, Any]], Any]) -> None:
        """Have a question answered by a test of a value."""
        if question not in self._answers:
            self._answers[question] = _grouped(test(value) for value in self.values)

    @cached_property
    def _scenes(self) -> Sequence[str]:
        """What goals are judged by, of each value."""
        from rai_missions.planning.scene import judged_by  # models of a scene; few missions have goals

        return [judged_by(value) for value in self.values]

    @cached_property
    def _by_scene(self) -> Mapping[str, Mapping[str, Any]]:
        return dict(zip(self._scenes, self.values, strict=True))

    def fitting(self, known: Mapping[str, Any]) -> int:
        """Which values give these answers; a bit for each."""
        every = (1 << len(self.values)) - 1
        for question, answer in known.items():
            alike = [bits for each, bits in self.answers(question) if each == answer and type(each) is type(answer)]
            every &= alike[0] if alike else 0
        return every

    def one_of(self, known: Mapping[str, Any]) -> Mapping[str, Any]:
        """Any value that gives these answers."""
        fitting = self.fitting(known)
        found: Mapping[str, Any] = self.pick([each for at, each in enumerate(self.values) if fitting >> at & 1])
        return found

    def first(self, fitting: int) -> dict[str, Any]:
        """The first of some values."""
        return dict(self.values[(fitting & -fitting).bit_length() - 1])

    def combinations(self, questions: Sequence[str]) -> Iterator[dict[str, Any]]:
        """Each combination of answers to these that some value gives."""
        for chosen in product(*map(self.answers, questions)):
            known = dict(zip(questions, (answer for answer, _ in chosen), strict=True))
            if self.fitting(known):
                yield known


class OpenSight(OpenFields, OpenObject):
    """A sight of which only what was asked is known.

    Args:
        sights: All that it can be.
    """

    def __init__(self, sights: Sights) -> None:
        super().__init__((), lambda question: (), sights.pick)
        self.sights = sights

    def get(self, field: str, default: Any = None) -> Any:
        self.looked.add(field)
        if not dict.__contains__(self, field):
            fitting, answers = self.sights.fitting(self), self.sights.answers(field)
            self[field] = self.sights.pick([answer for answer, bits in answers if bits & fitting])
        found = dict.get(self, field)
        return default if found is None else found

    def judge(self, aspect: str, wanted: Any, request: Any) -> Truth:
        found: Truth = self.get(self.sights.judge(aspect, wanted, request))
        return found

    def find(self, question: str, test: Callable[[Mapping[str, Any]], Truth]) -> Truth:
        self.sights.ask(question, test)
        found: Truth = self.get(question)
        return found

    def fresh(self, known: Mapping[str, Any] | None = None) -> OpenSight:
        made = OpenSight(self.sights)
        made.update(self if known is None else known)
        return made

    def mixtures(self) -> Iterator[OpenFields]:
        return (self.fresh(known) for known in self.sights.combinations(sorted(self)))

    def whole(self) -> dict[str, Any]:
        return dict(self.sights.one_of(self))

    def example(self) -> dict[str, Any]:
        return self.sights.first(self.sights.fitting(self))

    def words(self) -> str:
        if not self.sights.about_goals:
            return str(dict(self) if self.keys() <= self.sights.fields else self.example())
        return "seen so that " + ", ".join(f"{question}: {_plainly(answer)}" for question, answer in self.items())


def _grouped(answers: Iterable[Any]) -> Answers:
    found: dict[tuple[str, str], tuple[Any, int]] = {}
    for at, answer in enumerate(answers):
        place = type(answer).__name__, repr(answer)  # true is not 1 here
        found[place] = answer, found.get(place, (answer, 0))[1] | 1 << at
    return tuple(found.values())


def _plainly(answer: Any) -> str:
    return "unknown" if answer is None else json.dumps(answer)
