# SPDX-License-Identifier: Apache-2.0
"""A package of others brings a guard, an activity, a connector, a world and an exporter: every verb takes them.

`installed/` is what an installer would have made of that package; a test that needs another lays it out by itself.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import pytest
from pydantic_core import PydanticCustomError

from rai_missions.agents import run
from rai_missions.check import check
from rai_missions.cli.main import main
from rai_missions.connectors.registry import check_connector
from rai_missions.engine import Chart
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Event
from rai_missions.guards import Compare, Fresh, Guard, Site
from rai_missions.guards.contract import check_kind
from rai_missions.guards.guard import foreign_truth
from rai_missions.guards.view import Operand
from rai_missions.journal import Header, Journal, read
from rai_missions.keys import Key
from rai_missions.mission.files import dump, load
from rai_missions.mission.mission import Mission
from rai_missions.mission.renaming import Names, renamed
from rai_missions.model import Path as Path_
from rai_missions.model.validation_errors import validated
from rai_missions.profile import load_profile, parse_profile
from rai_missions.profile import robot_facts as facts_of
from rai_missions.prove import prove
from rai_missions.replay.replay import replay
from rai_missions.states import State
from rai_missions.testing import check_activity, check_agent, check_answerer, check_guard, check_voice, check_world
from rai_missions.testing import check_connector as check_connector_contract
from rai_missions.voice.kind import known
from rai_missions.worlds import open_world
from visualize import FORMATS, difference, draw, drawn, picture

HERE = Path(__file__).parent
MISSION, ROBOT = HERE / "mission.json", HERE / "robot.json"
BETWEEN = {"between": "humidity", "low": 0.4, "high": 0.6}


@pytest.fixture(autouse=True)
def _installed(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if "absent" not in request.fixturenames:
        monkeypatch.syspath_prepend(str(HERE / "installed"))


@pytest.fixture
def absent() -> None:
    """The package is not installed."""


def fault(make: Callable[[], Any]) -> str:
    with pytest.raises((DefinitionError, UsageError)) as caught:
        make()
    return str(caught.value)


def document(**words: Any) -> dict[str, Any]:
    return json.loads(MISSION.read_text(encoding="utf-8")) | words


def written(folder: Path, data: dict[str, Any]) -> Path:
    file = folder / "mission.json"
    file.write_text(json.dumps(data), encoding="utf-8")
    return file


# -- each verb ---------------------------------------------------------------------------------------------------------


def test_a_mission_of_foreign_kinds_is_loaded_and_written_as_it_was() -> None:
    mission = load(MISSION)
    assert json.loads(dump(mission))["states"] == document()["states"]
    assert mission.packages() == {"orchard-kinds": "1.2"}


def test_it_is_checked_and_a_foreign_guard_is_held_to_the_keys_that_its_fields_name(tmp_path: Path) -> None:
    assert check(load(MISSION)) == ()
    file = written(tmp_path, json.loads(MISSION.read_text().replace('"between": "humidity"', '"between": "humidty"')))
    found = [str(finding) for finding in check(load(file)) if finding.rule == "unknown-key"]
    assert found and all("no key 'humidty'; did you mean 'humidity'?" in each for each in found)
    assert found[0].startswith("/states/watching/transitions/0/when/not/between")


@pytest.mark.parametrize("form", sorted(FORMATS.keys() - {"png"}))
def test_it_is_drawn(form: str) -> None:
    text = drawn(picture(load(MISSION)), form).decode()
    assert "humidity from 0.4 to 0.6" in text
    assert "2 strikes of bell" in text or form == "md"


def test_it_has_a_review_page(tmp_path: Path) -> None:
    page = draw(load(MISSION), tmp_path / "m.html").read_text(encoding="utf-8")
    assert "2 strikes of bell" in page and "humidity from 0.4 to 0.6" in page


def test_two_of_them_are_compared(tmp_path: Path) -> None:
    wider = written(tmp_path, json.loads(MISSION.read_text().replace('"high": 0.6', '"high": 0.7')))
    changes = [str(change) for change in difference(load(MISSION), load(wider)).changes]
    assert any("watered: requires weakened" in each for each in changes), changes
    more = written(tmp_path, json.loads(MISSION.read_text().replace('"strikes": 2', '"strikes": 3')))
    assert any("'strikes' changed" in str(each) for each in difference(load(MISSION), load(more)).changes)


def test_it_runs_in_a_foreign_world_and_its_journal_names_the_package_and_is_replayed(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    result = run(load(MISSION), robot=ROBOT, journal=path, speed=float("inf"))
    assert (result.outcome, result.open_goals) == ("succeeded", ())
    with read(path) as record:
        assert record.header.versions["orchard-kinds"] == "1.2"
    again = replay(path)
    assert again.holds and again.steps > 5


def test_packages_are_found_where_the_working_directory_was_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    assert load(MISSION) == Mission.model_validate(document())
    assert open_world("greenhouse").period_s > 0


def test_it_is_proved_with_the_values_that_the_guard_distinguishes_and_the_replies_that_are_awaited() -> None:
    robot = load_profile(ROBOT)
    proof = prove(load(MISSION), robot_facts=facts_of(robot))
    assert [claim.name for claim in proof.claims if claim.verdict != "proved"] == []
    assert (proof.is_whole, proof.sampled, proof.never) == (True, (), ())


def test_it_is_restored_from_plain_data() -> None:
    data = document()
    del data["states"]["watching"]["transitions"][1]
    mission = Mission(**data)
    chart = Chart(mission)
    chart.start(0.0)
    chart.write("humidity", 0.3, at=1.0)
    step = chart.send(Event("succeeded", 2.0, {}, "result", 1))
    assert chart.active == {"ringing"} and step.wake_at == 4.0
    other = Chart.restore(mission, unpacked(packed(chart.snapshot())))
    assert other.send(Event("tick", 4.0, {}, "tick")).effects == chart.send(Event("tick", 4.0, {}, "tick")).effects


def test_what_its_fields_refer_to_is_renamed() -> None:
    def same(given: Any) -> Any:
        return given

    names = Names(same, lambda key: f"green/{key}", same, same, same)
    guard = renamed(load(MISSION), names).states["watered"].written()["requires"]
    assert guard == BETWEEN | {"between": "green/humidity"}


def test_a_foreign_connector_carries_a_run(tmp_path: Path) -> None:
    robot = json.loads(ROBOT.read_text()) | {"connector": {"kind": "tin_can", "humidity": 0.2}}
    file = tmp_path / "robot.json"
    file.write_text(json.dumps(robot))
    data = json.loads(MISSION.read_text().replace('"every_s": 2', '"every_s": 0.05'))
    path = tmp_path / "run.journal"
    assert run(load(written(tmp_path, data)), robot=file, journal=path).outcome == "succeeded"
    assert replay(path).holds


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("def open_connector(options): ...", "cannot be opened (TypeError: open_connector() got an unexpected keyword"),
        ("def open_connector(options, *, now=None): 1 / 0", "cannot be opened (ZeroDivisionError: division by zero"),
        ("", "cannot be opened (AttributeError: module 'radio' has no attribute 'open_connector'"),
        ("import sys\nsys.exit(0)", "does not load (SystemExit: 0)"),
        ("def open_connector(options, *, now=None): raise SystemExit(0)", "cannot be opened (SystemExit: 0"),
        ("def open_connector(options, *, now=None): return 7", "opens 7, which is no connector: it lacks 'modes'"),
    ],
)
def test_a_foreign_connector_that_cannot_be_opened_is_refused_by_name(tmp_path: Path, code: str, why: str) -> None:
    laid_out(tmp_path, "radio", "1.0", offers="[rai_missions.connectors]\nradio = radio\n", code=code)
    sys.path.insert(0, str(tmp_path))
    try:
        robot = parse_profile(ROBOT.read_text(encoding="utf-8")).model_copy(update={"connector": {"kind": "radio"}})
        assert fault(lambda: run(MISSION, robot=robot)).startswith(f"the connector 'radio' of radio 1.0 {why}")
    finally:
        del sys.path[0]
        sys.modules.pop("radio", None)


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("def __init__(self): raise OSError('no licence')", "cannot be opened (OSError: no licence)"),
        ("def __init__(self): 1 / 0", "cannot be opened (ZeroDivisionError: division by zero)"),
        (
            "def step(self): ...\n    def open(self, connector): raise RuntimeError('no room')",
            "cannot be opened (RuntimeError: no room)",
        ),
        ("def __repr__(self): return 'a moon'", "opens a moon, which is no world: it lacks 'step'"),
    ],
)
def test_a_foreign_world_that_cannot_be_opened_is_refused_by_name(tmp_path: Path, code: str, why: str) -> None:
    world = f"class World:\n    at, period_s, open, close = 0.0, 0.1, print, print\n    {code}\n"
    laid_out(tmp_path, "moon", "1.0", offers="[rai_missions.worlds]\nmoon = moon:World\n", code=world)
    sys.path.insert(0, str(tmp_path))
    try:
        connector = {"kind": "local", "world": "moon"}
        robot = parse_profile(ROBOT.read_text(encoding="utf-8")).model_copy(update={"connector": connector})
        assert fault(lambda: run(MISSION, robot=robot)) == f"the world 'moon' of moon 1.0 {why}"
    finally:
        del sys.path[0]
        sys.modules.pop("moon", None)


def test_a_foreign_world_that_exits_ends_no_run_as_one_that_succeeded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    world = "class World:\n    at, period_s, open, close = 0.0, 0.1, print, print\n"
    world += "    def step(self): raise SystemExit(0)\n"
    laid_out(tmp_path, "moon", "1.0", offers="[rai_missions.worlds]\nmoon = moon:World\n", code=world)
    sys.path.insert(0, str(tmp_path))
    robot = tmp_path / "robot.json"
    robot.write_text(json.dumps(json.loads(ROBOT.read_text()) | {"connector": {"kind": "local", "world": "moon"}}))
    try:
        asked = ["run", str(MISSION), "--robot", str(robot), "--no-operator", "--journal", str(tmp_path / "j")]
        assert main(asked) == 1
        why = f"run: code that it called asked the program to exit ({tmp_path}/moon/__init__.py, line 3, in step)"
        assert why in capsys.readouterr().err
    finally:
        del sys.path[0]
        sys.modules.pop("moon", None)


def test_a_foreign_world_whose_clock_cannot_continue_refuses_a_resume_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    world = "class World:\n    at, period_s, open, step, close = 0.0, 0.1, print, print, print\n"
    laid_out(tmp_path, "moon", "1.0", offers="[rai_missions.worlds]\nmoon = moon:World\n", code=world)
    sys.path.insert(0, str(tmp_path))
    try:
        robot = json.loads(ROBOT.read_text()) | {"connector": {"kind": "local", "world": "moon"}}
        header = Header(dump(load(MISSION)), json.dumps(robot), versions={"orchard-kinds": "1.2"})
        with Journal.create(tmp_path / "run.journal", header) as journal:
            chart = Chart(load(MISSION))
            for step in (chart.write("humidity", 0.5), chart.start()):
                journal.write(step, since=0.0)
        assert main(["run", "--resume", str(tmp_path / "run.journal"), "--no-operator"]) == 2
        why = "the world 'moon' of moon 1.0 takes no option 'start_s', at which its clock would continue"
        assert why in capsys.readouterr().err
    finally:
        del sys.path[0]
        sys.modules.pop("moon", None)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: check_connector("tin_cn"), "did you mean 'tin_can'?"),
        (lambda: check_connector("radio"), "there is: local, mqtt, ros2, tin_can"),
        (lambda: open_world("grenhouse"), "did you mean 'greenhouse'?"),
        (lambda: open_world("moon"), "there is: desk, greenhouse, house, orchard"),
        (lambda: known("recogniser", "ear"), "there is: canary, pocketsphinx, whisper"),
        (lambda: known("voice", "lark"), "there is: canary, espeak, flite, kokoro, piper"),
        (lambda: Guard.read({"betwen": "humidity"}), "did you mean 'between'?"),
        (lambda: State.read({"inspct": "fridge"}), "did you mean 'inspect'?"),
        (lambda: draw(load(MISSION), "m.outlin"), ".md, .html, .outline"),
    ],
)
def test_an_unknown_name_is_answered_with_what_installed_packages_bring(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, make: Callable[[], Any], named: str
) -> None:
    offers = "[rai_missions.recognisers]\ncanary = canary:ears\n[rai_missions.voices]\ncanary = canary:song\n"
    monkeypatch.syspath_prepend(str(laid_out(tmp_path, "canary", "1.0", offers=offers, code="1 / 0")))
    with pytest.raises((DefinitionError, UsageError, PydanticCustomError), match=re.escape(named)):
        make()


@pytest.mark.parametrize("options", [{"humid": 0.2}, {"humidity": "much"}])
def test_check_finds_the_options_of_a_foreign_connector_that_a_run_refuses(
    tmp_path: Path, options: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "robot.json"
    file.write_text(json.dumps(json.loads(ROBOT.read_text()) | {"connector": {"kind": "tin_can", **options}}))
    refusal = fault(lambda: run(MISSION, robot=file))
    assert main(["check", str(MISSION), "--robot", str(file)]) == 2
    assert f"{file}: /connector: {refusal}" in capsys.readouterr().err


def test_a_foreign_exporter_makes_files_of_its_ending(tmp_path: Path) -> None:
    file = draw(load(MISSION), tmp_path / "mission.outline")
    assert "ringing 2 strikes of bell" in file.read_text().splitlines()
    assert "the endings are .svg" in fault(lambda: draw(load(MISSION), tmp_path / "mission.nothing"))


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("def lines(picture): return 'text'", "makes 'text' of a picture; an exporter makes bytes"),
        ("def lines(picture): return picture.nodes[99]", "failed (IndexError: tuple index out of range)"),
        ("", "does not load (AttributeError: module 'liner' has no attribute 'lines')"),
    ],
)
def test_a_foreign_exporter_that_makes_no_bytes_is_refused_by_name_and_leaves_no_file(
    tmp_path: Path, code: str, why: str
) -> None:
    laid_out(tmp_path, "liner", "1.0", offers="[rai_missions.exporters]\nlines = liner:lines\n", code=code)
    sys.path.insert(0, str(tmp_path))
    try:
        text = fault(lambda: draw(load(MISSION), tmp_path / "mission.lines"))
        assert text == f"the exporter 'lines' of liner 1.0 {why}"
        assert not (tmp_path / "mission.lines").exists()
    finally:
        del sys.path[0]
        sys.modules.pop("liner", None)


# -- contracts ---------------------------------------------------------------------------------------------------------


def test_a_foreign_guard_and_ours_keep_the_contract_of_guards() -> None:
    keys = {"humidity": Key(float, source="robot"), "other": Key(float, source="robot")}
    facts = [{}, {"humidity": 0.5}, {"humidity": 0.9, "other": 1.0}]
    between = load(MISSION).states["watered"].requires
    for guard in (
        between,
        Compare(key="humidity", less=0.5),
        Fresh("humidity"),
        between & ~Fresh("other"),
        between.held_for(2),
    ):
        check_guard(guard, keys, facts)


@pytest.mark.parametrize("given", [Compare, 3, None, {"key": "humidity", "<": 1}], ids=repr)
def test_what_is_none_of_a_kind_is_held_to_no_contract(given: Any) -> None:
    for contract, sort in ((check_guard, "guard"), (check_activity, "activity")):
        with pytest.raises(UsageError, match=f"to its contract is held one {sort}, made by its class, and not "):
            contract(given, {}, [])


class Louder(Guard, word="louder"):
    """A guard as a package's author writes it, without a constructor of its own."""

    louder: Path_
    than: float


