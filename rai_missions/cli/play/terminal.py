# SPDX-License-Identifier: Apache-2.0
"""A play at the terminal: what can happen now, numbered, and a line of input for each thing that does.

Rule: what can be typed can be piped; where no person is at the keyboard, the first line at fault ends the play.
"""

from __future__ import annotations

import shlex
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

from rai_missions.cli.play.session import PlaySession
from rai_missions.cli.progress import trimmed, value_words
from rai_missions.engine.description import describe
from rai_missions.engine.step import Step
from rai_missions.errors import MissionError, UsageError, suggestion
from rai_missions.replay.play import Click, Field, PlayChoice
from rai_missions.replay.play.choice import ChoiceKind
from rai_missions.replay.play.fields import read_text
from rai_missions.states.control import CONTROLLERS
from rai_missions.states.decision import answerer_words

__all__ = ("TerminalPlay",)

HELP = """\
NUMBER or NAME [VALUE …]  let that happen; values as VALUE or FIELD=VALUE, else as suggested
u [COUNT]                 undo; what you do then continues from there
t SECONDS                 time passes; the robot's facts stay fresh
n                         time passes until something changes
s [FILE]                  save the play as a journal
test FILE                 write the play as a pytest
m                         what seldom happens, too
q                         quit"""
WIDTH = 100
GROUPS: Mapping[str, tuple[ChoiceKind, ...]] = {
    "what runs": ("goal", "call", "behaviour"), "events": ("event",), "time": ("time",),
    "the operator, and control": ("command", "control"),
}  # fmt: skip
"""A title → the kinds of choices under it; what is awaited comes before them, facts come after, and what is rare last.
"""

LEAVING = ("q", "quit", "exit")
SAME = {"help": "?", "h": "?", "undo": "u", "wait": "t", "save": "s", "more": "m"}
"""What is typed before `?` was read → the order that is meant."""


