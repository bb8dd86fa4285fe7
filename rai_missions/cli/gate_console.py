# SPDX-License-Identifier: Apache-2.0
"""A gate on a robot's actuators for `rai-missions gate`, until it is interrupted."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any, TextIO

from rai_missions.cli.gate_options import GateOptions
from rai_missions.gate import GateAgent, GateWords, gate_words, read_gate
from rai_missions.gate.bypass_monitor import BypassMonitor
from rai_missions.gate.config import command_topic, leases_of
from rai_missions.gate.memory import Memory, usual_path
from rai_missions.gate.state import COMMANDERS, Answer, ControlChange, GateEffect, Halt, Pass, PublishStatus, Refuse
from rai_missions.mission.garbage import set_apart
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.interrupts import on_signals

__all__ = ("serve_gate",)


def serve_gate(given: GateOptions) -> int:
    """Pass on the commands of the holder of control until an interrupt; returns the exit status."""
    from rai_missions.connectors.ros2 import open_connector

    config, clock = _config(given), WallClock()
    options: dict[str, Any] = {"sim_time": True} if given.sim_time else {}
    if given.domain is not None:
        options["domain_id"] = given.domain
    connector = open_connector(config.options(**options), now=clock.now)
    with ExitStack() as stack:
        log = stack.enter_context(open(given.log, "w", encoding="utf-8")) if given.log else None
        memory = Memory(Path(given.memory) if given.memory else usual_path(config.name, given.domain))
        observe = _observer(log, quiet=given.quiet, clock=clock)
        agent = GateAgent(config, connector, clock=clock, observe=observe, memory=memory)
        stack.enter_context(on_signals(lambda *_: agent.end()))
        stack.callback(connector.stop)
        connector.start()
        monitor = BypassMonitor(connector, (each.topic for each in config.commands), partial(_others, config.name))
        stack.callback(monitor.stop)
        monitor.run()
        stack.enter_context(set_apart())  # a stop is not to wait for a search of all that was loaded
        if not given.quiet:
            print(_opening(config, agent.gate.holder), flush=True)
        agent.serve()
    counts = agent.gate
    if not given.quiet:
        passed, refused = (
            ", ".join(f"{who} {each.get(who, 0)}" for who in COMMANDERS) for each in (counts.passed, counts.refused)
        )
        print(f"ended; commands passed: {passed}; refused: {refused}; handovers: {counts.revision}")
    if agent.gives_way:
        print(
            f"rai-missions gate: another gate has the name {config.name} already; give this one a --name",
            file=sys.stderr,
        )
    return int(agent.gives_way)


def _config(given: GateOptions) -> GateWords:
    """The contents of the file; an option replaces what is in the file."""
    commands = [command_topic(each) for each in given.command] or None
    options = {"commands": commands, "safe": given.safe, "name": given.name}
    words = {name: value for name, value in options.items() if value is not None}
    read = read_gate(given.file, **words) if given.file else gate_words(words, "rai-missions gate")
    return gate_words({**read.written(), "leases": {**read.leases, **leases_of(given.lease)}}, "--lease")


def _others(name: str, topic: str, count: int) -> None:
    who = "another node publishes" if count == 1 else f"{count} other nodes publish"
    print(
        f"rai-missions gate: {who} on {topic} as well: that reaches the actuators past this gate, no matter who "
        f"holds control; have it publish on {name}/{{{','.join(COMMANDERS)}}}{topic}, and end other gates of {topic}",
        file=sys.stderr,
        flush=True,
    )


def _opening(config: GateWords, holder: str) -> str:
    lines = [f"{config.name} guards {', '.join(each.topic for each in config.commands)}; {holder} has control"]
    if holder != config.safe:
        lines.append("  an earlier gate ended while the operator or no one had control: the operator gives it back")
    lines += [
        f"  {each.topic}: nothing stops it when control changes; give 'stop' in a file if a message can"
        for each in config.commands
        if each.stop_message is None
    ]
    first = config.commands[0].topic
    lines.append(f"  commands are received on {config.name}/{{{','.join(COMMANDERS)}}}{first}")
    return "\n".join(lines)


def _observer(log: TextIO | None, *, quiet: bool, clock: WallClock) -> Callable[[GateEffect], None]:
    def observe(effect: GateEffect) -> None:
        if isinstance(effect, ControlChange) and not quiet:
            print(
                f"{clock.now():10.3f}  {effect.former} → {effect.holder} (grant {effect.revision}): {effect.why}",
                flush=True,
            )
        elif isinstance(effect, Answer) and effect.why and not quiet:
            print(f"{clock.now():10.3f}  refused to {effect.request.by}: {effect.why}", flush=True)
        if log is not None and (row := _row(effect)):
            log.write(json.dumps({"at": round(clock.now(), 6), **row}, default=repr) + "\n")
            if not isinstance(effect, Pass | Refuse):
                log.flush()

    return observe


def _row(effect: GateEffect) -> dict[str, Any] | None:
    """A line of the log; a status is none."""
    if isinstance(effect, PublishStatus):
        return None
    if isinstance(effect, Pass | Refuse):
        did = {"did": "passed"} if isinstance(effect, Pass) else {"did": "refused", "why": effect.why}
        command = effect.command
        return {**did, "grant": effect.revision, "who": command.who, "topic": command.topic, "data": command.data}
    if isinstance(effect, ControlChange):
        return {
            "did": "changed",
            "grant": effect.revision,
            "from": effect.former,
            "to": effect.holder,
            "why": effect.why,
        }
    if isinstance(effect, Answer):
        asked = effect.request
        return {"did": "answered", "grant": effect.revision, "to": asked.to, "by": asked.by, "why": effect.why}
    assert isinstance(effect, Halt)
    return {"did": "halted", "why": effect.why}