def test_a_wrong_word_in_python_of_a_kind_without_a_constructor_names_the_nearest_field() -> None:
    make: Any = Louder
    with pytest.raises(DefinitionError, match=r"/then: a guard with 'louder' has no 'then'; did you mean 'than'\?"):
        make(louder="noise", then=3.0)


@pytest.mark.parametrize(("contract", "kind"), [
    (check_agent, "an agent"), (check_answerer, "an answerer"), (check_connector_contract, "a connector"),
    (lambda given: check_world(given, ["/x"]), "a world"),
])  # fmt: skip
def test_a_contract_that_makes_its_own_is_given_no_made_one(contract: Callable[[Any], None], kind: str) -> None:
    with pytest.raises(UsageError, match=rf" takes what makes {kind}, not .*; give its class, or a function$"):
        contract(object())


def test_what_a_contract_makes_has_the_methods_of_its_kind() -> None:
    with pytest.raises(AssertionError, match=r"object has no 'run'; an agent has run\(\) and stop\(\)"):
        check_agent(object)  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="check_answerer takes what makes an answerer, not "):
        check_answerer(object)  # type: ignore[arg-type]


def test_a_contract_that_is_given_nothing_to_look_at_is_not_kept() -> None:
    with pytest.raises(UsageError, match="on facts: give blackboards"):
        check_guard(Fresh("humidity"), {"humidity": Key(float, source="robot")}, [])
    with pytest.raises(UsageError, match="by what it publishes: give topics"):
        check_world(lambda: open_world("orchard", seed=1), [])
    with pytest.raises(UsageError, match="by what it speaks: give texts"):
        check_voice(lambda: pytest.fail("a voice is opened"), iter(()))


