# SPDX-License-Identifier: Apache-2.0
"""Answers to questions of state: templates of the language, filled with what the run and the robot report.

Rule: nothing here comes from a model, and nothing is known that the `StatusView` does not have.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

from rai_missions.conversation.answers.build_answers import BUILD, build_sentence, knows_build
from rai_missions.conversation.answers.mentions import count_sentence, mention_sentences
from rai_missions.conversation.answers.places import place_named, place_sentence, place_words
from rai_missions.conversation.grammar.names import key_named, key_within, keys_about, keys_of_whereabouts
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.grammar.state_questions import ALWAYS
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.question_words import question_text
from rai_missions.conversation.language.run_words import control_text, end_text, goals_text
from rai_missions.conversation.language.values import (
    AGED_S,
    about_words,
    capital,
    duration,
    is_known,
    key_sentence,
    result_sentences,
    value_sentence,
    value_words,
)
from rai_missions.conversation.view import HappeningKind, KeyView, RunEvent, StatusView
from rai_missions.profile.conversation import NamedPlace

__all__ = ("Asker", "StateAnswers")

NOWHERE: Mapping[str, NamedPlace] = {}
SPEED = ("speed",)
"""The name of the key that reports how fast a robot is."""
MOST_CAUSES = 2
"""Lines of what came last, where it is asked why a mission stopped that runs."""
MOST_DECIDED = 2
"""Lines of an answer to "what was decided", or ordered."""
MOST_HAPPENINGS = 5
"""Lines of an answer to "what happened"."""


class Asker(NamedTuple):
    """What the dialogue knows of the one who asks, and of what waits."""

    orders: tuple[str, ...] = ()
    """What it ordered, in words, oldest first."""
    requests: tuple[str, ...] = ()
    """The requests that wait, in words."""
    may: tuple[str, ...] = ()
    """The orders that its role may give, in words."""
    stopping_by: str = ""
    """Who gave an order to stop, pause or cancel that the run has not taken yet; empty where there is none."""
    last_spoken: str = ""
    """What the robot spoke last, of the rules; empty before that."""
    last_end: str = ""
    """What was last reported at the end of a run; empty before the first end."""
    words: tuple[str, ...] = ()
    """Of the sentence that asks."""


def _poses(view: StatusView) -> list[KeyView]:
    """The poses that the robot reports, those that are fresh first, then the newest."""
    poses = [key for key in view.keys.values() if key.type == "pose" and key.source == "robot"]
    return sorted(poses, key=lambda key: (not key.is_fresh, key.value is None, key.is_fresh or key.age_s or 0.0))


class StateAnswers:
    """Answers questions of state in one language.

    Args:
        language: Its templates.
        starts: The sentences that start a mission.
        results: The keys whose values are the mission's result.
        places: The name of a place → where it is.
        asked_with: The evidence whose text is spoken with a question.
    """

    def __init__(
        self,
        language: Language,
        starts: StartPhrases,
        results: Sequence[str] = (),
        places: Mapping[str, NamedPlace] = NOWHERE,
        asked_with: Sequence[str] = (),
    ) -> None:
        self.language, self._starts, self._results = language, starts, results
        self._places, self._asked_with = places, asked_with
        self._by_name: Mapping[str, Callable[[StatusView, Asker], str]] = {
            "doing": self._doing,
            "progress": self._progress,
            "time_left": self._time_left,
            "where": self._where,
            "why_stopped": self._why_stopped,
            "waits": self._waits,
            "asked": self._asked,
            "ordered": self._ordered,
            "queued": self._queued,
            "places": self._known_places,
            "control": self._control,
            "capabilities": self._capabilities,
            "mission": self._about_mission,
            "happened": self._happened,
            "commanded": self._commanded,
            "result": self._result,
            "decided": self._decided,
            "who": self._who,
            "since": self._since,
            "repeat": self._repeat,
            **{name: partial(self._always, name) for name in ALWAYS},
            **{name: partial(self._of_build, name) for name in BUILD},
            "speed_now": self._speed_now,
        }

    def _always(self, name: str, *_: object) -> str:
        return self.language.text(name)

    def answer(self, sense: Sense, view: StatusView, asker: Asker = Asker()) -> str:  # noqa: B008 - a frozen value
        """The answer to a question of state.

        Args:
            sense: The question, of the kind `question`.
            view: The run at this moment.
            asker: The one who asks.
        """
        if sense.name == "key":
            return self._with_place(key_sentence(sense.key, view.keys, self.language), view.keys.get(sense.key))
        if sense.thing:
            counted = self._counted(sense.thing, view) if sense.name == "count" else ""
            return counted or self._where_is(sense.thing, view)
        if sense.name == "value":
            text = value_sentence(sense.key, view.keys, self.language)
            return text if is_known(sense.key, view.keys) else self._after(text, view, asker)
        facts = self._reported_of(asker.words, view) if self._lacks(sense.name, view) else ""
        return facts or self._by_name[sense.name](view, asker)

    def _lacks(self, name: str, view: StatusView) -> bool:
        """Whether the run reports nothing of what a question asks: a fact that its words name is better, then."""
        if name == "progress":
            return view.is_alive and not self._steps(view)
        return not _poses(view) if name == "where" else name in BUILD and not knows_build(name, view)

    def status(self, view: StatusView) -> str:
        """What the mission does now: its mode, its state with its `about`, how far it is, and what it waits for."""
        language = self.language
        if not view.mode:
            missions = language.listed([spoken(each.name) for each in view.missions], "or")
            return language.text("no_run_offer", missions=missions) if missions else language.text("no_run")
        if not view.is_alive:
            return self._ended(view)
        parts = [self._in_state(view), *([] if view.is_before_start else self._steps(view))]
        parts += [control_text(view, language), *self._waits_for_answers(view)]
        return " ".join(filter(None, parts))

    def _doing(self, view: StatusView, asker: Asker) -> str:
        return self._after(self.status(view), view, asker)

    def _after(self, text: str, view: StatusView, asker: Asker) -> str:
        """With what ended before; nothing is added to a run that has begun."""
        before = asker.last_end if view.is_before_start else ""
        return f"{text} {self.language.text('before', text=before)}" if before else text

    def _in_state(self, view: StatusView) -> str:
        mode = self.language.word("modes", view.mode)
        if not view.active:
            return self.language.text("mode", mission=spoken(view.mission), mode=mode)
        about = about_words(view.states.get(view.named_state, ""))
        values = {"mission": spoken(view.mission), "mode": mode, "state": spoken(view.named_state)}
        return self.language.text("mode_state_about" if about else "mode_state", **values, about=about)

    def _ended(self, view: StatusView) -> str:
        why = end_text(view, self.language)
        values = {"mission": spoken(view.mission), "mode": self.language.word("modes", view.mode), "why": why}
        text = self.language.text("ended_why" if why else "ended", **values)
        return f"{text} {goals_text(view, self.language)}".rstrip()

    def _steps(self, view: StatusView) -> list[str]:
        made = list[str]()
        for each in view.progress:
            if each.done is None:
                made.append(key_sentence(each.of, view.keys, self.language))
                continue
            numbers = {"done": f"{each.done:g}", "total": f"{each.total:g}"}
            made.append(self.language.text("progress", of=capital(self.language.name_of(each.of)), **numbers))
        return made

    def _waits_for_answers(self, view: StatusView) -> list[str]:
        return [self.language.text("waits_question", question=each.text) for each in view.questions]

    def _progress(self, view: StatusView, _: Asker) -> str:
        if not view.is_alive:
            return self.status(view)
        return " ".join(self._steps(view)) or f"{self.language.text('no_progress')} {self._in_state(view)}"

    def _time_left(self, view: StatusView, asker: Asker) -> str:
        text = self._progress(view, asker)
        return f"{self.language.text('no_time')} {text}" if view.is_alive else text

    def _where(self, view: StatusView, _: Asker) -> str:
        poses = _poses(view)
        if not poses:
            if paths := keys_of_whereabouts(view.keys, self.language):
                return " ".join(key_sentence(path, view.keys, self.language) for path in paths)
            where = self._in_state(view) if view.is_alive else ""
            return f"{self.language.text('no_position')} {where}".strip()
        key = poses[0]
        if key.value is None:
            return key_sentence(key.name, view.keys, self.language)
        value, age = value_words(key.value, key, self.language), duration(key.age_s or 0.0, self.language)
        if not key.is_fresh:
            return self.language.text("position_stale", name=spoken(key.name), value=value, age=age)
        value += self.language.text("age", age=age) if (key.age_s or 0.0) >= AGED_S else ""
        return self._with_place(self.language.text("position", name=spoken(key.name), value=value), key)

    def _where_is(self, thing: str, view: StatusView) -> str:
        bare = " ".join(self.language.without_articles(thing.split()))
        facts = " ".join(self.facts(thing.split(), view))
        return facts or self.language.text("not_mentioned", thing=bare or thing)

    def _counted(self, thing: str, view: StatusView) -> str:
        """How many entries of one list name a thing; empty where none has any."""
        return count_sentence(thing.split(), view, self.language, self._results)

    def nearest(self, words: Sequence[str], view: StatusView) -> str:
        """The facts that a question in free words is about; empty where it names none."""
        if path := key_within(words, view.keys, self.language):
            return key_sentence(path, view.keys, self.language)
        return self._reported_of(words, view)

    def _reported_of(self, words: Sequence[str], view: StatusView) -> str:
        facts = self._about(keys_about(words, view.keys, self.language), view)
        return self.language.text("nearest", facts=" ".join(facts)) if facts else ""

    def _about(self, paths: Sequence[str], view: StatusView) -> list[str]:
        return [key_sentence(path, view.keys, self.language) for path in paths]

    def facts(self, words: Sequence[str], view: StatusView) -> list[str]:
        """What is known of a thing: the place of that name, else the facts that name it, or are of it by their name."""
        place = place_named(words, self._places, self.language)
        if place is not None:
            poses = [key for key in _poses(view) if key.is_fresh and is_known(key.name, view.keys)]
            return [place_sentence(place, self._places[place], poses[0] if poses else None, self.language)]
        mentions = mention_sentences(words, view, self.language, self._results)
        return mentions or self._about(keys_about(words, view.keys, self.language, whole=True), view)

    def _with_place(self, text: str, key: KeyView | None) -> str:
        """With the place of a pose that is spoken."""
        if key is None or key.type != "pose" or not is_known(key.name, {key.name: key}):
            return text
        return f"{text} {place_words(key.value, key.frame, self._places, self.language)}".rstrip()

    def _why_stopped(self, view: StatusView, asker: Asker) -> str:
        if view.mode == "paused":
            return self._after(self._paused(view), view, asker)
        if view.is_before_start and asker.last_end:
            return self._doing(view, asker)
        if view.mode == "canceling" and view.mode_by:
            return self.language.text("canceling_by", by=view.mode_by)
        if view.is_alive and asker.stopping_by:
            return self.language.text("stopping_by", by=asker.stopping_by)
        if not view.is_alive or view.questions or control_text(view, self.language):
            return self.status(view)
        causes = [each for each in view.happened if each.kind != "entered"][-MOST_CAUSES:]
        return f"{self._in_state(view)} {self._lines(causes, view)}".rstrip()

    def _since(self, view: StatusView, asker: Asker) -> str:
        if not view.is_alive or (view.is_before_start and view.mode != "paused"):
            return self._doing(view, asker)
        parts = list[str]()
        if view.began is not None:
            ago = duration(view.at - view.began, self.language)
            parts.append(self.language.text("began", mission=spoken(view.mission), ago=ago))
        if view.mode == "paused":
            parts.append(self._paused(view))
        elif view.active and view.since is not None:
            time = duration(view.at - view.since, self.language)
            parts.append(self.language.text("since", state=spoken(view.named_state), time=time))
        return " ".join(parts) or self.status(view)

    def _repeat(self, view: StatusView, asker: Asker) -> str:
        return asker.last_spoken or self._doing(view, asker)

    def _paused(self, view: StatusView) -> str:
        if not view.mode_by:
            return self.language.text("paused")
        time = duration(view.at - (view.at if view.mode_since is None else view.mode_since), self.language)
        return self.language.text("paused_by", by=view.mode_by, time=time)

    def _waits(self, view: StatusView, _: Asker) -> str:
        language = self.language
        if view.questions and view.is_alive:
            return " ".join(self._waits_for_answers(view))
        if text := control_text(view, language):
            return text
        if view.mode == "ready":
            return language.text("waits_start")
        if view.mode == "paused":
            return language.text("waits_resume")
        if view.is_alive and view.active:
            return language.text("waits_state", state=spoken(view.named_state))
        return language.text("waits_nothing")

    def _asked(self, view: StatusView, _: Asker) -> str:
        if not view.questions:
            decided = self._decided(view, Asker()) if any(each.kind == "answered" for each in view.happened) else ""
            return f"{self.language.text('no_question')} {decided}".rstrip()
        return " ".join(question_text(each, self.language, self._asked_with) for each in view.questions)

    def _ordered(self, _: StatusView, asker: Asker) -> str:
        language = self.language
        orders = language.text("ordered", orders=language.listed(list(asker.orders)))
        text = orders if asker.orders else language.text("ordered_none")
        return f"{text} {self._queue(asker.requests)}" if asker.requests else text

    def _queued(self, view: StatusView, asker: Asker) -> str:
        text = self._queue(asker.requests) if asker.requests else self.language.text("queued_none")
        return f"{text} {self.status(view)}"

    def closed(self, view: StatusView) -> str:
        """The answer to one who answers a question that is closed."""
        return self.language.text("question_closed", decided=self._decided(view, Asker()))

    def _queue(self, requests: Sequence[str]) -> str:
        return self.language.text("queued", requests=self.language.listed(list(requests)))

    def _control(self, view: StatusView, _: Asker) -> str:
        plain = self.language.text("control", holder=self.language.word("holders", view.control))
        return control_text(view, self.language) or plain

    def _capabilities(self, view: StatusView, asker: Asker) -> str:
        language = self.language
        keys = [language.name_of(key.name) for key in view.keys.values() if key.source == "robot"]
        parts = [language.text("capabilities")]
        if keys:
            parts.append(language.text("capabilities_keys", keys=language.listed(keys)))
        if asker.may:
            parts.append(language.text("capabilities_orders", orders=language.listed(list(asker.may))))
        missions = [self._mission_line(each.name, each.about) for each in view.missions]
        if missions:
            parts.append(language.text("capabilities_missions", missions="; ".join(missions)))
        if examples := self._starts.examples(view.missions):
            parts.append(language.text("capabilities_starts", starts="; ".join(examples)))
        return " ".join(parts)

    def _mission_line(self, name: str, about: str) -> str:
        form = "mission_line_about" if about else "mission_line"
        return self.language.text(form, name=spoken(name), about=about_words(about))

    def _about_mission(self, view: StatusView, _: Asker) -> str:
        if not view.mission:
            return self.status(view)
        form = "mission_about" if view.about else "mission_no_about"
        return self.language.text(form, mission=spoken(view.mission), about=view.about)

    def _result(self, view: StatusView, asker: Asker) -> str:
        if asker.last_end and (view.is_before_start or not view.is_alive):
            return asker.last_end
        results = result_sentences(self._results, view.keys, self.language)
        return " ".join(results or [self.language.text("no_result"), self.status(view)])

    def _happened(self, view: StatusView, asker: Asker) -> str:
        text = self._lines(view.happened[-MOST_HAPPENINGS:], view) or self.language.text("happened_nothing")
        text = self._after(text, view, asker)
        return f"{text} {self._ended(view)}" if view.has_ended else text

    def _decided(self, view: StatusView, _: Asker) -> str:
        return self._last(view, "answered") or (
            f"{self.language.text('decided_none')} {self._last(view, 'command')}".rstrip()
        )

    def _commanded(self, view: StatusView, asker: Asker) -> str:
        return self._last(view, "command") or self._happened(view, asker)

    def _last(self, view: StatusView, kind: HappeningKind) -> str:
        return self._lines([each for each in view.happened if each.kind == kind][-MOST_DECIDED:], view)

    def _known_places(self, *_: object) -> str:
        places = self.language.listed(list(self._places))
        return self.language.text("places", places=places) if places else self.language.text("no_places")

    def _lines(self, events: Sequence[RunEvent], view: StatusView) -> str:
        lines = "; ".join(self._line(each, view) for each in events)
        return self.language.text("happened", lines=lines) if lines else ""

    def _line(self, happening: RunEvent, view: StatusView) -> str:
        template: str = self.language.data["happenings"][happening.kind]
        table = {"control": "holders", "ended": "modes", "command": "commands"}.get(happening.kind)
        name = self.language.word(table, happening.name) if table else spoken(happening.name)
        about = self.language.text("about", about=about_words(happening.about)) if happening.about else ""
        by = self.language.word("answerers", happening.by) if happening.kind == "answered" else happening.by
        by = self.language.text("by", by=by) if by else ""
        return template.format(ago=duration(view.at - happening.at, self.language), name=name, about=about, by=by)

    def knows(self, sense: Sense, view: StatusView) -> bool:
        """Whether a question has an answer; one of the build, or about a thing, only where that is known."""
        if sense.thing:
            return bool(self.facts(sense.thing.split(), view))
        return sense.name not in BUILD or knows_build(sense.name, view)

    def _of_build(self, name: str, view: StatusView, _: Asker) -> str:
        return build_sentence(name, view, self.language)

    def _speed_now(self, view: StatusView, _: Asker) -> str:
        """The key that reports it; where there is none, that it is not reported, and the limit."""
        path = key_named(SPEED, view.keys, self.language, strict=True)
        if path:
            return key_sentence(path, view.keys, self.language)
        return self.language.text("speed_now", speed=build_sentence("speed", view, self.language))

    def _who(self, view: StatusView, _: Asker) -> str:
        if not view.robot:
            return self.language.text("who_none")
        form = "who" if view.identity else "who_only"
        return self.language.text(form, robot=view.robot, identity=view.identity)