class TerminalPlay:
    """A play, line by line.

    Args:
        session: The play and its files.
        lines: What is typed.
        out: Where it is shown.
        is_person: Someone is at the keyboard: values are asked for, and a line at fault is asked again.
    """

    def __init__(self, session: PlaySession, lines: TextIO, out: TextIO, *, is_person: bool) -> None:
        self._session, self._lines, self._out, self._is_person = session, lines, out, is_person
        self._shows_rare = False
        self._orders: Mapping[str, Callable[[Sequence[str]], None]] = {
            "u": self._undo,
            "t": self._wait,
            "n": lambda words: self._do("next", {}),
            "s": self._save,
            "test": self._write_test,
            "m": self._more,
            "?": lambda words: self._help(),
        }

    def run(self) -> None:
        """Play until the input ends, or `q`.

        Raises:
            UsageError: A line is at fault, and no person can mend it.
        """
        mission = self._session.play.mission
        self._print(f"{mission.name} {mission.version}: {trimmed(mission.about)}".rstrip(": "))
        self._print("You are the robot, and everyone else. ? lists what can be typed.")
        self._show()
        while (line := self._ask("> ")) is not None and line not in LEAVING:
            if not line:
                continue
            try:
                self._take(line)
            except MissionError as error:
                if not self._is_person:
                    raise
                self._print(f"! {error}")

    def _take(self, line: str) -> None:
        word, _, rest = line.partition(" ")
        word = SAME.get(word, word)
        if word in self._orders:
            self._orders[word](_split(rest))
            return
        choice, rest = self._found(line)
        self._do(choice.name, self._values(choice, _split(rest)))

    def _found(self, line: str) -> tuple[PlayChoice, str]:
        """The choice that a line begins with, by its number or name, and what follows."""
        word, _, rest = line.partition(" ")
        choices = self._ordered()
        if word.isascii() and word.isdigit() and len(word) < 6:
            number = int(word)
            if not 1 <= number <= len(choices):
                raise UsageError(f"there is no choice {number}; there are {len(choices)}")
            return choices[number - 1], rest
        named = [each for each in choices if line == each.name or line.startswith(f"{each.name} ")]
        if not named:
            near = suggestion(line, [*self._orders, *(each.name for each in choices)])
            more = "" if near.endswith("?") else "; ? lists what can be typed"
            raise UsageError(f"'{trimmed(line, 60)}' cannot happen now, and is no order{near}{more}")
        found = max(named, key=lambda each: len(each.name))
        return found, line[len(found.name) :].strip()

    def _values(self, choice: PlayChoice, given: Sequence[str]) -> dict[str, Any]:
        if not given and self._is_person and choice.kind != "start":
            return dict(self._asked(choice.fields))
        values: dict[str, Any] = {}
        for index, word in enumerate(given):
            name, sign, text = word.partition("=")
            field = _field(choice.fields, name) if sign else None
            if field is None:
                if index >= len(choice.fields):
                    raise UsageError(f"'{choice.words}' takes {len(choice.fields)} values, and '{word}' is one more")
                field, text = choice.fields[index], word
            values[field.name] = read_text(field, text)
        return values

    def _asked(self, fields: Sequence[Field]) -> Iterator[tuple[str, Any]]:
        for field in fields:
            among = f" ({', '.join(map(_shown, field.among))})" if field.among else f" ({field.type})"
            shown = "" if field.suggested is None else f" [{_shown(field.suggested)}]"
            text = self._ask(f"  {field.name}{among}{shown}: ")
            if text:
                yield field.name, read_text(field, text)

    # -- orders ---------------------------------------------------------------------------------------------------

    def _do(self, name: str, values: Mapping[str, Any]) -> None:
        click = self._session.play.do(name, values)
        self._print("")
        for line in _happened(click):
            self._print(line)
        self._show()

    def _undo(self, words: Sequence[str]) -> None:
        count = words[0] if words else "1"
        if not count.isascii() or not count.isdigit():
            raise UsageError(f"'u {count}': give how many, as in u 2")
        self._session.play.undo(int(count))
        self._show()

    def _wait(self, words: Sequence[str]) -> None:
        try:
            seconds = float(words[0]) if words else 1.0
        except ValueError:
            raise UsageError(f"'t {words[0]}': give seconds, as in t 5") from None
        self._do("time", {"seconds": seconds})

    def _save(self, words: Sequence[str]) -> None:
        for line in self._session.save(Path(words[0]) if words else None):
            self._print(line)

    def _write_test(self, words: Sequence[str]) -> None:
        if not words:
            raise UsageError("name the file of the test, as in: test test_play.py")
        self._print(self._session.write_test(Path(words[0])))

    def _more(self, words: Sequence[str]) -> None:
        self._shows_rare = not self._shows_rare
        self._show()

    def _help(self) -> None:
        self._print(HELP)
        self._print_listed("names now", [choice.name for choice in self._ordered()])

    # -- what is shown --------------------------------------------------------------------------------------------

    def _show(self) -> None:
        chart = self._session.play.chart
        inner = [node.name for node in chart.state.config.atomic]
        where = ", ".join(inner) if inner else "not started"
        held = f" (held by {chart.held_by})" if chart.held_by else ""
        self._print(
            f"\n── {chart.at:g} s · {chart.mode} · {where} · control: {CONTROLLERS[chart.holder]}{held} " + "─" * 8
        )
        for question in chart.questions:
            left = f", {question.until - chart.at:.3g} s left" if question.until != float("inf") else ""
            self._print(f"? {answerer_words(question.asked)} is asked: {trimmed(question.text)}{left}")
            for shown in question.evidence:
                self._print(f"    {trimmed(shown.words())}")
        if chart.outcome is not None:
            self._print(f"the mission ended {chart.outcome}: {trimmed(chart.why)}")
        numbered = list(enumerate(self._ordered(), 1))
        self._list("the mission waits for", [each for each in numbered if each[1].is_awaited])
        common = [each for each in numbered if not (each[1].is_awaited or each[1].is_rare)]
        for title, kinds in GROUPS.items():
            self._list(title, [each for each in common if each[1].kind in kinds])
        self._facts([each for each in common if each[1].kind in ("key", "stale")])
        rare = [each for each in numbered if each[1].is_rare]
        if rare and self._shows_rare:
            self._list("seldom", rare)
        elif rare:
            self._print(f"seldom: {len(rare)} more (m shows them)")

    def _ordered(self) -> list[PlayChoice]:
        """What can happen now, in the order in which it is shown."""
        ranks = {kind: rank for rank, kinds in enumerate(GROUPS.values(), 1) for kind in kinds}

        def rank(choice: PlayChoice) -> tuple[bool, int, bool]:
            here = 0 if choice.is_awaited else ranks.get(choice.kind, len(GROUPS) + 1)
            return choice.is_rare, here, choice.kind == "stale"

        return sorted(self._session.play.choices(), key=rank)

    def _list(self, title: str, choices: Sequence[tuple[int, PlayChoice]]) -> None:
        if not choices:
            return
        self._print(f"{title}:")
        for number, choice in choices:
            takes = ", ".join(_takes(field) for field in choice.fields)
            more = [choice.about, f"values: {takes}" if takes and choice.kind != "start" else ""]
            more += [f"would be refused: {choice.refused}" if choice.refused else ""]
            self._print(f"{number:4} {trimmed('; '.join([choice.words, *filter(None, more)]))}")

    def _facts(self, choices: Sequence[tuple[int, PlayChoice]]) -> None:
        chart = self._session.play.chart
        values = [each for each in choices if each[1].kind == "key"]
        if values:
            self._print("facts, each given by NUMBER VALUE:")
        for number, choice in values:
            entry = chart.view.board.get(choice.key)
            age_s = 0.0 if entry is None else max(0.0, chart.at - entry.at)
            now = "unknown" if entry is None else f"{value_words(entry.value, 60)}, {age_s:.3g} s old"
            self._print(f"{number:4} {choice.key} ({now})")
        stale = [f"{number} {choice.key}" for number, choice in choices if choice.kind == "stale"]
        self._print_listed("to let one go stale", stale)

    def _ask(self, prompt: str) -> str | None:
        """A line of input; None at its end."""
        print(prompt, end="", file=self._out, flush=True)
        line = self._lines.readline()
        if not self._is_person:
            print(line.rstrip("\n"), file=self._out)
        elif not line:
            print(file=self._out)
        return line.strip() if line else None

    def _print_listed(self, title: str, items: Sequence[str]) -> None:
        """Items after a title, in lines that break between two of them; nothing where there are none."""
        if items:
            text = f"{title}: " + ", ".join(item.replace(" ", "\xa0") for item in items)
            for line in textwrap.wrap(text, WIDTH, subsequent_indent="     ", break_long_words=False):
                self._print(line.replace("\xa0", " "))

    def _print(self, text: str) -> None:
        print(text, file=self._out)


def _split(text: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError as error:
        raise UsageError(f"{trimmed(text, 60)}: {error}") from None


def _field(fields: Sequence[Field], name: str) -> Field | None:
    """The field of a name, or of the last part of one, where no other ends so."""
    ends = [field for field in fields if name in (field.name, field.name.rpartition(".")[2])]
    return ends[0] if len(ends) == 1 else None


def _takes(field: Field) -> str:
    return f"{field.name} {'|'.join(map(_shown, field.among)) if field.among else field.type}"


def _shown(value: Any) -> str:
    return "true" if value is True else "false" if value is False else value_words(value, 60)


def _happened(click: Click) -> Iterator[str]:
    """What came of a choice, a line each."""
    yield f"{click.words}:"
    lines = [trimmed(line) for step in click.steps for line in _step_lines(step) if line]
    yield from (f"  {line}" for line in lines or ["nothing else changed"])


def _step_lines(step: Step) -> Iterator[str]:
    described = describe(step)
    yield described.way
    yield from described.notes
    yield from (f"→ {each}" for each in described.effects)
    yield described.why