def test_facts_that_make_no_difference_to_a_guard_hold_it_to_nothing() -> None:
    with pytest.raises(AssertionError, match="'key' is None whatever is known; give facts on which it is another"):
        check_guard(Compare(key="humidity", less=0.5), {"humidity": Key(float, source="robot")}, [{}, {"other": 1.0}])


def test_topics_of_a_world_that_are_one_text_are_refused() -> None:
    with pytest.raises(UsageError, match=r"the topics of a world are a list, \['/humidity'\], not one text"):
        check_world(lambda: open_world("orchard", seed=1), "/humidity")


class Strange(Guard):
    """Reads what it does not name, changes what it reads, and returns seven."""

    word: ClassVar = "strange"
    key: Path_

    def compile(self, site: Site) -> Any:
        if self.key == "more":
            Operand("other", site)
        return (lambda view: 7) if self.key == "seven" else view_cleared

    def words(self) -> str:
        return "strange"


def view_cleared(view: Any) -> None:
    view.board.clear()


@pytest.mark.parametrize(
    ("key", "named"), [("more", "reads what none"), ("seven", "neither true, false"), ("clears", "changes the black")]
)
def test_a_guard_that_breaks_a_promise_is_named(key: str, named: str) -> None:
    keys = {"other": Key(float, source="robot")}
    with pytest.raises(AssertionError, match=named):
        check_guard(Strange(key=key), keys, [{"other": 1.0}])


