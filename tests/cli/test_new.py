# SPDX-License-Identifier: Apache-2.0
"""`rai-missions new`: each template makes a mission that runs, checks, is proved, and has a test of its own."""

from __future__ import annotations

import json
import re
import resource
import runpy
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

from rai_missions.agents.talk.settings import conversation_faults, settings_of
from rai_missions.cli.main import main
from rai_missions.cli.templates import templates
from rai_missions.conversation import Dialogue, KeyView, MissionView, Speech, StatusView, Utterance
from rai_missions.mission.files import load
from rai_missions.profile import profile_of

TEMPLATES = [each.name for each in templates().values() if not each.is_example]
SLOW_TO_PROVE = {"patrol"}
COMMAND = re.compile(r"^\$ rai-missions (.+)$", re.MULTILINE)
NOT_RUN = re.compile(r"^<!-- not run: [^\n]*-->\n```console\n.*?^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def documented(folder: Path) -> list[list[str]]:
    """The commands of a README that need no person, as arguments; a run takes no longer than it must."""
    readme = NOT_RUN.sub("", (folder / "README.md").read_text(encoding="utf-8"))
    commands = [each.split() for each in COMMAND.findall(readme)]
    return [[*words, "--speed", "max"] if words[0] == "run" else words for words in commands]


@pytest.mark.parametrize("template", TEMPLATES)
def test_what_a_new_readme_shows_works_at_once(
    folder: Path, template: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["new", "first_try", "--template", template]) == 0
    assert "rai-missions run mission." in capsys.readouterr().out
    monkeypatch.chdir(folder / "first_try")
    commands = documented(Path())
    assert [words[0] for words in commands] == ["run", "check", "prove", "draw"]
    for words in commands:
        if words[0] == "prove" and template in SLOW_TO_PROVE:
            continue
        assert main(words) == 0, words
        printed = capsys.readouterr()
        assert "warning" not in printed.out + printed.err
        if words[0] == "run":
            assert (
                "question:" in printed.out and "accepted (“rule" in printed.out and "succeeded: 'done'" in printed.out
            )
    assert len(list(Path("journals").glob("first_try-*.journal"))) == 1
    assert Path("mission.svg").stat().st_size > 1000


ORDERS = {
    "delivery": {
        "bring the parcel": "You want: deliver the parcel. Is",
        "could you bring the parcel 4 metres away?": "deliver the parcel 4 m away",
    },
    "patrol": {"patrol, please": "patrol all places", "please make your round": "patrol all places"},
    "pick_and_place": {"put two parts into the tray": "put 2 parts into the tray"},
    "python": {"water the beds": "water the beds. Is"},
}


@pytest.mark.parametrize("template", TEMPLATES)
def test_its_robot_takes_the_orders_that_the_readme_names(folder: Path, template: str) -> None:
    assert main(["new", "first_try", "--template", template]) == 0
    mission = load(folder / "first_try" / templates()[template].mission)
    robot = profile_of(runpy.run_path(str(folder / "first_try/robot.py"))["robot"](), mission)
    assert conversation_faults(robot, mission) == ()
    takes = [
        KeyView(name, key.type, about=key.about, value=key.initial) for name, key in mission.keys_of("argument").items()
    ]
    view = StatusView(mode="ready", mission=mission.name, missions=(MissionView(mission.name, "", tuple(takes)),))
    for sentence, called in ORDERS[template].items():
        dialogue = Dialogue(settings_of(robot.conversation), view=view)
        out = dialogue.on_utterance(Utterance(sentence, "operator", "terminal", at=1.0), view)
        assert any(called in each.text for each in out if isinstance(each, Speech)), out


@pytest.mark.drill
@pytest.mark.parametrize("template", sorted(SLOW_TO_PROVE))
def test_every_run_of_a_large_template_is_proved(folder: Path, template: str) -> None:
    assert main(["new", "first_try", "--template", template]) == 0
    assert main(["prove", "first_try/mission.json"]) == 0


@pytest.mark.parametrize("template", TEMPLATES)
def test_its_files_name_the_mission_and_the_schemas_that_are_there(folder: Path, template: str) -> None:
    assert main(["new", "out/night_watch", "--template", template]) == 0
    made = folder / "out/night_watch"
    mission = next(made.glob("mission.[jp]*[ny]"))
    assert load(mission).name == "night_watch"
    assert {"README.md", "robot.py", "robot.ros.json", "test_mission.py"} < {path.name for path in made.iterdir()}
    assert not [path.name for path in made.iterdir() if "my_mission" in path.read_text(encoding="utf-8")]
    for path in made.glob("*.json"):
        if not path.name.endswith(".schema.json"):
            document = json.loads(path.read_text(encoding="utf-8"))
            schema = json.loads((made / document["$schema"]).read_text(encoding="utf-8"))
            jsonschema.Draft202012Validator(schema).validate(document)


@pytest.mark.installed
@pytest.mark.parametrize("template", TEMPLATES)
def test_its_own_test_passes(folder: Path, template: str) -> None:
    assert main(["new", "mine", "--template", template]) == 0
    tests = {name: item for name, item in runpy.run_path("mine/test_mission.py").items() if name.startswith("test_")}
    assert len(tests) == 3
    for test in tests.values():
        test()


@pytest.mark.drill
def test_pytest_finds_it(folder: Path) -> None:
    assert main(["new", "mine"]) == 0
    program = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:langsmith_plugin", "mine"]
    ran = subprocess.run(program, capture_output=True, text=True, timeout=120, check=False)
    assert "3 passed" in ran.stdout, ran.stdout + ran.stderr


def test_the_list_has_the_usual_one_first(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new", "--list"]) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert names == ["delivery", "patrol", "pick_and_place", "python", "desk", "rosbot", "tractor"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["mine", "--template", "deliverry"], "there is no template 'deliverry'; did you mean 'delivery'?"),
        (["My-Mission"], "'My-Mission' is none; did you mean 'my_mission'?"),
        (["Gärten am Fluß"], "'Gärten am Fluß' is none; did you mean 'garten_am_fluss'?"),
        (["out/2nd round"], "'2nd round' is none; did you mean 'out/nd_round'?"),
        (["full"], "'full' is there and not empty; name a folder that is new"),
        (["full/file"], "'full/file' is there and not empty"),
        (["full/file/mine"], "'full/file/mine' cannot be made"),
        ([], "name the folder to make: rai-missions new my_mission"),
    ],
)
def test_what_cannot_be_made_is_refused_with_the_remedy(
    folder: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "full").mkdir()
    (folder / "full/file").write_text("kept")
    assert main(["new", *words]) == 2
    assert message in capsys.readouterr().err
    assert [str(path.relative_to(folder)) for path in folder.rglob("*")] == ["full", "full/file"]
    assert (folder / "full/file").read_text() == "kept"


