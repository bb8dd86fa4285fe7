# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run`: a mission, printed as it goes."""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.check import check, faults_of
from rai_missions.cli.arguments import named_in, steps_of, warn
from rai_missions.cli.commands.run_migrate import migrated
from rai_missions.cli.commands.run_node import beside, managed, refuse_words_of_one_run
from rai_missions.cli.commands.run_page import sort_out, watched
from rai_missions.cli.nonblocking_stdout import nonblocking_stdout, settled
from rai_missions.cli.progress import Lines
from rai_missions.cli.signals import on_signals
from rai_missions.engine.decision import Answerer
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.recording import check_name, is_mcap

if TYPE_CHECKING:
    from rai_missions.agents.mission import RunConfig

__all__ = ("run",)


@nonblocking_stdout()
def run(given: argparse.Namespace) -> int:
    """Run a mission and print it as it goes."""
    from rai_missions.agents.mission import prepare

    sort_out(given)
    if given.record:
        check_name(Path(given.record))
    if given.managed:
        return _managed(given)
    named = named_in(given.guards, python=not given.no_python)
    if given.migrate:
        migrated(given, named)
    mission = _mission(given)
    if faults := faults_of(check(mission, named=set(named or ()))):
        raise DefinitionError(faults, given.mission or given.resume)
    heard = [name for name, key in mission.blackboard.items() if key.source == "robot" and not key.optional]
    if heard and not given.robot and not given.resume:
        raise UsageError(f"the mission must hear {', '.join(heard)} from a robot; give its profile: --robot PROFILE")
    lines = _lines(mission, given)
    setting = replace(_setting(given, mission, lines), named=named)
    warn(_without_effect(given))
    try:
        with (
            watched(given, setting) as watch,
            beside(given, watch.setting if watch else setting) as stand,
            prepare(stand.setting) as prepared,
        ):
            robot = prepared.robot.name if prepared.robot is not None else ""
            if not given.json:
                answerers, goes_on = ", ".join(sorted(prepared.answerers)), prepared.goes_on
                lines.begin(
                    robot, answerers, str(setting.journal), model=given.model, goes_on=goes_on,
                    moved_aside=prepared.moved_aside or "",
                )  # fmt: skip
                lines.watch(prepared.runner.chart)
            with _interruptible(prepared.runner):
                result = watch.run(prepared, stand.run) if watch else stand.run(prepared.runner)
    finally:
        lines.close()
    settled()  # how it ended is not to be left out
    if given.picture:
        from visualize import draw as draw_picture

        draw_picture(mission, given.picture, steps=steps_of(result.journal))
    if given.json:
        active = set(result.state)
        innermost = [name for name in result.state if active.isdisjoint(mission.state(name).children())]
        told: dict[str, Any] = {
            "mission": mission.name,
            "run": result.run,
            "outcome": result.outcome,
            "why": result.why,
        }
        told |= {"state": ", ".join(innermost), "steps": result.steps, "decisions": result.decisions}
        told |= {"duration_s": result.duration_s, "journal": result.journal}
        told |= {"moved_aside": result.moved_aside}
        told |= {"open_goals": [goal.data() for goal in result.open_goals]}
        print(json.dumps(told | ({"recording": given.record} if given.record else {})))
    else:
        lines.end(result, given.picture or "")
        if prepared.recording is not None:
            print(f"recording: {prepared.recording.close()}")
    return 0 if result.outcome == "succeeded" else 1


def _without_effect(given: argparse.Namespace) -> str:
    """What was said of a simulated world, where the run opens none; empty if nothing was."""
    words = [f"--{word}" for word in ("speed", "seed") if getattr(given, word) is not None]
    if not words:
        return ""
    from rai_missions.profile import load_profile

    connector = load_profile(given.robot).connector if given.robot else {"kind": "none"}
    if (given.resume and not given.robot) or (connector["kind"] == "local" and connector.get("world") is not None):
        return ""
    said = f"{' and '.join(words)} {'has' if len(words) == 1 else 'have'} no effect: the run simulates no world, "
    if given.robot:
        return said + f"its robot is reached by a connector of kind '{connector['kind']}' (see: rai-missions world)"
    return said + "for it has no robot"


def _managed(given: argparse.Namespace) -> int:
    """Serve the mission on a node of its own, run by run."""
    from rai_missions.agents.mission import RunConfig

    refuse_words_of_one_run(given)
    warn(_without_effect(given))
    mission = _mission(given)
    base = Path(given.journal or _journal_of(mission))
    numbers = itertools.count(1)
    setting = RunConfig(
        Path(given.mission), given.robot, _arguments(given.set, mission), model=given.model,
        model_memory_gib=given.model_memory, seed=given.seed,
        named=named_in(given.guards, python=not given.no_python), speed=1.0 if given.speed == "1" else math.inf,
        journal=base,
    )  # fmt: skip
    return managed(given, setting, lambda: base.with_stem(f"{base.stem}-{next(numbers)}"))