def test_a_constant_of_a_frozen_class_is_no_impurity(tmp_path: Path) -> None:
    above = (
        "import dataclasses\n\n@dataclasses.dataclass(frozen=True)\nclass Bound:\n    low: float\n\nLOW = Bound(0.1)"
    )
    text = guard_of(tmp_path, "calm", "LOW == Bound(0.1)", above=above, names_nothing=True)
    assert "impure" not in text and 'add "uses"' in text


# -- refusals, by name -------------------------------------------------------------------------------------------------


def test_a_mission_names_which_packages_it_uses() -> None:
    text = fault(lambda: Mission(**document(uses=[])))
    assert "the guard 'between' of orchard-kinds 1.2" in text or "the activity 'strikes' of orchard-kinds 1.2" in text
    assert 'add "uses": ["orchard-kinds>=1.2"]' in text


@pytest.mark.usefixtures("absent")
def test_a_package_that_is_missing_is_named(tmp_path: Path) -> None:
    text = fault(lambda: load(MISSION))
    assert "/uses/0: the package 'orchard_kinds' is not installed; pip install 'orchard_kinds>=1.2'" in text


@pytest.mark.usefixtures("absent")
def test_a_journal_whose_package_is_missing_or_of_another_version_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.journal"
    with monkeypatch.context() as there:
        there.syspath_prepend(str(HERE / "installed"))
        run(load(MISSION), robot=ROBOT, journal=path, speed=float("inf"))
    assert "row 0" in fault(lambda: replay(path)) and "'orchard_kinds' is not installed" in fault(lambda: replay(path))
    laid_out(tmp_path / "newer", "orchard_kinds", "2.0", from_=HERE / "installed")
    monkeypatch.syspath_prepend(str(tmp_path / "newer"))
    text = fault(lambda: replay(path))
    assert "made with orchard-kinds 1.2, and 2.0 is installed; pip install 'orchard-kinds==1.2'" in text


