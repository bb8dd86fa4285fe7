# SPDX-License-Identifier: Apache-2.0
"""A run of a mission for `rai-missions run`: from its options to what is printed at the end."""

from __future__ import annotations

import itertools
import json
import os
import sys
import time
import uuid
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.agents.mission import PreparedRun, RunConfig, prepare
from rai_missions.check import errors_of, load_whole
from rai_missions.cli.inputs import (
    distinct,
    is_robot_program,
    journal_steps,
    load_guards,
    program_hashes,
    read_pairs,
    warn,
)
from rai_missions.cli.output import wait_for_output
from rai_missions.cli.progress import Lines
from rai_missions.cli.run.live_page import normalise_watch_args, page_of
from rai_missions.cli.run.migration import migrated
from rai_missions.cli.run.node import claiming_without_node, reject_single_run_options, serve_managed, serve_node
from rai_missions.cli.run.talk import normalise_voice_args, talk_of, talking
from rai_missions.errors import DefinitionError, MissionError, UsageError
from rai_missions.journal import opened
from rai_missions.mission.garbage import set_apart
from rai_missions.mission.mission import Mission
from rai_missions.profile import load_whole_profile, missing, missing_world, read_program
from rai_missions.runtime.interrupts import on_interrupts

if TYPE_CHECKING:
    from rai_missions.cli.run.options import RunOptions
    from rai_missions.engine import Named
    from rai_missions.engine.decision import Answerer
    from rai_missions.runtime.result import Result

__all__ = ("run_mission",)


def run_mission(options: RunOptions) -> int:
    """Run a mission and print each step; returns the exit status."""
    options = normalise_voice_args(normalise_watch_args(options))
    is_python = is_robot_program(options.robot, python=not options.no_python)
    _check_files(options)
    if options.managed:
        return _run_managed(options, is_python=is_python)
    _reject_beginning(options)  # ahead of a migration, which closes the run's journal
    named = load_guards(options.guards, python=not options.no_python)
    program = None
    if options.migrate:
        options, program = migrated(options, named)
    mission = _mission(options)
    _check_mission(mission, options, named)
    if not is_python and not options.resume:
        _check_reach(mission, options.robot)
    lines = _lines(mission, options)
    config = _single_run(options, mission, named, lines)
    if program is not None:
        config = replace(config, robot=program)
    warn(_without_effect(options, mission, is_python=is_python))
    with ExitStack() as signals:
        try:
            prepared, result, succeeded = _run(options, config, lines, signals)
        finally:
            lines.close()
        wait_for_output()  # so that the outcome is not left out
        picture = _drawn(mission, options.picture, result) if options.picture else ""
        if options.json:
            print(json.dumps(_as_json(mission, result, options.record)))
        else:
            _report_end(lines, prepared, result, picture)
    return 0 if succeeded else 1


def _check_files(options: RunOptions) -> None:
    """Refuse names of files that cannot be written, or are the same."""
    if options.record:
        from rai_missions.recording import check_name

        check_name(Path(options.record))
    if options.picture:
        from visualize import check_ending

        check_ending(options.picture)
    words = ("mission", "robot", "guards", "journal", "record", "picture")
    distinct({"MISSION" if word == "mission" else f"--{word}": getattr(options, word) for word in words})


def _check_mission(mission: Mission, options: RunOptions, named: Named | None) -> None:
    """Refuse a mission that is at fault, or needs a robot where none is given."""
    source = options.mission or options.resume or ""
    if faults := errors_of(mission, source, named=named or {}):
        raise DefinitionError(faults, source)
    needed = mission.needed_facts()
    if needed and not options.robot and not options.resume:
        raise UsageError(
            f"the mission must receive {', '.join(needed)} from a robot; "
            "give its profile, or its program in Python: --robot FILE"
        )


def _check_reach(mission: Mission, robot: str | None) -> None:
    """Refuse a profile on whose side there is no one, where the mission must receive facts: none would ever come."""
    if not robot or not mission.needed_facts():
        return
    profile = load_whole_profile(robot, mission)
    if alone := tuple(missing_world(mission, profile)):
        raise DefinitionError((*alone, *missing(mission, profile)), robot)