@pytest.mark.parametrize("is_there", [False, True])
def test_a_folder_that_cannot_be_filled_is_left_as_it_was(
    folder: Path, is_there: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    if is_there:
        (folder / "mine").mkdir()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, hard))  # the larger files of the template do not fit
    try:
        assert main(["new", "mine"]) == 2
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, ignored)
    assert "'mine' cannot be made" in capsys.readouterr().err
    assert [path.name for path in folder.rglob("*")] == ["mine"] * is_there
    assert main(["new", "mine"]) == 0


@pytest.mark.parametrize("template", templates())
def test_the_files_that_it_names_for_a_first_run_fit_each_other(
    folder: Path, template: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["new", "my_robots_first", "--template", template]) == 0
    cd, run = capsys.readouterr().out.splitlines()[-2:]
    monkeypatch.chdir(shlex.split(cd)[1])
    _, _, mission, *robot = shlex.split(run)
    assert main(["check", mission, *robot]) == 0


def test_a_folder_with_a_space_is_quoted_in_the_command_that_comes_next(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", "my robots/mine"]) == 0
    assert "cd 'my robots/mine'" in capsys.readouterr().out


def test_the_help_names_each_template(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["new", "--help"])
    words = set(re.findall(r"\w+", capsys.readouterr().out))
    assert not set(templates()) - words


def test_an_empty_folder_is_filled(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "mine").mkdir()
    monkeypatch.chdir(folder / "mine")
    assert main(["new", "."]) == 0
    assert load("mission.json").name == "mine"


def test_a_delivery_that_is_blocked_before_its_detector_reports_waits_and_looks_again(folder: Path) -> None:
    assert main(["new", "made"]) == 0
    robot = folder / "made/robot.py"
    late = 'made.write("obstacle", corridor.seen())\n', "late.append(corridor.position_m)\n"
    silent = "(corridor.seen)", "(lambda: corridor.seen() if late else None)"
    text = robot.read_text(encoding="utf-8")
    assert all(text.count(before) == 1 for before, _ in (late, silent))
    robot.write_text(f"{text.replace(*late).replace(*silent)}\n\nlate: list[float] = []\n", encoding="utf-8")
    command = ["run", "made/mission.json", "--robot", "made/robot.py", "--no-operator", "--speed", "max"]
    assert main(command) == 0