def test_another_version_than_the_mission_asks_for_is_refused() -> None:
    text = fault(lambda: Mission(**document(uses=["orchard_kinds>=2"])))
    assert "'orchard_kinds' is installed in version 1.2, and >=2 is needed" in text
    assert "names no package" in fault(lambda: Mission(**document(uses=["no package at all"])))


def laid_out(
    folder: Path, package: str, version: str, *, offers: str = "", code: str = "", from_: Path | None = None
) -> Path:
    """A package as an installer would have laid it out."""
    if from_ is not None:
        shutil.copytree(from_ / package, folder / package)
        offers = (from_ / f"{package}-1.2.dist-info" / "entry_points.txt").read_text()
    else:
        (folder / package).mkdir(parents=True)
        (folder / package / "__init__.py").write_text(code)
    meta = folder / f"{package}-{version}.dist-info"
    meta.mkdir()
    (meta / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: {version}\n")
    (meta / "entry_points.txt").write_text(offers)
    return folder


GUARD = """
from typing import ClassVar
from rai_missions.guards import Guard, Site, Test
{above}

class {name}(Guard, word="{word}"):
    {word}: str

    def compile(self, site: Site) -> Test:
        {before}
        return lambda view: {value}

    def words(self) -> str:
        return "{word}"
"""


def guard_of(
    folder: Path,
    word: str,
    value: str,
    *,
    above: str = "",
    before: str = "pass",
    package: str = "",
    offered: str = "",
    names_nothing: bool = False,
) -> str:
    """The error of loading a mission that uses a guard of a package of its own."""
    package = package or f"kinds_{folder.name}"
    code = GUARD.format(name="Odd", word=word, value=value, above=above, before=before)
    offers = f"[rai_missions.guards]\n{offered or word} = {package}:Odd\n"
    sys.path.insert(0, str(laid_out(folder / "site", package, "1.0", offers=offers, code=code)))
    try:
        transition = {"when": {offered or word: "x"}, "to": "b"}
        states = {"a": {"transitions": [transition]}, "b": {"final": "aborted"}}
        return fault(lambda: Mission("m", uses=[] if names_nothing else [package], initial="a", states=states))
    finally:
        del sys.path[0]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"between": 7}, "/between: 7 is not text; write a word in quotes"),
        ({"lower": 0.1}, "/lower: a guard with 'between' has no 'lower'; did you mean 'low'?"),
        ({"low": "much"}, "/low: 'much' is not a number; write one, without quotes"),
    ],
)
def test_a_wrong_word_of_a_foreign_kind_is_a_fault_like_any_other(given: dict[str, Any], expected: str) -> None:
    states = {"a": {"transitions": [{"when": {**BETWEEN, **given}, "to": "b"}]}, "b": {"final": "aborted"}}
    text = fault(lambda: validated(Mission, {"name": "m", "uses": ["orchard_kinds"], "initial": "a", "states": states}))
    assert text == f"/states/a/transitions/0/when{expected}"


