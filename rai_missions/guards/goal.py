# SPDX-License-Identifier: Apache-2.0
"""Whether a goal is reached: `{"goal": "wanted", "over": "objects"}`; can be, or is what a request asks for.

Rule: what a key holds is judged by `planning`, by rule; a goal or a sight that cannot be read makes the guard unknown.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from importlib import import_module
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from rai_missions.errors import DefinitionError
from rai_missions.guards.analysis import Distinctions, OpenObject, Sources, TypeFault, Types
from rai_missions.guards.form import Atom, Form
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Operand, Site, Test, Truth, View
from rai_missions.model import KeyPath, Path, fault

__all__ = ("GoalAspect", "GoalIs", "judged")

GoalAspect = Literal["reached", "feasible", "said"]
"""What is asked of a goal."""
REACHED = '{"goal": "wanted", "over": "objects"}'
ASKED_FOR = '{"goal": "wanted", "is": "said", "in": "request"}'


class GoalIs(Guard, word="goal"):
    """True where a goal is reached by what the robot sees, can be reached by rule, or is what a request asks for.

    Unknown while the goal has no predicate, and where what is seen, or the request, is missing or stale. `reached` is
    unknown, too, where an object of the goal is not seen.
    """

    goal: Path
    """The goal: a key, or a field of one."""
    over: Path | None = None
    """What the robot sees; success rests on `reached` and `feasible` only if it is the robot's alone."""
    is_: GoalAspect = Field(default="reached", alias="is")
    """`reached`: each relation holds within its tolerance less two sigma of the camera, at rest, nothing in the
    gripper. `feasible`: there is a plan. `said`: each object, and each number, is in the request."""
    in_: Path | None = Field(default=None, alias="in")
    """The request, for `said`; with `over`, words are compared with the types and colours that are seen."""

    def __init__(
        self, goal: KeyPath, *, over: KeyPath | None = None, is_: GoalAspect = "reached", in_: KeyPath | None = None
    ) -> None: ...

    @model_validator(mode="after")
    def _judged_by_one(self) -> Self:
        if self.is_ == "said" and self.in_ is None:
            raise fault("goal", f"'in' is missing: the request that a goal is 'said' in; write {ASKED_FOR}")
        if self.is_ != "said" and (self.over is None or self.in_ is not None):
            raise fault("goal", f"a goal that is '{self.is_}' has 'over', what is seen, and no 'in'; write {REACHED}")
        return self

    def compile(self, site: Site) -> Test:
        import_module("rai_missions.planning.planner")  # before the run
        aspect, goal = self.is_, Operand(self.goal, site)
        over, request = (Operand(path, site) if path is not None else None for path in (self.over, self.in_))

        def test(view: View) -> Truth:
            wanted = goal.read(view)
            seen, text = (each.read(view) if each is not None else None for each in (over, request))
            if wanted is None or (over is not None and seen is None) or (request is not None and text is None):
                return None
            return judged(aspect, wanted, seen, text)

        return test

    def type_faults(self, types: Types) -> Iterator[TypeFault]:
        needed = (("goal", self.goal, "object"), ("over", self.over, "object"), ("in", self.in_, "string"))
        for word, path, right in needed:
            if path is not None and (given := types.kind(path)) not in (None, right):
                remedy = f"write {ASKED_FOR if self.in_ is not None else REACHED}"
                yield TypeFault(f"/{word}", f"'{path}' is of type '{given}', not '{right}'; {remedy}")

    def form(self, wanted: bool, depth: int) -> Form:
        return Atom("compare", f"<{self.is_} {self.goal} {self.over} {self.in_}>", "==", wanted)

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        return self.is_ != "said" and self.over is not None and sources.is_robots(self.over)

    def distinguish(self, by: Distinctions) -> None:
        for facts in filter(None, (self.in_, self.over)):
            by.judge(self.goal, facts, self.is_)

    def words(self) -> str:
        if self.is_ == "said":
            return f"{self.goal} is asked for in {self.in_}"
        return f"{self.goal} is {self.is_} over {self.over}"


@lru_cache(maxsize=256)
def _judge(aspect: str, wanted: str, seen: str, request: str) -> Truth:
    """Judges one aspect of a goal by the planner; all are JSON, for a guard is looked at more often than facts change.

    Planner and grammar are imported here, so that a mission without goals does without them.
    """
    from rai_missions.planning import Goal, feasible, reached, read_goal, read_scene

    try:
        goal, sight = read_goal(json.loads(wanted)), json.loads(seen)
        scene = None if sight is None else read_scene(sight)
    except DefinitionError:
        return None
    if not isinstance(goal, Goal):
        return None
    if aspect == "said":
        from rai_missions.planning.reading import is_said

        return is_said(goal, json.loads(request), scene)
    if scene is None:
        return None
    return reached(goal, scene) if aspect == "reached" else feasible(goal, scene) is None


def judged(aspect: str, wanted: Any, seen: Any, request: Any = None) -> Truth:
    """Whether a goal is reached or feasible by what is seen, or is in a request; unknown where one cannot be read.

    Args:
        aspect: A `GoalAspect`.
        wanted: A goal as plain data.
        seen: What is seen, as plain data, or a sight that judges by itself; for `said` it may be None.
        request: The request, for `said`.
    """
    if isinstance(seen, OpenObject):
        return seen.judge(aspect, wanted, request)
    if aspect == "said" and not isinstance(request, str):
        return None
    try:
        return _judge(aspect, json.dumps(wanted), json.dumps(seen), json.dumps(request))
    except (TypeError, ValueError, RecursionError):
        return None
