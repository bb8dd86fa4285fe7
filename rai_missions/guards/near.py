# SPDX-License-Identifier: Apache-2.0
"""Two poses within a distance: `{"near": ["pose", "goal"], "within_m": 0.5}`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field

from rai_missions.guards.analysis import Distinctions, Sources, TypeFault, Types
from rai_missions.guards.form import Atom, Form
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Operand, Site, Test, Truth, View
from rai_missions.model import KeyPath, Path, Seconds

__all__ = ("Near",)


class Near(Guard, word="near"):
    """True where two poses of one frame lie within a distance, in the three axes; the heading does not count."""

    near: tuple[Path, Path]
    """The two poses: keys, or fields of one."""
    within_m: Annotated[Seconds, Field(description="Metres.")]
    """The largest distance, in metres."""

    def __init__(self, near: tuple[KeyPath, KeyPath], within_m: float) -> None: ...

    def compile(self, site: Site) -> Test:
        here, there = (Operand(path, site) for path in self.near)

        def test(view: View) -> Truth:
            distance_m = distance(here.read(view), there.read(view))
            return None if distance_m is None else distance_m <= self.within_m

        return test

    def type_faults(self, types: Types) -> Iterator[TypeFault]:
        for index, path in enumerate(self.near):
            kind = types.kind(path)
            if kind not in (None, "pose", "object"):
                sentence = f"'{path}' is of type '{kind}', not 'pose'; 'near' measures between two poses"
                yield TypeFault(f"/near/{index}", sentence)
        frames = sorted({frame for path in self.near if (frame := types.frame(path))})
        if len(frames) > 1:
            sentence = f"the poses are given in different frames, {' and '.join(frames)}; bring them into one"
            yield TypeFault("/near", sentence)

    def form(self, wanted: bool, depth: int) -> Form:
        here, there = sorted(self.near)
        return Atom("compare", f"<near {here} {there}>", "<=" if wanted else ">", self.within_m)

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        return self.near[0] != self.near[1] and any(sources.is_robots(path) for path in self.near)

    def distinguish(self, by: Distinctions) -> None:
        by.measure(*self.near, self.within_m)

    def words(self) -> str:
        return f"{self.near[0]} within {self.within_m:g} m of {self.near[1]}"


def distance(here: Any, there: Any) -> float | None:
    """Metres between two poses; None where one is no pose or they are given in different frames."""
    if not isinstance(here, Mapping) or not isinstance(there, Mapping):
        return None
    if here.get("frame", "") != there.get("frame", ""):
        return None
    try:
        metres = math.dist(*([float(pose.get(axis, 0.0)) for axis in ("x", "y", "z")] for pose in (here, there)))
    except (TypeError, ValueError, OverflowError):
        return None
    return metres if math.isfinite(metres) else None
