# SPDX-License-Identifier: Apache-2.0
"""The command line: `rai-missions run check draw diff replay prove textconv schema new doctor world gate watch`.

Rule: exit 0 the mission succeeded (or the check or replay holds), 1 it ended otherwise, 2 the input is at fault.
What a command needs is imported when it runs.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence

__all__ = ("main", "parser")

ABOUT = "Missions for robots: rules own the state, models only answer questions."
EXIT = "exit status: 0 it succeeded or holds, 1 it ended otherwise or does not hold, 2 the input is at fault"
DIFF_EXIT = (
    "exit status: 0 nothing changed that diff weighs as safety-relevant, 1 something did (--fail-on says what counts),"
    " 2 the input is at fault. Weighed so is what lets something happen that could not before, or drops what protected:"
    " an option newly offered to a model, a weaker guard, a longer timeout, a lost invariant, a new way to succeeded;"
    " and what cannot be told. Not weighed, so a 0 says nothing of it: what tightens, words for people, the robot's"
    " profile, programs behind the mission, and the model that answers."
)

SHOWN = ("run", "textconv")
"""Commands that draw on a terminal, or print a file as it is; the others print words alone."""


def _add_run(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    run = commands.add_parser("run", help="run a mission on a robot, simulated or real", epilog=EXIT)
    run.add_argument("mission", metavar="MISSION", nargs="?", help="a .json file, or a .py file that offers mission()")
    run.add_argument(
        "--resume", metavar="JOURNAL", help="go on with a run that was cut short; its mission and profile are in there"
    )
    run.add_argument(
        "--migrate", metavar="MAP",
        help="have the run of --resume go on in MISSION, which has changed: a .json file that says what has become of"
        " states and keys (rai-missions schema map); what it does not name must be as it was",
    )  # fmt: skip
    run.add_argument("--robot", metavar="PROFILE", help="the robot profile: what stands behind the mission's names")
    run.add_argument(
        "--set", metavar="KEY=VALUE", action="append", default=[], help="an argument of the mission; may be repeated"
    )
    run.add_argument(
        "--model",
        metavar="PROVIDER:NAME",
        help="who answers as 'agent': openai:NAME, anthropic:NAME, ollama:NAME, local[:FILE.gguf]",
    )
    run.add_argument(
        "--model-memory", metavar="GIB", type=float, default=2.0,
        help="how much memory the model's process may use, with what it starts (default: 2)",
    )  # fmt: skip
    run.add_argument("--no-operator", action="store_true", help="ask no operator, on the terminal or elsewhere")
    run.add_argument("--guards", metavar="FILE.py", help="predicates for guards that are 'named'; executed")
    run.add_argument("--no-python", action="store_true", help="refuse a mission and guards that are Python")
    run.add_argument(
        "--journal", metavar="FILE", help="where the run is written down (default: journals/NAME-TIME.journal)"
    )
    run.add_argument(
        "--record",
        metavar="FILE.mcap",
        help="record messages, pictures, steps and the journal as MCAP, for Foxglove and replay (extra 'record')",
    )
    run.add_argument("--picture", metavar="FILE", help="draw the path taken when it ends: .svg, .png, .dot, .mmd, .md")
    run.add_argument(
        "--speed",
        choices=("1", "max"),
        default=None,
        help="a simulated world's pace: 1 as on the wall, max as fast as it goes (default)",
    )
    run.add_argument("--seed", type=int, metavar="N", help="the simulated world's seed, instead of the profile's")
    run.add_argument("--json", action="store_true", help="print one object at the end, and nothing else on stdout")
    run.add_argument("--verbose", action="store_true", help="print steps that changed nothing too")
    run.add_argument(
        "--node",
        metavar="NAME",
        nargs="?",
        const="",
        help="serve the run on the robot's graph: lifecycle, orders, status, diagnostics (default: the mission's name)",
    )
    run.add_argument(
        "--managed", action="store_true", help="a node that runs the mission whenever it is told to, until shut down"
    )
    run.add_argument(
        "--watch", metavar="PORT", nargs="?", const="8765",
        help="show the run on a web page, with what the operator may do (default: port 8765; 0: any; extra 'watch')",
    )  # fmt: skip
    _add_place(run)
    run.add_argument(
        "--ros-args",
        metavar="…",
        nargs=argparse.REMAINDER,
        default=[],
        help="what ROS is told; ros2 launch appends it",
    )
    run.set_defaults(command="run")


def _add_place(command: argparse.ArgumentParser) -> None:
    """Where a page is served."""
    command.add_argument("--host", metavar="ADDRESS", help="where the page listens (default: 127.0.0.1); needs TLS")
    command.add_argument("--tls-cert", metavar="FILE", help="the page's certificate, PEM")
    command.add_argument("--tls-key", metavar="FILE", help="its private key, PEM")


def _add_watch(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    watch = commands.add_parser(
        "watch",
        help="look on at a run in a browser",
        description="Prints the address of the page that a run serves (run --watch). For a JOURNAL or RUN that is"
        " named, or where no run serves one, serves a page that follows the journal, and only looks on.",
        epilog="exit status: 0 it was ended (Ctrl-C, SIGTERM), 2 the input is at fault",
    )
    watch.add_argument(
        "journal", metavar="JOURNAL|RUN", nargs="?",
        help="a journal or recording, or a run's id or name in journals/ (default: the run with a page, or the newest)",
    )  # fmt: skip
    watch.add_argument("--port", metavar="PORT", type=int, default=8765, help="default: 8765; 0: any that is free")
    _add_place(watch)


def _add_reviews(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    check = commands.add_parser("check", help="find every fault of a mission before it runs", epilog=EXIT)
    check.add_argument("mission", metavar="MISSION")
    check.add_argument(
        "--robot", metavar="PROFILE", help="check too that the profile has every name that the mission uses"
    )
    check.add_argument("--guards", metavar="FILE.py", help="predicates for guards that are 'named'; executed")
    check.add_argument("--no-python", action="store_true", help="refuse a mission and guards that are Python")
    check.add_argument("--strict", action="store_true", help="warnings count: exit 1")
    check.add_argument("--json", action="store_true", help="print the findings as one JSON list")
    draw = commands.add_parser("draw", help="draw a mission, with the path of a journal in bold", epilog=EXIT)
    draw.add_argument("mission", metavar="MISSION")
    draw.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="by its ending: .html, the review page; .svg .png .dot .mmd .md (default: NAME.svg)",
    )
    draw.add_argument(
        "--journal", metavar="FILE", action="append", default=[],
        help="the path that this run took, in bold; may be repeated",
    )  # fmt: skip
    draw.add_argument("--no-python", action="store_true", help="refuse a mission that is Python")
    replay = commands.add_parser(
        "replay", help="do runs again from their journals or recordings and compare every step", epilog=EXIT
    )
    replay.add_argument(
        "journal", metavar="JOURNAL", help="a journal, a recording (.mcap), or a folder of them: a verdict each"
    )
    replay.add_argument("--mission", metavar="FILE.py", help="the mission, where it has behaviours in Python; executed")
    replay.add_argument("--no-python", action="store_true", help="refuse a mission that is Python")
    replay.add_argument("--json", action="store_true", help="print one object at the end")
    replay.add_argument("--verbose", action="store_true", help="print the steps")


def _add_diff(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    diff = commands.add_parser(
        "diff",
        help="what changed between two missions, by meaning; what a reviewer must not miss comes first",
        usage="rai-missions diff [options] OLD NEW\n       rai-missions diff [options] --git REV MISSION",
        epilog=DIFF_EXIT,
    )
    diff.add_argument("old", metavar="OLD", help="the mission as it was; with --git the one mission")
    diff.add_argument("new", metavar="NEW", nargs="?", help="the mission as it is")
    diff.add_argument(
        "--git", metavar="REV", help="compare MISSION with itself at a commit, branch or tag, and what it includes too"
    )
    diff.add_argument(
        "-o", "--output", metavar="FILE", action="append", default=[],
        help="by its ending: .html, a page; .md, for a comment; .json; .svg .png .dot .mmd, both in one picture;"
        " may be repeated",
    )  # fmt: skip
    diff.add_argument(
        "--fail-on", choices=("safety", "any", "none"), default="safety", help="what exits 1 (default: safety)"
    )
    diff.add_argument("--no-python", action="store_true", help="refuse a mission that is Python")
    diff.add_argument("--python", action="store_true", help="execute a mission in Python of another revision too")
    textconv = commands.add_parser(
        "textconv", help="print a mission as text, one thing a line, for git diff", epilog=EXIT
    )
    textconv.add_argument("file", metavar="FILE", help="a .json mission; anything else is printed as it is")


def _add_prove(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    prove = commands.add_parser(
        "prove",
        help="explore every run of a mission: what is promised of all of them is proved, or refuted by a shortest run",
        epilog="exit status: 0 every claim is proved, 1 one is refuted or a bound was hit, 2 the input is at fault",
    )
    prove.add_argument("mission", metavar="MISSION", help="a .json file, or a .py file that offers mission()")
    prove.add_argument(
        "--robot", metavar="PROFILE", help="which actions exclude each other, and what composed ones rest on"
    )
    prove.add_argument("--states", type=int, metavar="N", help="states at the most (default: a million)")
    prove.add_argument(
        "--max-seconds", type=float, metavar="S", help="wall time at the most, in seconds (default: 900)"
    )
    prove.add_argument("--max-memory", type=float, metavar="MIB", help="memory at the most, in MiB (default: 4096)")
    prove.add_argument(
        "--all", action="store_true",
        help="where a claim is refuted, explore the others to the limits; else for ten times what that has cost",
    )  # fmt: skip
    prove.add_argument("--guards", metavar="FILE.py", help="predicates that 'named' guards name; free in a proof")
    prove.add_argument("--no-python", action="store_true", help="refuse a mission and guards that are Python")
    prove.add_argument(
        "-o", "--output", metavar="FILE", help="where a refutation's run goes (default: NAME-CLAIM.journal)"
    )
    prove.add_argument("--json", action="store_true", help="print one object")


def _add_tools(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    schema = commands.add_parser("schema", help="print the JSON Schema of missions, robot profiles or maps")
    schema.add_argument("of", nargs="?", choices=("mission", "robot", "map"), default="mission")
    new = commands.add_parser("new", help="start a mission of your own from a template", epilog=EXIT)
    new.add_argument("directory", metavar="DIRECTORY", help="made; must not be there or be empty")
    new.add_argument(
        "--template", default="minimal", metavar="NAME", help="minimal (default), or a shipped mission: rosbot, tractor"
    )
    doctor = commands.add_parser(
        "doctor",
        help="say what this machine has, what it lacks and how to get it",
        epilog="exit status: 0 nothing that is needed is missing, 1 something is, 2 the input is at fault",
    )
    doctor.add_argument(
        "--robot", metavar="PROFILE", help="look too whether its types are here, and its topics, services and actions"
    )


def _pace(text: str) -> float:
    """Simulated seconds to one of the wall."""
    try:
        speed = math.inf if text == "max" else float(text)
    except ValueError:
        speed = math.nan
    if not speed > 0:
        raise argparse.ArgumentTypeError(f"{text!r} is no pace: give 1, another number above 0, or max")
    return speed


def _add_world(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    world = commands.add_parser(
        "world",
        help="put a simulated robot on ROS, in a process of its own",
        epilog="exit status: 0 it was ended (Ctrl-C, SIGTERM), 2 the input is at fault",
    )
    world.add_argument("world", metavar="WORLD", help="house or orchard")
    world.add_argument("--ros", action="store_true", help="on the ROS 2 graph")
    world.add_argument("--domain", type=int, metavar="N", help="the ROS domain (default: ROS_DOMAIN_ID, or 0)")
    world.add_argument("--seed", type=int, metavar="N", help="decides what is not said (default: the world's own)")
    world.add_argument(
        "--speed",
        type=_pace,
        default=1.0,
        metavar="1|N|max",
        help="simulated seconds to one of the wall (default 1); missions follow by /clock",
    )
    world.add_argument(
        "--option",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help='what the world takes, as JSON: alleys=2, obstacles=\'["branch", "none"]\'; may be repeated',
    )
    world.add_argument(
        "--no-camera", action="store_true", help="no pictures and no detected obstacles; needs no OpenGL"
    )


def _add_gate(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    gate = commands.add_parser(
        "gate",
        help="let only the holder of control command a robot's actuators",
        description="Stands where the actuators are: of autonomy, agent and operator, each on topics of its own"
        " (/gate/agent/cmd_vel → /cmd_vel), only the holder of control is let through.",
        epilog="exit status: 0 it was ended (Ctrl-C, SIGTERM), 1 another gate stands there, 2 the input is at fault",
    )
    gate.add_argument("--ros", action="store_true", help="on the ROS 2 graph (the default)")
    gate.add_argument("--file", metavar="FILE.json", help="all of this in a file, and what stops each topic")
    gate.add_argument(
        "--command", dest="command_topics", metavar="TOPIC=TYPE", action="append", default=[],
        help="a command topic of the actuators (default: /cmd_vel=geometry_msgs/msg/Twist); may be repeated",
    )  # fmt: skip
    gate.add_argument(
        "--lease", metavar="HOLDER=SECONDS", action="append", default=[],
        help="a holder that says nothing for so long loses control (default: agent=0.5; 0: never); may be repeated",
    )  # fmt: skip
    gate.add_argument("--safe", choices=("autonomy", "nobody"), help="who has control then, and at first (autonomy)")
    gate.add_argument(
        "--memory", metavar="FILE", help="where it keeps who holds control, for a gate that is started again"
        " (default: a file for each name and ROS domain below ~/.local/state/rai_missions)",
    )  # fmt: skip
    gate.add_argument("--name", metavar="NAME", help="what the gate's topics and services stand below (/gate)")
    gate.add_argument("--domain", type=int, metavar="N", help="the ROS domain, instead of ROS_DOMAIN_ID")
    gate.add_argument("--sim-time", action="store_true", help="stamps of commands are simulated time, as /clock says")
    gate.add_argument("--log", metavar="FILE", help="every command and handover, a JSON object a line")
    gate.add_argument("--quiet", action="store_true", help="print nothing")


def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    made = argparse.ArgumentParser(prog="rai-missions", description=ABOUT, epilog=EXIT)
    made.add_argument("--version", action="store_true", help="print the version")
    commands = made.add_subparsers(title="commands", dest="command", metavar="COMMAND")
    _add_run(commands)
    _add_reviews(commands)
    _add_diff(commands)
    _add_prove(commands)
    _add_tools(commands)
    _add_gate(commands)
    _add_world(commands)
    _add_watch(commands)
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns its exit status."""
    given = parser().parse_args(arguments)
    if given.version:
        from importlib.metadata import version

        print(f"rai_missions {version('rai_missions')}")
        return 0
    if given.command is None:
        parser().print_help()
        return 2
    from rai_missions.cli.redacted_stdout import redacted_output

    with redacted_output(controls=given.command in SHOWN):
        return _done(given)


def _done(given: argparse.Namespace) -> int:
    from rai_missions.cli.commands import command
    from rai_missions.errors import DefinitionError, MissionError

    try:
        return command(given.command)(given)
    except DefinitionError as error:
        print(error, file=sys.stderr)
        return 2
    except MissionError as error:
        print(f"rai-missions {given.command}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        sys.stderr.close()
        return 1
    except OSError as error:
        print(f"rai-missions {given.command}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
