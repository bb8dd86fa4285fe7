# SPDX-License-Identifier: Apache-2.0
"""A command is one file: a typed function whose parameters are the arguments and whose docstring is the help."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from rai_missions.cli import commands
from rai_missions.cli.commands import load_command, names
from rai_missions.cli.main import main

COUNT = '''
"""A command of another package."""

from typing import Annotated, Literal

from rai_missions.cli.command import Argument, command


@command()
def count(
    upto: int,
    start: Annotated[int | None, Argument("FROM")] = None,
    *,
    word: tuple[Annotated[str, Argument("WORD", "-w")], ...] = (),
    case: Literal["lower", "upper"] = "lower",
    port: Annotated[int | None, Argument("PORT", bare="80")] = None,
    pause: float = 0.0,
    is_loud: bool = False,
) -> int:
    """Count to a number.

    It takes 100 % of the time.

    Args:
        upto: The last number.
        start: The first number,
            which is 0 without it.
        word: A word; may be repeated.
        case: How it is
            written.
        port: Where.
        pause: Seconds between two.
        is_loud: Print 100 % of it.

    Exit status:
        0 it counted, 2 the input is at fault

    Example:
        rai-missions count 3
        rai-missions count 3 --case upper
    """
    print(upto, start, word, case, port, is_loud)
    return upto % 2
'''


@pytest.fixture
def _count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "count.py").write_text(COUNT)
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    monkeypatch.delitem(sys.modules, "rai_missions.cli.commands.count", raising=False)


@pytest.mark.usefixtures("_count")
def test_a_command_is_added_by_a_file(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "count to a number\n" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["count", "--help"])
    shown = capsys.readouterr().out
    for text in (
        "usage: rai-missions count [-h] [-w WORD] [--case {lower,upper}]\n",
        "\nCount to a number.\n\nIt takes 100 % of the time.\n",
        "FROM                  The first number, which is 0 without it.\n",
        "How it is written. (default: lower)\n",
        "--is-loud             Print 100 % of it.\n",
        "\nexit status: 0 it counted, 2 the input is at fault\n",
        "\nexample:\n  rai-missions count 3\n  rai-missions count 3 --case upper\n",
    ):
        assert text in shown
    # Python 3.13 names the value of an option once.
    assert re.search(r"-w(?: WORD)?, --word WORD +A word; may be repeated\.\n", shown)
    main(["completion", "fish"])
    assert "is-loud" in capsys.readouterr().out


@pytest.mark.usefixtures("_count")
@pytest.mark.parametrize(
    ("words", "given"),
    [
        ("4", "4 None () lower None False"),
        ("4 2", "4 2 () lower None False"),
        ("-w a 4 --word b -1 -w c", "4 -1 ('a', 'b', 'c') lower None False"),
        ("4 --port 3 --is-loud 2 --case upper", "4 2 () upper 3 True"),
        ("4 --port", "4 None () lower 80 False"),
        ("--word=x=-1 4", "4 None ('x=-1',) lower None False"),
    ],
)
def test_words_of_a_command_line_become_typed_arguments_in_any_order(
    words: str, given: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["count", *words.split()]) == 0
    assert capsys.readouterr().out == f"{given}\n"


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ("run m.json robot.py", "write --robot robot.py or --guards robot.py"),
        ("run m.json x.journal", "write --resume x.journal or --journal x.journal"),
        ("draw m.json x.journal", "write --journal x.journal"),
        ("run m.json x.txt", "unrecognized arguments: x.txt"),
    ],
)
def test_a_file_that_lacks_its_option_is_answered_with_those_that_take_its_ending(
    words: str, options: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(words.split())
    assert capsys.readouterr().err.rstrip().endswith(options)


@pytest.mark.usefixtures("_count")
@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("cuont 3", "rai-missions: error: there is no command 'cuont'; did you mean 'count'?"),
        ("m.json", "there is no command 'm.json'; to run a mission, write: rai-missions run m.json"),
        (
            "is-loud",
            "rai-missions: error: there is no command 'is-loud'; it is an option: rai-missions count UPTO [FROM] --is",
        ),
        ("count", "rai-missions count: error: the following arguments are required: upto"),
        ("count 1 2 3", "rai-missions count: error: unrecognized arguments: 3"),
        (
            "count 1 --is-lowd",
            "rai-missions count: error: unrecognized arguments: --is-lowd; did you mean '--is-loud'?",
        ),
        ("count 1 --wurd=3", "rai-missions count: error: unrecognized arguments: --wurd=3; did you mean '--word'?"),
        ("count x", "argument upto: 'x' is no whole number, such as 3"),
        ("count 1 --port 8o", "argument --port: '8o' is no whole number, such as 3"),
        ("count 1 --pause 1,5", "argument --pause: '1,5' is no number, such as 2.5"),
        ("count 1 --pause nan", "argument --pause: 'nan' is no number, such as 2.5"),
        ("count 1 --case Upper", "invalid choice: 'Upper' (choose from "),
        ("count 1 --word", "rai-missions count: error: argument -w/--word: expected one argument"),
        (
            "count 1 --case upper --case lower",
            "argument --case: 'upper' and 'lower' are given, and it has one value; give one",
        ),
        ("count 1 --port --port 3", "argument --port: 80 and 3 are given, and it has one value; give one"),
        ("--versiom", "rai-missions: error: unrecognized arguments: --versiom"),
    ],
)
def test_words_that_are_at_fault_are_named_on_stderr(
    words: str, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    shown = capsys.readouterr()
    assert sentence in shown.err and shown.out == ""


def test_without_a_command_the_help_is_printed_and_the_status_is_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert capsys.readouterr().out.startswith("usage: rai-missions ")


@pytest.mark.parametrize("name", names())
def test_the_help_of_a_command_has_a_line_for_each_argument_and_an_example_that_it_reads(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = load_command(name)
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    shown = capsys.readouterr().out
    status, _, examples = shown.rpartition("\n\nexample:\n")
    assert "\nexit status: 0 " in status and examples
    for parameter in command.parameters():
        assert len(parameter.help) > 10 and parameter.help.endswith((".", "?")), parameter.name
    for example in examples.splitlines():
        _, _, words = example.partition(f"rai-missions {name}")
        command.read(words.partition(">")[0].split())


def test_no_command_loads_what_it_needs_to_run_before_it_runs() -> None:
    program = (
        "import sys; from rai_missions.cli.commands import whole_parser; whole_parser(lambda *_: None);"
        "print([name for name in ('pydantic', 'shtab', 'visualize', 'rich', 'inspect') if name in sys.modules])"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout == "[]\n"


@pytest.mark.parametrize("name", names())
def test_the_name_of_a_file_is_never_empty(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """As it is where a shell's variable is not set: `diff old.json "$NEW"` compared a mission with itself."""
    parameters = load_command(name).parameters()
    for empty in [each for each in parameters if each.argument.files]:
        words = []
        for each in parameters:
            value = "" if each is empty else str(next(iter(getattr(each.kind, "__args__", ())), "1"))
            if each is empty or each.is_required or (each.argument.is_positional and empty.argument.is_positional):
                words += [value] if each.argument.is_positional else [each.flag, value]
        with pytest.raises(SystemExit) as ended:
            main([name, *words])
        assert ended.value.code == 2
        assert "the name of the file is empty; is a variable of the shell not set?" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "is_left"), [("", True), ("['schema']", False), ("['completion', 'bash']", False)])
