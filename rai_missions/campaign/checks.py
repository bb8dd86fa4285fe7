# SPDX-License-Identifier: Apache-2.0
"""What a campaign's file alone does not show: whether it fits its mission, its profile and its world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rai_missions.campaign.embodiments import EMBODIMENTS
from rai_missions.campaign.file import ANY_KIND, CONSTANT, OWN, CampaignFile
from rai_missions.campaign.questions import CampaignSubject
from rai_missions.campaign.rollout import ROLLOUT_METHODS
from rai_missions.errors import DefinitionError, Fault, UsageError, pointer, suggestion
from rai_missions.mission.option_parameters import parameter_faults
from rai_missions.redaction import shown
from rai_missions.runtime.arguments import accepted
from rai_missions.states.decision import DecisionSpec, Option
from rai_missions.worlds.world import WORLDS, check_local, check_world, load_world

__all__ = ("faults_at_work", "faults_in")


def faults_in(file: CampaignFile, subject: CampaignSubject) -> Iterator[Fault]:
    """The faults of a campaign whose fields are good, each for itself."""
    states = [name for _, name, _ in subject.mission.walk()]
    if not subject.asked:
        known = suggestion(file.decision, states) if file.decision not in states else "; name a decision"
        yield Fault("/decision", f"'{file.decision}' is no decision of the mission{known}")
        return
    yield from _of_arguments(file, subject)
    yield from _of_world(file)
    for at, model in enumerate(file.models):
        if why := _unfit(model, file, subject):
            yield Fault(pointer(("models", at)), why)
    for at, embodiment in enumerate(file.embodiments):
        if embodiment != EMBODIMENTS[0] and subject.identity is None:
            sentence = f"'{embodiment}' shows the robot's identity, and its profile names none; add 'identity' there"
            yield Fault(pointer(("embodiments", at)), sentence)
    yield from _of_rollouts(file, subject)
    kinds = {each.kind for each in file.scenes.given}
    for name, script in file.scripts.items():
        for kind, line in script.items():
            if kinds and kind not in (*kinds, ANY_KIND):
                yield Fault(pointer(("scripts", name, kind)), f"no scene is of kind '{kind}'{suggestion(kind, kinds)}")
            option = line.get("option") if isinstance(line, Mapping) else line
            if not isinstance(option, str | None):
                yield Fault(
                    pointer(("scripts", name, kind)), f"an answer is an option's name or an object, not {shown(line)}"
                )


def _of_arguments(file: CampaignFile, subject: CampaignSubject) -> Iterator[Fault]:
    try:
        accepted(subject.mission, file.arguments)
    except DefinitionError as error:
        yield from (Fault(each.place.replace("/blackboard", "/arguments", 1), each.sentence) for each in error.faults)


def _of_world(file: CampaignFile) -> Iterator[Fault]:
    world = file.scenes.world
    try:
        check_world(world)
    except UsageError as error:
        yield Fault("/scenes/world", str(error))
        return
    try:
        if world not in WORLDS:  # ours take one
            check_local({"world": world, "seed": 0})
    except UsageError as error:
        yield Fault("/scenes/world", f"{error}; a campaign gives each world the seed of its scene")
        return
    if file.scenes.count is not None:
        from rai_missions.campaign.scenes import GENERATORS  # loads the worlds

        if world not in GENERATORS:
            drawn = f"no scenes are drawn of the world {shown(world)}, but of: {', '.join(GENERATORS)}"
            yield Fault("/scenes/count", f"{drawn}; write them under 'given', or name 'seeds'")
            return
    yield from _of_labels(file)


def _of_labels(file: CampaignFile) -> Iterator[Fault]:
    world, lacked = file.scenes.world, _lacked_for_rollouts(file.scenes.world)
    if file.labels == "trials":
        from rai_missions.campaign.labels import TRIALS  # loads the world

        if world not in TRIALS:
            instead = 'have "none"' if lacked else 'have "rollouts"'
            yield Fault(
                "/labels", f"nothing tries options in the world {shown(world)}, but in: {', '.join(TRIALS)}; {instead}"
            )
    if file.labels == "rollouts" and lacked:
        why = f"nothing is rolled out in the world {shown(world)}: its class lacks {lacked}; add what it lacks, or have"
        yield Fault("/labels", f'{why} "none"')


def _lacked_for_rollouts(world: str) -> str:
    """The methods for rollouts that a world's class lacks; empty for ours, and where only a made world shows it."""
    if world in WORLDS:
        return ""
    try:
        made_by = load_world(world)
    except UsageError:
        return ""  # what does not load here is not checked
    absent = [each for each in ROLLOUT_METHODS if not hasattr(made_by, each)]
    return ", ".join(absent) if isinstance(made_by, type) else ""