@pytest.mark.parametrize(
    ("method", "why"),
    [
        ("made", "KeyError: 'boom'"), ("outcomes", "KeyError: 'boom'"), ("activity", "KeyError: 'boom'"),
        ("made(self): return 'a tree'", "'made' gives 'a tree', which is no tree"),
        ("outcomes(self): return 'ended'", "'outcomes' gives 'ended', which is no set of names"),
        ("activity(self): return 7", "'activity' gives 7, which is no text"),
        ("words(self): return 7", "'words' gives 7, which is no text"), ("words", "KeyError: 'boom'"),
    ],
)  # fmt: skip
def test_a_kind_whose_code_raises_or_makes_what_is_of_no_use_is_refused_where_it_is_written(
    tmp_path: Path, method: str, why: str
) -> None:
    package, is_guard = f"kinds_{tmp_path.name}", method.startswith("words")
    of, group = ("Guard", "guards") if is_guard else ("State", "activities")
    body = method if ":" in method else f"{method}(self): raise KeyError('boom')"
    code = (
        f"from rai_missions.guards.guard import Guard\nfrom rai_missions.states import State\n\n"
        f"class Odd({of}, word='odd'):\n    odd: str\n    def compile(self, site): return lambda view: True\n"
        f"    def machine(self, bench): return None\n    def {body}\n"
    )
    site = laid_out(tmp_path, package, "1.0", offers=f"[rai_missions.{group}]\nodd = {package}:Odd\n", code=code)
    sys.path.insert(0, str(site))
    try:
        state = {"transitions": [{"when": {"odd": "x"}, "to": "b"}]} if is_guard else {"odd": "x"}
        states = {"a": state, "b": {"final": "aborted"}}
        text = fault(lambda: Mission("m", uses=[package], initial="a", states=states))
    finally:
        del sys.path[0]
    sort, place = ("guard", "/states/a/transitions/0/when") if is_guard else ("activity", "/states/a")
    assert text == f"Mission(…): {place}: the {sort} 'odd' of {package.replace('_', '-')} 1.0 cannot be used: {why}"


