# SPDX-License-Identifier: Apache-2.0
"""What each command of the command line does."""

from __future__ import annotations

import argparse
import json
import math
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.check import check, exit_status
from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.load import load
from rai_missions.mission import Mission
from rai_missions.progress import Lines
from rai_missions.verdict import Answerer

if TYPE_CHECKING:
    from rai_missions.agents.mission import Setting

__all__ = ("COMMANDS",)


def run(given: argparse.Namespace) -> int:
    """Run a mission and print it as it goes."""
    from rai_missions.agents.mission import prepare

    mission = load(given.mission, python=not given.no_python)
    named = _named(given.guards)
    faults = [each.fault for each in check(mission, named=set(named or ())) if each.severity == "error"]
    if faults:
        raise DefinitionError(faults, given.mission)
    heard = [name for name, key in mission.blackboard.items() if key.source == "robot" and not key.optional]
    if heard and not given.robot:
        raise UsageError(f"the mission must hear {', '.join(heard)} from a robot; give its profile: --robot PROFILE")
    lines = _lines(mission, given)
    setting = replace(_setting(given, mission, lines), named=named)
    try:
        with prepare(setting) as prepared:
            robot = prepared.robot.name if prepared.robot is not None else ""
            if not given.json:
                lines.begin(robot, ", ".join(sorted(prepared.answerers)), str(setting.journal), model=given.model)
                lines.watch(prepared.runner.chart)
            with _interruptible(prepared.runner):
                result = prepared.runner.run()
    finally:
        lines.close()
    if given.picture:
        from visualize import draw as draw_picture

        draw_picture(mission, given.picture, steps=_steps(result.journal))
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
        print(json.dumps(told | {"duration_s": result.duration_s, "journal": result.journal}))
    else:
        lines.end(result, given.picture or "")
    return 0 if result.outcome == "succeeded" else 1


def _setting(given: argparse.Namespace, mission: Mission, lines: Lines) -> Setting:
    """What the words of the command line make a run of."""
    from rai_missions.agents.mission import Setting

    journal = f"journals/{mission.name.replace('/', '_')}-{time.strftime('%Y%m%d-%H%M%S')}.journal"
    return Setting(
        mission,
        given.robot,
        _arguments(given.set, mission),
        model=given.model,
        operator=_operator(given, lines),
        journal=_fresh(Path(given.journal or journal)),
        seed=given.seed,
        speed=1.0 if given.speed == "1" else math.inf,
        on_step=None if given.json else lines.step,
        on_status=None if given.json else lines.status,
    )


def check_mission(given: argparse.Namespace) -> int:
    """Print every fault of a mission, and of what a profile lacks."""
    mission = load(given.mission, python=not given.no_python)
    named = _named(given.guards)
    findings = list(check(mission, named=set(named))) if named is not None else list(check(mission))
    lacks: tuple[Fault, ...] = ()
    if given.robot:
        from rai_missions.robot import load_profile, missing

        lacks = missing(mission, load_profile(given.robot))
    if given.json:
        rows = [{"place": each.place, "sentence": each.sentence, "severity": each.severity} for each in findings]
        rows += [{"place": each.place, "sentence": each.sentence, "severity": "error"} for each in lacks]
        print(json.dumps(rows))
    else:
        for each in (*findings, *lacks):
            print(f"{given.mission}: {each}", file=sys.stderr)
        if not findings and not lacks:
            states = sum(1 for _ in mission.walk())
            print(f"{given.mission}: {mission.name} {mission.version} holds ({states} states)")
    return 2 if lacks else exit_status(findings, strict=given.strict)


def draw(given: argparse.Namespace) -> int:
    """Draw a mission."""
    from visualize import draw as draw_picture

    mission = load(given.mission, python=not given.no_python)
    output = given.output or f"{mission.name.replace('/', '_')}.svg"
    draw_picture(mission, output, steps=_steps(given.journal, mission))
    print(output)
    return 0


def diff(given: argparse.Namespace) -> int:
    """Say and draw what changed between two missions."""
    from visualize import difference

    old, new = (load(path, python=not given.no_python) for path in (given.old, given.new))
    found = difference(old, new)
    for line in found.lines():
        print(line)
    if given.output:
        from visualize import draw_difference

        draw_difference(found, given.output)
        print(f"picture: {given.output}")
    return 0 if found.empty else 1


