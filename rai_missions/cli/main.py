# SPDX-License-Identifier: Apache-2.0
"""The command line.

Rule: exit 0 the mission succeeded (or the check, proof or replay holds), 1 it ended otherwise, 2 the input is at fault;
128 and the number of a signal: it ended the command where nothing was under way that it could end in order. SIGPIPE
counts as one: what would be printed next has no reader.
"""

from __future__ import annotations

import atexit
import gc
import os
import shlex
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress

from rai_missions.cli.command import Command
from rai_missions.cli.commands import load_command, names, root_parser
from rai_missions.cli.streams import standard_streams
from rai_missions.runtime.interrupts import RaisedSignals, on_signals

__all__ = ("main", "run")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    raised, status = RaisedSignals(), 2
    with standard_streams():
        try:
            with on_signals(raised):
                if words and words[0] in names():
                    command = load_command(words[0])
                    with _last_work() if arguments is None and command.only_reads else nullcontext():
                        status = _run(command, words[1:], raised)
                else:
                    status = _without_command(words)
        except KeyboardInterrupt as interrupt:  # also while a command is still being imported
            raised.number = raised.number or (interrupt.args[0] if interrupt.args else signal.SIGINT)
        except BaseException:
            if not raised.number:  # else it is what became of the interrupt
                raise
        if raised.number:
            with suppress(OSError):  # the terminal may be gone
                print("interrupted", file=sys.stderr, flush=True)
            return 128 + raised.number
    return status


def run() -> int:
    """Run a mission: the command `run`, as an executable of that name."""
    return main(["run", *sys.argv[1:]])


@contextmanager
def _last_work() -> Iterator[None]:
    """Search rarely for garbage meanwhile, and not as the process ends: the system takes all memory back at once.

    Pydantic does without the plug-ins of other packages, for which it looks through all that is installed.
    """
    from rai_missions.mission.garbage import few_collections

    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "true")
    atexit.register(gc.freeze)
    with few_collections():
        yield


def _without_command(words: Sequence[str]) -> int:
    root = root_parser()
    if words and not words[0].startswith("-"):
        from rai_missions.errors import suggestion

        is_mission = words[0].endswith((".json", ".py"))
        run_it = f"; to run a mission, write: rai-missions run {shlex.quote(words[0])}" if is_mission else ""
        meant = run_it or _with_option(words[0]) or suggestion(words[0], names())
        root.error(f"there is no command {words[0]!r}{meant}")
    if root.parse_args(words).version:
        from importlib.metadata import version

        with suppress(OSError):  # as argparse does where no one reads its help
            print(f"rai_missions {version('rai_missions')}")
        return 0
    root.print_help()
    return 2


def _with_option(word: str) -> str:
    """The commands that have an option of this name, for the end of a sentence; empty where none has."""
    commands = (load_command(name) for name in names())
    usages = [usage for each in commands if (usage := each.usage_with(f"--{word}"))]
    return f"; it is an option: {', '.join(usages)}" if usages else ""


def _run(command: Command, words: Sequence[str], raised: RaisedSignals) -> int:
    given = command.read(words)
    from rai_missions.cli.output import redacted_output
    from rai_missions.errors import DefinitionError, MissionError, file_text

    with redacted_output(controls=command.draws):
        try:
            status = command(**given)
            with suppress(BrokenPipeError):  # its work is done
                sys.stdout.flush()
            return status
        except SystemExit as exit_:
            if exit_.code:
                raise
            import traceback

            *_, last = traceback.extract_tb(exit_.__traceback__)  # 0 is what a command returns, and raised by none
            where = f"{file_text(last.filename)}, line {last.lineno}, in {last.name}"
            print(
                f"rai-missions {command.name}: code that it called asked the program to exit ({where})", file=sys.stderr
            )
            return 1
        except BrokenPipeError:
            return 128 + signal.SIGPIPE
        except (MissionError, OSError) as error:
            if not raised.number:
                who = "" if isinstance(error, DefinitionError) else f"rai-missions {command.name}: "
                print(f"{who}{error}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