@pytest.mark.parametrize(
    ("of", "methods", "why"),
    [
        ("Guard", "compile", "it lacks 'words'"), ("Guard", "words", "it lacks 'compile'"),
        ("Guard", "wrds", "it lacks 'compile' and 'words'"),
        ("State", "mde", "it has neither 'made' nor 'machine', so it runs nothing"),
    ],
)  # fmt: skip
def test_a_kind_that_lacks_a_method_is_refused_where_it_is_written_and_by_its_contract(
    tmp_path: Path, of: str, methods: str, why: str
) -> None:
    package, sort = f"kinds_{tmp_path.name}", "guard" if of == "Guard" else "activity"
    code = (
        "from rai_missions.guards.guard import Guard\nfrom rai_missions.states import State\n\n"
        f"class Odd({of}, word='odd'):\n    odd: str = 'x'\n    def {methods}(self, *_): return 'odd'\n"
    )
    group = "guards" if of == "Guard" else "activities"
    site = laid_out(tmp_path, package, "1.0", offers=f"[rai_missions.{group}]\nodd = {package}:Odd\n", code=code)
    sys.path.insert(0, str(site))
    try:
        state = {"transitions": [{"when": {"odd": "x"}, "to": "b"}]} if of == "Guard" else {"odd": "x"}
        text = fault(lambda: Mission("m", uses=[package], initial="a", states={"a": state, "b": {"final": "aborted"}}))
        kind = sys.modules[package].Odd
    finally:
        del sys.path[0]
    assert text.endswith(f"the {sort} 'odd' of {package.replace('_', '-')} 1.0 cannot be used: {why}")
    with pytest.raises(AssertionError, match=re.escape(why)):
        check_kind(kind.model_construct(odd="x"), sort, lambda: ("odd",))


def test_a_predicate_that_exits_is_unknown_too() -> None:
    notes: list[str] = []
    assert foreign_truth(lambda: sys.exit(0), "brittle", notes.append) is None
    assert notes == ["guard 'brittle' raised SystemExit: 0"]


@pytest.mark.parametrize(("value", "active", "notes"), [
    ("yes", {"b"}, ()), ("no", {"a"}, ("guard 'brittle' raised KeyError: 'no'",)),
    ("", {"a"}, ("guard 'brittle' raised TypeError: it returned 'empty'; give True, False, or None for unknown",)),
])  # fmt: skip
@pytest.mark.parametrize("is_inside", [False, True])
def test_a_foreign_guard_that_raises_or_is_no_truth_is_unknown(
    tmp_path: Path, value: str, active: set[str], notes: tuple[str, ...], is_inside: bool
) -> None:
    package = f"kinds_{tmp_path.name}"
    found = "None if seen.read(view) is None else {'': 'empty', 'yes': True}[seen.read(view)]"
    code = GUARD.format(
        name="Odd",
        word="brittle",
        value=found,
        before="seen = Operand(self.brittle, site)",
        above="from rai_missions.guards import Operand\nfrom rai_missions.model import Path",
    ).replace("brittle: str", "brittle: Path")
    site = laid_out(tmp_path, package, "1.0", offers=f"[rai_missions.guards]\nbrittle = {package}:Odd\n", code=code)
    sys.path.insert(0, str(site))
    try:
        guard = {"brittle": "word"}
        transition = {"when": {"all": [guard, guard]} if is_inside else guard, "to": "b"}
        states = {"a": {"transitions": [transition]}, "b": {"final": "aborted"}}
        keys = {"word": Key(str, source="robot")}
        chart = Chart(Mission("m", uses=[package], blackboard=keys, initial="a", states=states))
    finally:
        del sys.path[0]
    chart.start(0.0)
    step = chart.write("word", value, at=1.0)
    assert chart.active == active
    assert {each for each in step.notes if each.startswith("guard")} == set(notes)


