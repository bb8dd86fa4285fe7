# SPDX-License-Identifier: Apache-2.0
"""The command line.

Rule: exit 0 the mission succeeded (or the check, proof or replay holds), 1 it ended otherwise, 2 the input is at fault.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

from rai_missions.cli.command import Command, Parser
from rai_missions.cli.commands import load_command, names

__all__ = ("main", "parser")

ABOUT = "Missions for robots: rules own the state, models only answer questions."
AFTER = (
    "'rai-missions COMMAND --help' explains a command.\n\n"
    "exit status: 0 it succeeded or holds, 1 it ended otherwise or does not hold, 2 the input is at fault"
)


def parser(complete: Callable[..., object] | None = None, *, is_whole: bool = True) -> Parser:
    """What reads the whole command line.

    Args:
        complete: What a shell completes, given patterns of files.
        is_whole: Whether it reads the arguments of the commands as well, not only their names.
    """
    made = Parser(prog="rai-missions", description=ABOUT, epilog=AFTER)
    made.add_argument("--version", action="store_true", help="print the version")
    commands = made.add_subparsers(title="commands", dest="command", metavar="COMMAND")
    for name in names():
        command = load_command(name)
        summary = command.summary[0].lower() + command.summary[1:].rstrip(".")
        texts = command.texts() if is_whole else {}
        added = commands.add_parser(name, help=summary, **texts)
        if is_whole:
            command.configure(added, complete)
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in names():
        command = load_command(words[0])
        given = command.read(words[1:])
        from rai_missions.cli.output import redacted_output

        with redacted_output(controls=command.draws):
            return _run(command, given)
    if words and not words[0].startswith("-"):
        from rai_missions.errors import suggestion

        parser(is_whole=False).error(f"there is no command {words[0]!r}{suggestion(words[0], names())}")
    root = parser(is_whole=False)
    if root.parse_args(words).version:
        from importlib.metadata import version

        print(f"rai_missions {version('rai_missions')}")
        return 0
    root.print_help()
    return 2


def _run(command: Command, given: dict[str, Any]) -> int:
    from rai_missions.errors import DefinitionError, MissionError

    try:
        return command(**given)
    except DefinitionError as error:
        print(error, file=sys.stderr)
    except BrokenPipeError:
        sys.stderr.close()
        return 1
    except (MissionError, OSError) as error:
        print(f"rai-missions {command.name}: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    return 2


if __name__ == "__main__":
    sys.exit(main())