def replay(given: argparse.Namespace) -> int:
    """Do a run again."""
    from rai_missions.journal import read
    from rai_missions.replay import mission_of
    from rai_missions.replay import replay as again

    with read(given.journal) as record:
        mission = load(given.mission) if given.mission else mission_of(record)
    lines = Lines(mission, sys.stdout)
    result = again(given.journal, on_step=lines.step if given.verbose and not given.json else None, mission=mission)
    if given.json:
        print(
            json.dumps(
                {
                    "holds": result.holds,
                    "steps": result.steps,
                    "difference": result.difference,
                    "outcome": result.outcome,
                    "why": result.why,
                }
            )
        )
    elif result.holds:
        ended = f"{result.outcome}: {result.why}" if result.outcome else "it had not ended"
        print(f"{result.steps} steps done again, all the same; {ended}")
    else:
        print(f"{result.steps} steps were the same, then: {result.difference}")
    return 0 if result.holds else 1


def schema(given: argparse.Namespace) -> int:
    """Print a JSON Schema."""
    if given.of == "robot":
        from rai_missions.robot.schema import robot_schema

        print(json.dumps(robot_schema(), indent=2, ensure_ascii=False))
        return 0
    from rai_missions.schema import mission_schema

    print(json.dumps(mission_schema(), indent=2, ensure_ascii=False))
    return 0


def new(given: argparse.Namespace) -> int:
    """Start a mission from a template."""
    from rai_missions.templates import start

    for path in start(given.template, Path(given.directory)):
        print(path)
    print(f"next: rai-missions check {given.directory}/mission.json")
    return 0


def doctor(_: argparse.Namespace) -> int:
    """Say what this machine has and lacks."""
    from rai_missions.doctor import examine

    complaints = 0
    for item in examine():
        print(item)
        complaints += item.status == "missing"
    return 1 if complaints else 0


COMMANDS: Mapping[str, Callable[[argparse.Namespace], int]] = {
    "run": run, "check": check_mission, "draw": draw, "diff": diff, "replay": replay, "schema": schema, "new": new,
    "doctor": doctor,
}  # fmt: skip


def _lines(mission: Mission, given: argparse.Namespace) -> Lines:
    """A live view on a terminal, a line a step elsewhere."""
    if sys.stdout.isatty() and not given.json:
        from rai_missions.screen import Screen

        return Screen(mission, sys.stdout, verbose=given.verbose)
    return Lines(mission, sys.stdout, verbose=given.verbose)


def _fresh(journal: Path) -> Path:
    """A journal is never written over: an older one of the same name is moved aside."""
    if journal.exists() and journal.is_file():
        from rai_missions.journal import read

        read(journal).close()  # what is no journal is not ours to move
        number = next(n for n in range(1, 10_000) if not journal.with_suffix(f".{n}{journal.suffix}").exists())
        journal.rename(journal.with_suffix(f".{number}{journal.suffix}"))
    return journal


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
    from rai_missions.agents.operator import OperatorAgent

    return lines.lend(OperatorAgent())


def _named(path: str | None) -> dict[str, Callable[..., bool | None]] | None:
    """The public functions of a file, by name."""
    if path is None:
        return None
    import runpy

    if not Path(path).is_file():
        raise UsageError(f"there is no file '{path}' with guards")
    try:
        found = runpy.run_path(path)
    except (Exception, SystemExit) as error:  # a file that exits must not look like a run that succeeded
        raise DefinitionError([Fault("", f"{type(error).__name__}: {error}")], path) from error
    own = {name: each for name, each in found.items() if callable(each) and not name.startswith("_")}
    return {name: each for name, each in own.items() if getattr(each, "__module__", None) == "<run_path>"}


def _steps(journal: str | None, mission: Mission | None = None) -> tuple[Any, ...]:
    """The steps of a journal.

    Raises:
        DefinitionError: The journal is damaged, or is of another mission.
    """
    if journal is None:
        return ()
    from rai_missions.journal import read
    from rai_missions.replay import mission_of

    with read(journal) as record:
        if mission is not None and record.header.mission and mission_of(record) != mission:
            sentence = "this is the journal of another mission, or of another version of it"
            raise DefinitionError(
                [Fault("", f"{sentence}: {mission_of(record).name} {mission_of(record).version}")], journal
            )
        return tuple(record.steps())


@contextmanager
def _interruptible(runner: Any) -> Iterator[None]:
    """The first interrupt cancels the mission, the second is an emergency stop."""
    pressed: list[int] = []

    def interrupt(number: int, frame: Any) -> None:
        pressed.append(number)
        if len(pressed) == 1:
            print("\ncanceling; once more for an emergency stop", file=sys.stderr)
            runner.cancel("operator (interrupt)")
        else:
            runner.kill("operator (interrupt)")

    before = {each: signal.signal(each, interrupt) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
