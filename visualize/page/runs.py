# SPDX-License-Identifier: Apache-2.0
"""Journals as the page plays them: a row a step, each with what it changed alone.

Rule: nothing is worked out again. What the page shows of a step was in the journal, and what cannot be read is
reported.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rai_missions.engine.decision import Question
from rai_missions.engine.description import describe
from rai_missions.engine.known import known_from
from rai_missions.engine.step import Ask, Step, step_count
from rai_missions.errors import DefinitionError
from rai_missions.image import Image
from rai_missions.journal import Note, StepRow, verify
from rai_missions.journal.reader import Record
from rai_missions.keys import Key
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.states import answerer_words
from visualize.page.as_json import Json, Pool, without_empty
from visualize.page.images import Gallery
from visualize.page.rejected_options import Offers

__all__ = ("Run", "read_run", "run_data", "run_of_steps")

MOST_FAULTS = 20
Writes = list[tuple[str, Any, float]]


@dataclass(frozen=True)
class Run:
    """A run as far as it can be reported."""

    name: str
    """What the reader knows it by: its file."""
    mission: str = ""
    """The mission that ran, as row 0 has it."""
    head: Json | None = None
    """Id, start time, arguments and versions."""
    entries: tuple[StepRow, ...] = ()
    notes: tuple[Note, ...] = ()
    faults: tuple[str, ...] = ()
    """What is wrong with the journal, or keeps it from fitting the mission."""

    @property
    def steps(self) -> tuple[Step, ...]:
        """What the run did, in order."""
        return tuple(entry.step for entry in self.entries)


def run_of_steps(steps: Iterable[Step]) -> Run:
    """A run of steps that no journal holds."""
    steps = tuple(steps)
    return Run("the run", entries=tuple(StepRow(number, step, step.at) for number, step in enumerate(steps, 1)))


def read_run(path: Path | str, gallery: Gallery, *, name: str = "") -> Run:
    """A journal up to where it can be read, with all that is wrong with it; its questions' pictures go to the gallery.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal.
    """
    faults = [f"{fault.place}: {fault.sentence}".lstrip(": ") for fault in verify(path)]
    entries: list[StepRow] = []
    notes: list[Note] = []
    head: Json = {}
    mission = ""
    with closing(Record(path)) as record:
        try:
            header = record.header
            mission = header.mission
            head = {name: plain(item) for name, item in header._asdict().items() if name not in ("mission", "profile")}
            for row in record.rows():
                if isinstance(row, StepRow):
                    entries.append(row)
                    _keep_images(row.step, gallery)
                elif isinstance(row, Note):
                    notes.append(row)
        except DefinitionError as error:
            if not entries and not faults:
                raise
            faults += [str(fault) for fault in error.faults if str(fault) not in faults]
    return Run(name or Path(path).name, mission, head, tuple(entries), tuple(notes), tuple(faults[:MOST_FAULTS]))


def _keep_images(step: Step, gallery: Gallery) -> None:
    questions = (effect.question for effect in step.effects if isinstance(effect, Ask))
    for shown in (each for question in questions for each in question.evidence):
        if isinstance(shown.value, Image):
            gallery.add(shown.value)


def run_data(run: Run, gallery: Gallery, mission: Mission | None = None) -> Json:
    """A run as the page plays it.

    Args:
        run: As it was read.
        gallery: Takes the pictures of its questions.
        mission: The one that ran, for why options were not offered; none where that is not sure.

    A step is `[number, time, event, moves, guards, writes, more]`; from the event on, numbers of values in `pool`.
    """
    pool = Pool()
    questions: dict[int, Json] = {}
    steps = []
    offers = Offers(mission) if mission is not None else None
    keys = mission.blackboard if mission is not None else {}
    for index, entry in enumerate(run.entries):
        writes = _writes(entry, keys)
        steps.append(_row(index, entry.step, writes, pool=pool, questions=questions, gallery=gallery))
        if offers is not None:
            offers.follow(entry.step, writes)
            _add_withheld(entry.step, questions, offers)
    return {
        "name": run.name,
        "head": run.head or {},
        "faults": list(run.faults),
        "pool": pool.values,
        "steps": steps,
        "count": step_count(run.steps),
        "questions": list(questions.values()),
        "notes": [[note.row, note.text, plain(note.data)] for note in run.notes],
        "outcome": next((step.outcome for step in run.steps if step.outcome), ""),
        "why": next((step.why for step in run.steps if step.outcome), ""),
    }


def _row(
    index: int, step: Step, writes: Writes, *, pool: Pool, questions: dict[int, Json], gallery: Gallery
) -> list[Any]:
    written = [[key, plain(value), round(stamp, 6)] for key, value, stamp in writes]
    guards = list({place: {True: 1, False: 0, None: 2}[value] for place, value in step.guards}.items())
    moves = [[list(move.taken), list(move.exited), list(move.entered), move.trigger] for move in step.moves]
    for effect in step.effects:
        if isinstance(effect, Ask):
            questions[effect.question.number] = _question(effect.question, index, gallery)
    judged: list[str] = []
    if step.event.kind == "proposal" and step.event.number in questions:
        answer = _answer(step, index)
        questions[step.event.number] |= answer
        judged = answer["verdict"]
    described = describe(step)
    more = {
        "does": list(described.effects),
        "notes": [each for each in (*described.verdicts, *described.remarks) if each not in judged],
        "why": step.why,
        "outcome": step.outcome,
        "asks": [effect.question.number for effect in step.effects if isinstance(effect, Ask)],
        "answers": step.event.number if step.event.kind == "proposal" else 0,
    }
    event = without_empty(
        {
            "name": step.event.name,
            "kind": step.event.kind,
            "number": step.event.number,
            "data": plain(step.event.data),
        }
    )
    parts = (event, moves, [[place, value] for place, value in guards], written, without_empty(more))
    return [step.seq, round(step.at, 6), *(pool.add(part) for part in parts)]


def _writes(entry: StepRow, keys: Mapping[str, Key]) -> Writes:
    """Key, value and stamp of what is known since the step before, in order; None for what is no longer known."""
    return [*entry.before, *known_from(entry.step, keys)]


def _add_withheld(step: Step, questions: dict[int, Json], offers: Offers) -> None:
    for effect in step.effects:
        if isinstance(effect, Ask) and (withheld := offers.withheld(effect.question)):
            questions[effect.question.number]["withheld"] = withheld


def _question(question: Question, index: int, gallery: Gallery) -> Json:
    shown = []
    for each in question.evidence:
        picture = gallery.add(each.value) if isinstance(each.value, Image) else ""
        shown.append(
            without_empty({"key": each.key, "fresh": each.fresh, "picture": picture})
            | {"value": plain(each.value), "age_s": plain(each.age_s)}
        )
    return without_empty(
        {
            "owner": question.owner,
            "asked": question.asked,
            "whom": answerer_words(question.asked),
            "text": question.text,
            "options": [
                without_empty({"name": offer.name, "about": offer.about, "parameters": plain(offer.parameters)})
                for offer in question.options
            ],
            "attempt": question.attempt,
            "refused": list(question.refused),
            "tools": list(question.tools),
        }
    ) | {"number": question.number, "step": index, "at": question.at, "until": plain(question.until), "evidence": shown}


def _answer(step: Step, index: int) -> Json:
    """What was proposed, and how the rules judged it."""
    described = describe(step)
    judged = described.verdicts or ((step.why,) if step.why else described.remarks)
    return {
        "answered": index,
        "proposal": plain(step.event.data),
        "verdict": list(judged) or ["it changed nothing"],
    }