def _drawn(mission: Mission, picture: str, result: Result) -> str:
    """Draw a run that has ended, whose outcome counts also where that fails; gives the file, empty where there is none.

    Args:
        mission: That was run.
        picture: The file.
        result: With the journal of its steps.
    """
    from visualize import draw

    try:
        draw(mission, picture, steps=journal_steps(result.journal))
    except (MissionError, OSError) as error:
        warn(f"the run was not drawn: {error}")
        return ""
    return picture


def _report_end(lines: Lines, prepared: PreparedRun, result: Result, picture: str = "") -> None:
    lines.end(result, picture)
    if prepared.recording is not None:
        print(f"recording: {prepared.recording.close()}")


class LastRun(NamedTuple):
    """What the command ends with."""

    prepared: PreparedRun
    result: Result
    succeeded: bool
    """The last run that began, which is this one unless it waited for an order in vain."""


def _run(options: RunOptions, config: RunConfig, lines: Lines, signals: ExitStack) -> LastRun:
    """Run with the page and the node that are asked for; with talk, one run after the other.

    Args:
        options: The options of the command.
        config: What the run is made of.
        lines: Where its steps are printed.
        signals: What handles signals from the start of the run on, until its end is reported.
    """
    with ExitStack() as stack:
        setup = stack.enter_context(talk_of(options, config))
        config = setup.config if setup else config
        page = stack.enter_context(page_of(options, config))
        node = stack.enter_context(serve_node(options, page.config if page else config))
        prepared = stack.enter_context(prepare(node.config))
        _report_beginning(options, lines, prepared)
        signals.enter_context(on_interrupts(prepared.runner.cancel, prepared.runner.kill))
        talk = None
        if setup is not None:
            talk = stack.enter_context(talking(setup, prepared, node.config, lines, page.talk_door if page else None))
            if page is not None:
                page.join(talk)
        ended: LastRun | None = None
        instance = uuid.uuid4().hex[:12]
        stack.enter_context(set_apart())  # an e-stop is not to wait for a search of all that was loaded
        while True:
            with claiming_without_node(options, prepared, instance):
                result = page.run(prepared, node.run) if page else node.run(prepared.runner)
            is_begun = ended is None or not prepared.runner.waits
            ended = LastRun(
                prepared, result, result.outcome == "succeeded" if is_begun or not ended else ended.succeeded
            )
            following = talk.follow(prepared, result) if talk is not None else None
            if following is None:
                return ended
            _report_end(lines, prepared, result)
            prepared = stack.enter_context(following)
            _report_beginning(options, lines, prepared)


def _report_beginning(options: RunOptions, lines: Lines, prepared: PreparedRun) -> None:
    if (recording := prepared.recording) is not None and recording.moved_aside is not None:
        warn(f"the recording of an earlier run, which had this name, is now {recording.moved_aside}")
    if options.json:
        return
    lines.begin(
        prepared.robot.name if prepared.robot is not None else "",
        prepared.answerers.keys(),
        str(prepared.plan.config.journal),
        model=options.model,
        resumption=prepared.resumption_notice,
        moved_aside=prepared.moved_aside or "",
    )
    lines.watch(prepared.runner.view)


def _as_json(mission: Mission, result: Result, recording: str | None) -> dict[str, Any]:
    active = set(result.state)
    innermost = [name for name in result.state if active.isdisjoint(mission.state(name).children())]
    found = {
        "mission": mission.name,
        "run": result.run,
        "outcome": result.outcome,
        "why": result.why,
        "state": ", ".join(innermost),
        "steps": result.steps,
        "decisions": result.decisions,
        "duration_s": result.duration_s,
        "journal": result.journal,
        "moved_aside": result.moved_aside,
        "open_goals": [goal.data() for goal in result.open_goals],
    }
    return found | ({"recording": recording} if recording else {})


def _without_effect(options: RunOptions, mission: Mission, *, is_python: bool) -> str:
    """The options of a simulated world that have no effect, in a sentence; empty where there is none."""
    words = [f"--{word}" for word in ("speed", "seed") if getattr(options, word) is not None]
    if is_python:
        return "--seed has no effect: the robot is in Python, and no world is simulated" if "--seed" in words else ""
    if not words:
        return ""
    robot = load_whole_profile(options.robot, mission) if options.robot else None
    if (options.resume and robot is None) or (robot is not None and robot.world):
        return ""
    text = f"{' and '.join(words)} {'has' if len(words) == 1 else 'have'} no effect: the run simulates no world, "
    if robot is None:
        return text + "for it has no robot"
    kind = robot.connector["kind"]
    return text + f"its robot is reached by a connector of kind '{kind}' (see: rai-missions world)"