@pytest.mark.parametrize(
    ("above", "before", "value", "named"),
    [
        ("import time", "pass", "time.time() > 0", "'time' (the clock)"),
        ("from time import monotonic as m", "pass", "m() > 0", "'time' (the clock)"),
        ("", "from datetime import datetime", "datetime.now() is None", "'datetime' (the clock)"),
        ("import random", "pass", "random.random() > 0.5", "'random' (chance)"),
        ("from random import random", "pass", "random() > 0.5", "'random' (chance)"),
        ("", "data = open('/etc/passwd').read()", "bool(data)", "'open' (files)"),
        ("from pathlib import Path", "pass", "Path('/x').exists()", "'pathlib' (files)"),
        ("import os", "pass", "'X' in os.environ", "'os' (the system)"),
        ("", "pass", "__import__('time').time() > 0", "'__import__'"),
        ("import importlib", "pass", "importlib.import_module('time').time() > 0", "'importlib'"),
        ("SEEN = []", "pass", "SEEN.append(1) is None and len(SEEN) > 2", "'SEEN', which can change"),
        ("def helper():\n    import uuid\n    return uuid.uuid4()", "pass", "helper() is None", "'uuid' (chance)"),
        (
            "def made():\n    from time import time\n    return lambda: time() > 0\nlook = made()",
            "pass",
            "look()",
            "'time' (the clock)",
        ),
        (
            "N = 0\ndef helper():\n    global N\n    N += 1\n    return N",
            "pass",
            "helper() > 3",
            "'N', which can change",
        ),
        ("", "Odd.n = 1", "True", "'n', which can change"),
        ("", "pass", "hash('a') > 0", "'hash'"),
    ],
)
def test_an_impure_guard_is_refused_by_what_it_uses(
    tmp_path: Path, above: str, before: str, value: str, named: str
) -> None:
    text = guard_of(tmp_path, "moody", value, above=above, before=before)
    assert f"the guard 'moody' of kinds-{tmp_path.name.replace('_', '-')} 1.0 cannot be used: it is impure: " in text
    assert named in text


def test_a_word_of_ours_is_never_anothers(tmp_path: Path) -> None:
    text = guard_of(tmp_path, "fresh", "True", offered="dusk")
    assert "the guard 'dusk'" in text and "does not load" in text and "'fresh' is a word of the format" in text
    offers = "[rai_missions.guards]\nkey = nowhere:Odd\n[rai_missions.worlds]\norchard = nowhere:World\n"
    sys.path.insert(0, str(laid_out(tmp_path / "shadow", "shadow", "1.0", offers=offers, code="")))
    try:
        assert load(MISSION).states["watered"].word == "final"
        assert "no option 'size'" in fault(lambda: open_world("orchard", size=1)) or sys.version_info < (3, 11)
    finally:
        del sys.path[0]


def test_what_is_no_guard_has_another_word_or_does_not_load_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    assert "its word is 'dusk'" in guard_of(tmp_path / "a", "dusk", "True", offered="dawn")
    assert "does not load (ModuleNotFoundError" in guard_of(tmp_path / "b", "dusk", "True", above="import not_there")


def test_a_name_that_two_packages_offer_is_refused(tmp_path: Path) -> None:
    laid_out(tmp_path, "rival", "3.0", offers="[rai_missions.guards]\nbetween = rival:Between\n", code="")
    sys.path.insert(0, str(tmp_path))
    try:
        assert "'between' is offered by orchard-kinds 1.2 and rival 3.0; uninstall one" in fault(lambda: load(MISSION))
    finally:
        del sys.path[0]


@pytest.mark.usefixtures("absent")
def test_what_lies_in_the_working_directory_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE / "installed")
    monkeypatch.syspath_prepend(str(HERE / "installed"))
    assert "'orchard_kinds' is not installed" in fault(lambda: load(MISSION))


# -- nothing is looked up before it is named ---------------------------------------------------------------------------

LIGHT = """
import sys
import rai_missions
rai_missions.load(sys.argv[1])
assert not [name for name in sys.modules if name.startswith(("packaging", "orchard_kinds"))]
"""


def test_a_mission_of_our_own_kinds_looks_up_no_package() -> None:
    tractor = HERE.parents[1] / "missions" / "tractor" / "mission.json"
    path = os.pathsep.join((str(HERE.parents[1]), str(HERE / "installed")))
    subprocess.run([sys.executable, "-c", LIGHT, str(tractor)], check=True, env={**os.environ, "PYTHONPATH": path})