def _setting(given: argparse.Namespace, mission: Mission, lines: Lines) -> RunConfig:
    """What the words of the command line make a run of."""
    from rai_missions.agents.mission import RunConfig
    from rai_missions.journal import make_way

    record, moved = _recorded(Path(given.record)) if given.record else None, None
    if given.resume:
        if given.set or given.journal:
            word = "--set" if given.set else "--journal"
            raise UsageError(f"{word} cannot be said with --resume: the run goes on in its journal as it began")
        journal = Path(given.resume)
    else:
        journal = Path(given.journal or _journal_of(mission))
        moved = make_way(journal)
    return RunConfig(
        mission,
        given.robot,
        {} if given.resume else _arguments(given.set, mission),
        model=given.model,
        model_memory_gib=given.model_memory,
        operator=_operator(given, lines),
        journal=journal,
        moved_aside=moved,
        record=record,
        resume=given.resume,
        seed=given.seed,
        speed=1.0 if given.speed == "1" else math.inf,
        on_step=None if given.json else lines.step,
        on_status=None if given.json else lines.status,
    )


def _journal_of(mission: Mission) -> str:
    return f"journals/{mission.name.replace('/', '_')}-{time.strftime('%Y%m%d-%H%M%S')}.journal"


def _mission(given: argparse.Namespace) -> Mission:
    """The mission that is named, or that of the run which goes on."""
    if not given.resume:
        if not given.mission:
            raise UsageError("name a mission (rai-missions run MISSION), or a run to go on with: --resume JOURNAL")
        return load(given.mission, python=not given.no_python)
    from rai_missions.journal import opened
    from rai_missions.replay.rebuild import mission_of

    now = load(given.mission, python=not given.no_python) if given.mission else None
    with opened(given.resume) as record:  # read whole, and looked at, when the run is taken up
        was = mission_of(record) if record.header.mission or now is None else now
    if now is not None and now != was:
        from visualize import difference

        changed = "\n".join(difference(was, now).lines())
        remedy = "go on without naming a mission, or in this one by a map of what has become of what: --migrate MAP"
        raise UsageError(f"{given.mission} is not the mission of {given.resume}:\n{changed}\n{remedy}")
    return was


def _lines(mission: Mission, given: argparse.Namespace) -> Lines:
    """A live view on a terminal, a line a step elsewhere."""
    if sys.stdout.isatty() and not given.json:
        from rai_missions.cli.live_terminal import Screen

        return Screen(mission, sys.stdout, verbose=given.verbose)
    return Lines(mission, sys.stdout, verbose=given.verbose)


def _recorded(path: Path) -> Path:
    """Where a recording goes; an older one of that name is moved aside."""
    from rai_missions.journal import free_name

    if path.is_file():
        if not is_mcap(path):
            raise UsageError(f"{path} is there already, and is no recording; name another file")
        moved = path.rename(free_name(path))
        warn(f"the recording of an earlier run, which had this name, is now {moved}")
    return path


def _arguments(given: list[str], mission: Mission) -> dict[str, Any]:
    """`KEY=VALUE` pairs; a value is JSON, or text where it is none or where text is wanted."""
    arguments: dict[str, Any] = {}
    for pair in given:
        name, sign, text = pair.partition("=")
        if not sign:
            raise UsageError(f"--set {pair}: write KEY=VALUE")
        key = mission.blackboard.get(name)
        try:
            arguments[name] = text if key is not None and key.type == "string" else json.loads(text)
        except json.JSONDecodeError:
            arguments[name] = text
    return arguments


def _operator(given: argparse.Namespace, lines: Lines) -> Answerer | None:
    """The person at the terminal, if there is one."""
    if given.no_operator or given.json or not sys.stdin.isatty():
        return None
    from rai_missions.answerers.terminal_operator import OperatorAgent

    return lines.lend(OperatorAgent())


@contextmanager
def _interruptible(runner: Any) -> Iterator[None]:
    """The first interrupt cancels the mission, the second is an emergency stop."""
    pressed: list[int] = []

    def interrupt(number: int, frame: Any) -> None:
        pressed.append(number)
        if len(pressed) == 1:
            runner.cancel("operator (interrupt)")
            with suppress(OSError):  # the terminal may be gone, which is why somebody interrupts
                print("\ncanceling; once more for an emergency stop", file=sys.stderr)
        else:
            runner.kill("operator (interrupt)")

    with on_signals(interrupt):
        yield