def test_a_process_whose_command_only_reads_leaves_its_garbage_to_the_system(words: str, is_left: bool) -> None:
    """The last search of a process visits all that is alive: half of what `check` takes. A caller keeps its own."""
    program = (
        "import atexit, gc, os, sys;"
        "atexit.register(lambda: print(gc.get_freeze_count() > 0, file=sys.stderr));"
        "from rai_missions.cli.main import main; sys.argv = ['rai-missions', 'schema'];"
        f"main({words}); print('PYDANTIC_DISABLE_PLUGINS' in os.environ, file=sys.stderr)"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout and ran.stderr.split() == [str(is_left)] * 2


def test_a_proof_without_a_refutation_leaves_journals_unimported() -> None:
    program = (
        "import sys; from rai_missions.cli.main import main;"
        "main(['prove', 'missions/tractor/mission.json', '--states', '20']);"
        "print([name for name in ('rai_missions.journal', 'sqlite3') if name in sys.modules], file=sys.stderr)"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stderr.splitlines()[-1] == "[]"


def test_no_command_that_runs_something_leaves_its_garbage() -> None:
    """A robot's driver may end its work as it is destroyed."""
    readers = {name for name in names() if load_command(name).only_reads}
    assert readers == {"check", "diff", "draw", "prove", "schema", "textconv", "verify"}