def faults_at_work(file: CampaignFile, subject: CampaignSubject) -> Iterator[Fault]:
    """What a run would find at work: scenes without a world, options that cannot be tried, weights that are not here.

    Each scene's world is made for it, in about 0.1 s.
    """
    yield from _of_scenes(file)
    yield from _of_tried(file, subject)
    yield from _of_weights(file)


def _of_scenes(file: CampaignFile) -> Iterator[Fault]:
    scenes = file.scenes
    try:
        load_world(scenes.world)
    except UsageError as error:
        yield Fault("/scenes/world", str(error))
        return
    built: list[tuple[str, Mapping[str, Any]]] = [
        (f"/scenes/given/{number}/options", {"seed": each.seed, **each.options})
        for number, each in enumerate(scenes.given)
    ]
    for place, options in built or [("/scenes/options", {"seed": min(scenes.seeds, default=0)})]:
        try:
            check_local({**scenes.options, **options, "world": scenes.world})
        except UsageError as error:
            yield Fault(place, str(error))


def _of_tried(file: CampaignFile, subject: CampaignSubject) -> Iterator[Fault]:
    for option, entry in (subject.spec.options if subject.spec is not None else {}).items():
        given = file.rollouts.parameters.get(option)
        if (given is not None or file.labels == "rollouts") and (why := _unfit_parameters(entry, given or {})):
            yield Fault(pointer(("rollouts", "parameters", option)), why)


def _unfit_parameters(option: Option, given: Mapping[str, Any]) -> str:
    """Why an option cannot be tried with these parameters; empty where it can."""
    if option.parameters is None:
        return "the option takes no parameters; drop them" if given else ""
    why = parameter_faults(option.parameters, given)
    return f"the option is tried with these parameters, which do not fit: {why}" if why else ""


def _of_weights(file: CampaignFile) -> Iterator[Fault]:
    for at, model in enumerate(file.models):
        provider, _, weights = model.partition(":")
        if provider == "local" and weights:
            from rai_missions.answerers.model.local_server import gguf  # few campaigns need it

            try:
                gguf(Path(weights).expanduser())
            except UsageError as error:
                yield Fault(pointer(("models", at)), str(error))


def _of_rollouts(file: CampaignFile, subject: CampaignSubject) -> Iterator[Fault]:
    for tried in file.rollouts.parameters:
        if tried not in subject.options:
            yield Fault(
                pointer(("rollouts", "parameters", tried)), f"no option '{tried}'{suggestion(tried, subject.options)}"
            )
    asking = {name: spec for _, name, state in subject.mission.walk() if (spec := state.question()) is not None}
    yield from _of_later(("rollouts", "later"), file.rollouts.later, asking)
    for number, each in enumerate(file.scenes.given):
        yield from _of_later(("scenes", "given", number, "later"), each.later, asking)


def _of_later(
    place: tuple[str | int, ...], later: Mapping[str, Mapping[str, str]], asking: Mapping[str, DecisionSpec]
) -> Iterator[Fault]:
    """What is wrong with the answers to later questions at a place of the file."""
    known = sorted({each for spec in asking.values() for each in spec.ask})
    for who, answers in later.items():
        if who not in known:
            yield Fault(pointer((*place, who)), f"no decision asks '{who}'{suggestion(who, known)}")
        for state, option in answers.items():
            if sentence := _unfit_answer(state, option, asking):
                yield Fault(pointer((*place, who, state)), sentence)


def _unfit_answer(state: str, option: str, asking: Mapping[str, DecisionSpec]) -> str:
    """Why a later answer of rollouts cannot be given; empty where it can."""
    if state not in asking:
        return f"'{state}' is no decision of the mission{suggestion(state, asking)}"
    options: Any = asking[state].options
    return "" if option in options else f"'{state}' has no option '{option}'{suggestion(option, options)}"


def _unfit(model: str, file: CampaignFile, subject: CampaignSubject) -> str:
    """Why a model cannot be asked, as far as its name shows; empty where it may."""
    if model == "rules" and not subject.robot.rules.get(file.decision):
        return f"the profile has no rules for '{file.decision}', which is asked; add them there, or drop 'rules'"
    if model in OWN or model in file.scripts or model == "local":
        return ""
    if model.startswith(CONSTANT):
        option = model.removeprefix(CONSTANT)
        return "" if option in subject.options else f"no option '{option}'{suggestion(option, subject.options)}"
    provider, _, name = model.partition(":")
    if provider and name:
        from rai_missions.answerers.model.providers import unknown_provider  # loads langchain

        return unknown_provider(model)
    near = suggestion(model, (*OWN, *file.scripts))
    return f"'{model}' names no model: rules, oracle, constant:OPTION, local, a script, or PROVIDER:NAME{near}"
