# SPDX-License-Identifier: Apache-2.0
"""Starts by a mission's name, or without one where it is plain which is meant: `start the patrol with speed 3`."""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.conversation.grammar.arguments import BadValue, read_arguments
from rai_missions.conversation.grammar.names import missions_named
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.view import MissionView, StatusView

__all__ = ("MissionStarts",)


class MissionStarts:
    """Reads such starts in one language.

    Args:
        language: Its data.
        phrases: Which have the words for values.
    """

    def __init__(self, language: Language, phrases: StartPhrases) -> None:
        self._language, self._phrases = language, phrases

    def senses(self, words: list[str], view: StatusView) -> list[Sense]:
        """The one start that the words are, or what is wrong with it."""
        faults = list[Sense]()
        for slots in self._language.start.match(words):
            named = (slots.get("mission") or slots.get("called", "")).split()
            is_called = "called" in slots
            for sense in self._start(named, slots.get("arguments", "").split(), view, is_called=is_called):
                if sense.kind != "fault":
                    return [sense]
                faults.append(sense)
        return faults[:1]

    def _start(self, named: list[str], arguments: list[str], view: StatusView, *, is_called: bool) -> Iterator[Sense]:
        language = self._language
        offered = language.listed([spoken(each.name) for each in view.missions], "or")
        found = missions_named(named, view, language) if named else _own(view)
        if len(found) == 1:
            yield self._start_with(found[0], arguments)
        elif found or not named:
            text = "which_mission" if view.missions else "no_run"
            yield Sense("fault", "start", fault=language.text(text, missions=offered))
        elif is_called:
            yield Sense("fault", "start", fault=language.text("no_mission", given=" ".join(named), missions=offered))

    def _start_with(self, mission: MissionView, arguments: list[str]) -> Sense:
        try:
            values = read_arguments(
                arguments, mission.arguments, self._language, owner=mission.name, value=self._phrases.argument
            )
        except BadValue as error:
            lacks = (error.key,) if error.key else ()
            return Sense(
                "fault", "start", mission.name, error.others, fault=str(error), named=tuple(error.others), lacks=lacks
            )
        return Sense("order", "start", mission=mission.name, arguments=values, named=tuple(values))


def _own(view: StatusView) -> list[MissionView]:
    """The missions that are meant where none is named: the run's own, or the only one."""
    own = view.mission_named(view.mission)
    return list(view.missions) if own is None else [own]
