# SPDX-License-Identifier: Apache-2.0
"""A play as a pytest that gives a chart the same inputs, and asserts where each of them leads.

Rule: whatever comes of a mission, a person or a file is written as a Python literal, and as nothing else.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.replay.play.choice import Input, Passage
from rai_missions.replay.play.play import Click, Play

__all__ = ("PlaySource", "written_test")

LINE = 118
PLAIN = re.compile(r"[^\x20-\x7e\xa1-\u024f]")
"""What a comment of the test does not hold: what ends a line, or turns the reading direction."""


class PlaySource(NamedTuple):
    """The files that a play was made of."""

    mission: Path
    guards: Path | None = None


def written_test(play: Play, source: PlaySource, to: Path) -> str:
    """The text of a test module.

    Args:
        play: What was played.
        source: Its files; the test names them as they lie from its own folder.
        to: Where the test will be.

    Raises:
        UsageError: Nothing was played yet.
    """
    if not play.path:
        raise UsageError("nothing has been played yet; there is nothing to test")
    body = "\n".join(_body(play))
    used = {name for name in NAMES if re.search(rf"\b{name}\b", body)}
    return "\n".join([*_head(play, source, to, used), *_opened(play, source), body, ""])


NAMES: Mapping[str, str] = {
    "Event": "rai_missions", "Image": "rai_missions", "let_time_pass": "rai_missions.testing",
}  # fmt: skip
"""A name that a test may use → where it is imported from."""


def _head(play: Play, source: PlaySource, to: Path, used: set[str]) -> Iterator[str]:
    mission = play.mission
    yield f'"""A play of the mission {mission.name!r}, written by `rai-missions try --as-test`."""'
    yield ""
    if source.guards is not None:
        yield "import runpy"
    yield "from pathlib import Path"
    yield ""
    for module in ("rai_missions", "rai_missions.testing"):
        names = {name for name in used if NAMES[name] == module} | (
            {"Chart", "load"} if module == "rai_missions" else set()
        )
        if names:
            yield f"from {module} import {', '.join(sorted(names))}"
    yield ""
    yield f"MISSION = Path(__file__).parent / {_quoted(_relative(source.mission, to))}"
    if source.guards is not None:
        yield f"GUARDS = Path(__file__).parent / {_quoted(_relative(source.guards, to))}"
    yield ""
    yield ""


def _opened(play: Play, source: PlaySource) -> Iterator[str]:
    mission, end = play.mission, play.chart.outcome or "goes_as_played"
    more = ", named=runpy.run_path(str(GUARDS))" if source.guards is not None else ""
    yield f"def test_{mission.stem}_{end}() -> None:"
    yield f"    chart = Chart(load(MISSION){more})"


def _body(play: Play) -> Iterator[str]:
    for click in play.path:
        yield ""
        yield f"    # {_comment(click)}"
        for each in click.inputs:
            yield from _lines(f"    {_call(each)}", each)
        yield from _wrapped("    assert chart.active == ", sorted(click.active))
    outcome, why = play.chart.outcome, play.chart.why
    yield ""
    yield f"    assert chart.outcome {'is' if outcome is None else '=='} {_literal(outcome)}"
    if outcome is not None:
        yield f"    assert chart.why == {_literal(why)}"


def _lines(call: str, given: Input) -> Iterator[str]:
    """A call, and a long object that it writes with a field a line."""
    if len(call) <= LINE or isinstance(given, Passage) or given.kind != "write":
        yield call
        return
    value = given.data["value"]
    if not isinstance(value, Mapping):
        yield call
        return
    yield f"    chart.write({_quoted(given.name)}, {{"
    yield from (f"        {_literal(name)}: {_literal(each)}," for name, each in value.items())
    yield f"    }}, {given.at!r})"


def _comment(click: Click) -> str:
    """What was chosen, in one line, with the values that were given."""
    given = ", ".join(f"{name} {value}" for name, value in click.values.items())
    return PLAIN.sub(" ", f"{click.words}{f': {given}' if given else ''}")[: LINE - 6]


def _call(given: Input) -> str:
    if isinstance(given, Passage):
        but = f", but={_literal(given.but)}" if given.but else ""
        return f"list(let_time_pass(chart, {given.until!r}{but}))"
    name, at, data, kind, number = given
    if kind == "command" and name == "start":
        return f"chart.start({at!r})"
    if kind == "write":
        return f"chart.write({_quoted(name)}, {_literal(data['value'])}, {at!r})"
    if kind == "proposal" and "option" in data:
        more = f", {_literal(data['parameters'])}" if data.get("parameters") else ""
        return f"chart.propose({number}, {_quoted(data['option'])}{more}, at={at!r})"
    return f"chart.send({_event(given)})"


def _event(event: Event) -> str:
    name, at, data, kind, number = event
    more = [_literal(data)] if data or kind != "event" or number else []
    more += [_quoted(kind)] if kind != "event" or number else []
    more += [str(number)] if number else []
    return f"Event({', '.join([_quoted(name), repr(at), *more])})"


def _quoted(text: str) -> str:
    """A text as Python has it, in double quotes where it can be."""
    written = repr(text)
    return f'"{written[1:-1]}"' if written[0] == "'" and '"' not in written else written


def _literal(value: Any) -> str:
    """A value as Python has it.

    Raises:
        UsageError: It has no literal.
    """
    if isinstance(value, Image):
        sizes = f"{value.width}, {value.height}, {_quoted(value.encoding)}"
        return f"Image({_quoted(value.ref)}, {sizes}, bytes({len(value.data)}))"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_literal(name)}: {_literal(each)}" for name, each in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_literal, value)) + "]"
    if isinstance(value, str):
        return _quoted(value)
    if value is None or isinstance(value, int | float | bool):
        return repr(value)
    raise UsageError(f"a test cannot hold a value of type {type(value).__name__}")


def _wrapped(start: str, names: list[str]) -> Iterator[str]:
    """A set of names, on one line where it fits."""
    line = start + ("{" + ", ".join(map(_quoted, names)) + "}" if names else "frozenset()")
    if len(line) <= LINE:
        yield line
        return
    yield start + "{"
    yield from (f"        {_quoted(name)}," for name in names)
    yield "    }"


def _relative(path: Path, to: Path) -> str:
    return Path(os.path.relpath(path.resolve(), to.resolve().parent)).as_posix()
