# SPDX-License-Identifier: Apache-2.0
"""A leaf that is a behaviour of py_trees, made by the user's program; missions in Python only."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar

from pydantic import Field, PlainSerializer, PlainValidator, WithJsonSchema

from rai_missions.errors import UsageError
from rai_missions.model import fault
from rai_missions.redaction import clipped
from rai_missions.states.tree.node import TreeNode

__all__ = ("ONLY_IN_PYTHON", "BehaviourLeaf", "Factory", "factory_name")

ONLY_IN_PYTHON = (
    "a behaviour in Python cannot be written as JSON, which holds no code; keep this mission in Python, or write the "
    "tree as data"
)

Factory = Callable[[], Any]
"""Makes a fresh `py_trees.behaviour.Behaviour`, with all that is below it."""


def factory_name(factory: Any) -> str:
    """What a factory is called in its program: `module.function`."""
    return f"{getattr(factory, '__module__', '?')}.{getattr(factory, '__qualname__', type(factory).__qualname__)}"


def _callable(given: Any) -> Any:
    if not callable(given):
        raise fault(
            "factory",
            f"{clipped(repr(given), 80)} cannot be called; give a function that makes a behaviour of py_trees",
        )
    return given


class BehaviourLeaf(TreeNode):
    """Reports what a live behaviour reports, which is ticked next to the mission every `tick_s` while this runs."""

    takes_time: ClassVar = True

    factory: Annotated[Any, PlainValidator(_callable), PlainSerializer(factory_name), WithJsonSchema({"not": {}})]
    """A function that makes a fresh behaviour of py_trees, with all that is below it."""
    tick_s: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 0.1
    """Seconds from one tick of the behaviour to the next."""

    def __init__(self, factory: Factory, tick_s: float = 0.1, *, name: str = "") -> None: ...

    def behaviour(self) -> BehaviourLeaf:
        return self

    def program(self) -> str:
        """The name of its factory."""
        return factory_name(self.factory)

    def words(self) -> str:
        return f"behaviour {factory_name(self.factory)}; ticked every {self.tick_s:g} s"

    def written(self) -> dict[str, Any]:
        """A mission in JSON holds no code.

        Raises:
            UsageError: Always.
        """
        raise UsageError(f"'{factory_name(self.factory)}': {ONLY_IN_PYTHON}")
