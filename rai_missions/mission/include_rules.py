# SPDX-License-Identifier: Apache-2.0
"""What a mission may include: which files, under which names, and what an included mission cannot have.

Rule: a file is named by the mission that includes it and lies in the folder of the outermost one, links followed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.errors import DefinitionError, Fault, irregular, pointer, suggestion
from rai_missions.keys import Key, type_error
from rai_missions.mission.mission import Mission
from rai_missions.mission.option_parameters import listed_parameters
from rai_missions.model.references import reference_word, template_paths
from rai_missions.redaction import shown
from rai_missions.states import DecisionSpec, Include
from rai_missions.states.transition import ANY_EVENT

__all__ = ("Chain", "included_file", "inclusion_faults", "questions", "refused", "shared_key")

MAX_INCLUSIONS = 16
"""Missions inside each other."""


class Chain(NamedTuple):
    """The place of an inclusion: the files that led to it, and what all of them have brought so far."""

    files: tuple[Path, ...]
    """Outermost first."""
    total: dict[str, int]
    """States and bytes of everything included, counted as often as it is."""
    faulty: set[Path]
    """The included files whose faults are reported."""

    @property
    def folder(self) -> Path:
        """What may be included lies in here."""
        return self.files[0].parent

    def named(self, file: Path) -> str:
        """A file as a reader of the top mission knows it."""
        return str(file.relative_to(self.folder))


def included_file(written: str, chain: Chain) -> Path:
    """The file that an inclusion names, if it may be included."""
    here = chain.files[-1]
    if "\0" in written or "\\" in written or Path(written).is_absolute() or not written.endswith(".json"):
        raise refused(f"{shown(written)} cannot be included; name a .json file relative to this one, with '/'")
    try:
        file = (here.parent / written).resolve()
        found = file.is_relative_to(chain.folder) and _is_there(file)
    except (OSError, RuntimeError):  # a name too long, links in a circle, which Python 3.13 finds by `stat` alone
        raise refused(f"{shown(written)} cannot be opened; name a .json file") from None
    if not file.is_relative_to(chain.folder):
        raise refused(f"{shown(written)} lies outside the mission's folder; put it inside")
    if not found:
        raise refused(f"there is no file {shown(written)}{suggestion(written, _near(written, here))}")
    if sort := irregular(file):
        raise refused(f"{shown(written)} is {sort}; name a .json file")
    if file in chain.files:
        circle = " → ".join(chain.named(each) for each in (*chain.files[chain.files.index(file) :], file))
        raise refused(f"a mission cannot include itself: {circle}; break the circle")
    if len(chain.files) > MAX_INCLUSIONS:
        raise refused(f"more than {MAX_INCLUSIONS} missions inside each other; include less deeply")
    return file


def _near(written: str, here: Path) -> Iterator[str]:
    """The files that an inclusion may mean: those next to the one it names, and next to its own."""
    for folder in dict.fromkeys((Path(written).parent, Path())):
        for each in sorted((here.parent / folder).glob("*.json")):
            if each != here:
                yield (folder / each.name).as_posix()


def _is_there(file: Path) -> bool:
    """Whether there is a file; an `OSError` where that cannot be known."""
    try:
        file.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    return True


def refused(sentence: str) -> DefinitionError:
    """One fault of the file that an inclusion names."""
    return DefinitionError([Fault("/mission", sentence)])


def inclusion_faults(include: Include, inner: Mission, parent: Mission) -> Iterator[Fault]:
    """The faults of an inclusion, with places from the inclusion on."""
    yield from _unmapped(include, inner, parent)
    yield from _unfit(include, inner, parent)


def _unmapped(include: Include, inner: Mission, parent: Mission) -> Iterator[Fault]:
    """The faults of `with`."""
    for word, given in include.with_.items():
        place = pointer(("with", word))
        if word in inner.blackboard:
            yield from (Fault(place, why) for why in _key_faults(inner.blackboard[word], given, parent))
        elif word in inner.events:
            if not isinstance(given, str):
                yield Fault(place, f"'{word}' is an event; give the name of one of this mission's, not {shown(given)}")
            elif given not in parent.events:
                yield Fault(place, f"no event {shown(given)}{suggestion(given, parent.events)}")
        else:
            known = suggestion(word, (*inner.blackboard, *inner.events))
            yield Fault(place, f"{shown(include.mission)} has no key or event '{word}'{known}")


def _key_faults(key: Key, given: Any, parent: Mission) -> Iterator[str]:
    name = shared_key(given)
    if name is None:
        if key.source in ("robot", "answer"):
            yield f'a key of the {key.source} takes no value; share one of this mission\'s: {{"from": key}}'
        elif any(template_paths(given)):
            yield 'a reference inside a value is not followed; share a whole key: {"from": key}'
        elif why := type_error(key, given, written=True):
            is_key = isinstance(given, str) and given in parent.blackboard
            yield f'{why}; to share the key, write {{"from": "{given}"}}' if is_key else why
    elif name not in parent.blackboard:
        yield f"no key {shown(name)}{suggestion(name, parent.blackboard)}"
    elif (theirs := parent.blackboard[name].type) != key.type and (theirs, key.type) != ("integer", "number"):
        yield f"'{name}' is of type '{theirs}', not '{key.type}'; share a key of that type"


def shared_key(given: Any) -> str | None:
    """The parent's key that `{"from": key}` shares."""
    return str(given["from"]) if reference_word(given) is not None else None


def _unfit(include: Include, inner: Mission, parent: Mission) -> Iterator[Fault]:
    """What the included mission has that it cannot have as a part of another."""
    for asked in questions(inner):
        for option in asked.options:
            if option in parent.events:
                yield Fault("/mission", f"its option '{option}' is also an event of this mission; rename one of them")
    yield from (Fault("/mission", why) for why in _captured(inner, parent))
    for place, transition in inner.every_transition():
        if ANY_EVENT in transition.on and not inner.events:
            yield Fault(
                "/mission", f"its transition {place} is for any event, and it declares none; drop the transition"
            )
    for invariant, guard in inner.invariants.items():
        if any(each.age_s is not None for each in guard.walk()):
            why = "asks for 'elapsed_s', which would count from the start of the whole; use a transition with 'after_s'"
            yield Fault("/mission", f"its invariant '{invariant}' {why}")
    for key, declared in inner.blackboard.items():
        if declared.source == "answer" and shared_key(include.with_.get(key)) != key:
            why = f'keep the name: "with": {{"{key}": {{"from": "{key}"}}}}, and declare it in this mission'
            yield Fault("/mission", f"its key '{key}' is written by answers, which know it by that name; {why}")


def _captured(inner: Mission, parent: Mission) -> Iterator[str]:
    """Why an answer inside would write a key of the mission outside that it does not share."""
    own = {name for name, key in inner.blackboard.items() if key.source == "answer"}
    theirs = [name for name, key in parent.blackboard.items() if key.source == "answer" and name not in own]
    for asked in questions(inner) if theirs else ():
        for option, definition in asked.options.items():
            listed = listed_parameters(definition.parameters)
            for key in theirs:
                if listed is None:
                    yield f"its option '{option}' would write '{key}' of this mission; list its 'properties'"
                elif key in listed:
                    yield f"its option '{option}' would write '{key}' of this mission; rename one of them"


def questions(mission: Mission) -> Iterator[DecisionSpec]:
    """All that a mission asks, in its states and trees."""
    return (asked for _, _, state in mission.walk() for asked in state.decisions().values())