def _run_managed(options: RunOptions, *, is_python: bool) -> int:
    """Serve the mission on a node, run by run."""
    reject_single_run_options(options)
    mission = _mission(options)
    if not is_python:
        _check_reach(mission, options.robot)
    warn(_without_effect(options, mission, is_python=is_python))
    base = Path(options.journal or _journal_of(mission))
    numbers = itertools.count(1)
    config = replace(
        _config(options, mission, load_guards(options.guards, python=not options.no_python), base),
        mission=Path(options.mission or ""),
        robot=read_program(options.robot) if options.robot and is_python else options.robot,
    )
    return serve_managed(options, config, lambda: base.with_stem(f"{base.stem}-{next(numbers)}"))


def _config(options: RunOptions, mission: Mission, named: Named | None, journal: Path) -> RunConfig:
    """What the options mean for every run."""
    return RunConfig(
        mission,
        options.robot,
        {} if options.resume else _arguments(options, mission),
        model=options.model,
        model_memory_gib=options.model_memory,
        journal=journal,
        named=named,
        seed=options.seed,
        speed=options.speed,
        programs=program_hashes(mission=options.mission, guards=options.guards),
    )


def _single_run(options: RunOptions, mission: Mission, named: Named | None, lines: Lines) -> RunConfig:
    """What the options mean for one run, whose steps are printed."""
    journal = Path(options.resume or options.journal or _journal_of(mission))
    return replace(
        _config(options, mission, named, journal),
        operator=_operator(options, lines),
        record=options.record,
        resume=options.resume,
        on_step=None if options.json else lines.step,
        on_status=None if options.json else lines.status,
    )


def _reject_beginning(options: RunOptions) -> None:
    """Refuse options of a run that begins where one resumes; one that migrates has a journal of its own."""
    if options.resume and (options.set or (options.journal and not options.migrate)):
        word = "--set" if options.set else "--journal"
        raise UsageError(f"{word} does not go with --resume: the run resumes in its journal as it began")


def _journal_of(mission: Mission) -> str:
    """The journal of a run that names none; runs that begin together have one each."""
    return f"journals/{mission.stem}-{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}.journal"


def _mission(options: RunOptions) -> Mission:
    """The mission that is named, or that of the run which resumes."""
    if not options.resume:
        if not options.mission:
            raise UsageError("name a mission (rai-missions run MISSION), or a run to resume: --resume JOURNAL")
        return load_whole(options.mission, python=not options.no_python)
    from rai_missions.replay.rebuild import mission_of

    now = load_whole(options.mission, python=not options.no_python) if options.mission else None
    with opened(options.resume) as record:  # read whole, and looked at, when the run is resumed
        was = mission_of(record) if record.header.mission or now is None else now
    if now is not None and now != was:
        from visualize import difference

        changed = "\n".join(difference(was, now).lines())
        remedy = "resume without naming a mission, or in this one with a map of its states and keys: --migrate MAP"
        raise UsageError(f"{options.mission} is not the mission of {options.resume}:\n{changed}\n{remedy}")
    return was


def _lines(mission: Mission, options: RunOptions) -> Lines:
    """A live view on a terminal, a line a step elsewhere."""
    if options.talk and not options.json:
        from rai_missions.cli.run.talk_terminal import TalkLines

        return TalkLines(mission, verbose=options.verbose, colours=sys.stdout.isatty())
    if sys.stdout.isatty() and not options.json:
        from rai_missions.cli.live_terminal import Screen

        return Screen(mission, sys.stdout, verbose=options.verbose)
    return Lines(mission, sys.stdout, verbose=options.verbose)


def _arguments(options: RunOptions, mission: Mission) -> dict[str, Any]:
    texts = [name for name, key in mission.blackboard.items() if key.type == "string"]
    return read_pairs("--set", options.set, texts)


def _operator(options: RunOptions, lines: Lines) -> Answerer | None:
    """The person at the terminal, if there is one."""
    if options.no_operator or options.json or options.talk or not sys.stdin.isatty():
        return None
    from rai_missions.answerers.terminal_operator import OperatorAgent

    return lines.lend(OperatorAgent())
