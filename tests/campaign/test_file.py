# SPDX-License-Identifier: Apache-2.0
"""Campaign files: what is refused, and in which words."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from textwrap import indent
from typing import Any

import jsonschema
import pytest

from rai_missions.campaign.file import campaign_schema
from rai_missions.campaign.load import load_campaign
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.mission.json_reader import read_json
from tests.campaign.choosing import campaign_data, write_campaign

SHIPPED = sorted((Path(__file__).parents[2] / "campaigns").glob("*.json"))


def faults(tmp_path: Path, words: dict[str, Any]) -> str:
    write(tmp_path / "bare.json", format=1, name="bare")
    with pytest.raises(DefinitionError) as caught:
        load_campaign(write_campaign(tmp_path, campaign_data() | words))
    return "\n".join(map(str, caught.value.faults))


@pytest.mark.parametrize(("words", "fault"), [
    ({"decision": "chosing"}, "/decision: 'chosing' is no decision of the mission; did you mean 'choosing'?"),
    ({"decision": "ended"}, "/decision: 'ended' is no decision of the mission; name a decision"),
    ({"models": ["rules", "constant:leave"], "scripts": {}},
     "/models/1: no option 'leave'; there is: left, right, wait"),
    ({"models": ["rulez"], "scripts": {}}, "/models/0: 'rulez' names no model: rules, oracle, constant:OPTION, local, a"
     " script, or PROVIDER:NAME; did you mean 'rules'?"),
    ({"models": ["opnai:gpt-4o"], "scripts": {}}, "/models/0: no model provider 'opnai'; did you mean 'openai'?"),
    ({"models": ["o.s:path"], "scripts": {}}, "/models/0: no model provider 'o.s'; there is: "),
    ({"models": ["teller"], "scripts": {"teller": {"bb": "left"}},
      "scenes": {"given": [{"scene": "a", "kind": "b", "seed": 1}]}},
     "/scripts/teller/bb: no scene is of kind 'bb'; did you mean 'b'?"),
    ({"models": ["rules", "rules"], "scripts": {}}, "/models: 'models' names 'rules' more than once; keep one"),
    ({"embodiments": ["soul"]}, "/embodiments/0: no embodiment 'soul'"),
    ({"orders": ["sorted"]}, "/orders/0: no such choice: 'sorted'"),
    ({"models": ["openai:gpt"], "scripts": {}, "budget": {"money": 2}}, "'prices' has no price of 'openai:gpt', which"),
    ({"prices": {"openai:gpt": {"prompt": 1}}}, "/prices/openai:gpt: 'prices' is about 'openai:gpt', which"),
    ({"scripts": {"teller": {"*": 3}}}, "/scripts/teller/*: an answer is an option's name or an object, not 3"),
    ({"budget": {"calls": 0}}, "/budget/calls"),
    ({"color": 1}, "/color: a campaign has no 'color'"),
    ({"rollouts": {"parameters": {"lift": {}}}}, "/rollouts/parameters/lift: no option 'lift'"),
    ({"rollouts": {"later": {"opertor": {}}}}, "/rollouts/later/opertor: no decision asks 'opertor'"),
    ({"rollouts": {"later": {"agent": {"ended": "left"}}}},
     "/rollouts/later/agent/ended: 'ended' is no decision of the mission"),
    ({"rollouts": {"later": {"agent": {"choosing": "lft"}}}},
     "/rollouts/later/agent/choosing: 'choosing' has no option 'lft'; did you mean 'left'?"),
    ({"scenes": {"given": [{"scene": "a", "kind": "b", "seed": 1, "later": {"agent": {"chosing": "left"}}}]}},
     "/scenes/given/0/later/agent/chosing: 'chosing' is no decision of the mission; did you mean 'choosing'?"),
    ({"arguments": {"deep": 1}}, "/arguments/deep: the mission takes no argument 'deep'; did you mean 'depth'"),
    ({"arguments": {"depth": "deep"}}, "/arguments/depth: the argument does not fit"),
    ({"scenes": {"world": "orchrd", "seeds": [1]}},
     "/scenes/world: there is no world 'orchrd'; did you mean 'orchard'?"),
    ({"labels": "trials", "scenes": {"world": "house", "seeds": [1]}},
     "/labels: nothing tries options in the world 'house', but in: orchard; have \"rollouts\""),
    ({"scenes": {"world": "orchard", "count": 10**9}}, "/scenes/count"),
    ({"scenes": {"world": "desk", "count": 2}},
     "/scenes/count: no scenes are drawn of the world 'desk', but of: orchard, house; write them under 'given', or"),
    ({"rates": {"opnai": {"calls_per_minute": 9}}, "models": ["openai:gpt"], "scripts": {}},
     "/rates/opnai: 'rates' is about 'opnai', of which 'models' has none; did you mean 'openai'?"),
    ({"models": ["rules"], "scripts": {}, "robot": "bare.json"},
     "/models/0: the profile has no rules for 'choosing', which is asked; add them there, or drop 'rules'"),
    ({"embodiments": ["none", "documents"]},
     "/embodiments/1: 'documents' shows the robot's identity, and its profile names none; add 'identity' there"),
    ({"base": 3}, "/base: a base is a file's name, not 3"),
])  # fmt: skip
def test_a_fault_is_named_with_its_place(tmp_path: Path, words: dict[str, Any], fault: str) -> None:
    assert fault in faults(tmp_path, words)


@pytest.mark.parametrize(("scenes", "fault"), [
    ({}, "give exactly one of them"),
    ({"seeds": [1], "given": [{"scene": "a", "kind": "b", "seed": 1}]}, "give exactly one of them"),
    ({"seeds": [1], "count": 3}, "give exactly one of them"),
    ({"count": 3, "options": {"alleys": 2}}, "/scenes/options: the generator draws each scene's options"),
    ({"seeds": [1, 1]}, "the scene 'orchard_1' is there more than once"),
])  # fmt: skip
def test_scenes_have_one_source_and_names_of_their_own(tmp_path: Path, scenes: dict[str, Any], fault: str) -> None:
    assert fault in faults(tmp_path, {"scenes": scenes})


@pytest.fixture
def tub(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Has another package offer the world `tub`, whose class has this body."""

    def offer(body: str) -> None:
        (tmp_path / "tubs.py").write_text(f"class Tub:\n{indent(body, '    ')}\n")
        (tmp_path / "tubs-1.0.dist-info").mkdir()
        (tmp_path / "tubs-1.0.dist-info/METADATA").write_text("Metadata-Version: 2.1\nName: tubs\nVersion: 1.0\n")
        (tmp_path / "tubs-1.0.dist-info/entry_points.txt").write_text("[rai_missions.worlds]\ntub = tubs:Tub\n")
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.delitem(sys.modules, "tubs", raising=False)

    return offer


TUB = {
    "scenes": {"world": "tub", "given": [{"scene": "a", "kind": "b", "seed": 1}]},
    "models": ["rules"],
    "scripts": {},
}


def test_a_world_of_another_package_that_takes_no_seed_is_refused(tub: Callable[[str], None], tmp_path: Path) -> None:
    tub("def __init__(self, warm: bool = False): ...")
    assert faults(tmp_path, {**TUB, "labels": "none"}) == (
        "/scenes/world: the world 'tub' has no option 'seed'; there are: warm; a campaign gives each world the seed of "
        "its scene"
    )


def test_labels_that_the_world_of_another_package_cannot_have_are_refused(
    tub: Callable[[str], None], tmp_path: Path
) -> None:
    tub("def __init__(self, seed: int = 0): ...\ndef branch(self): ...\ndef measures(self): ...")
    assert faults(tmp_path, {**TUB, "labels": "rollouts"}) == (
        "/labels: nothing is rolled out in the world 'tub': its class lacks harm, work_done; add what it lacks, or "
        'have "none"'
    )
    assert faults(tmp_path, {**TUB, "labels": "trials"}) == (
        "/labels: nothing tries options in the world 'tub', but in: orchard; have \"none\""
    )


def test_a_world_of_another_package_with_all_that_rollouts_need_has_them(
    tub: Callable[[str], None], tmp_path: Path
) -> None:
    tub("def __init__(self, seed: int = 0): ...\nbranch = harm = measures = work_done = print")
    assert '; have "rollouts"' in faults(tmp_path, {**TUB, "labels": "trials"})
    write(tmp_path / "bare.json", format=1, name="bare")
    load_campaign(write_campaign(tmp_path, campaign_data() | TUB | {"labels": "rollouts"}))


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no file"):
        load_campaign(tmp_path / "none.json")


def test_the_files_that_a_campaign_names_are_reported_together(tmp_path: Path) -> None:
    path = write_campaign(tmp_path, campaign_data(mission="nowhere.json", robot="no_robot.json"))
    with pytest.raises(DefinitionError) as raised:
        load_campaign(path)
    assert str(raised.value).splitlines() == [
        f"{path}: /mission: there is no file '{tmp_path / 'nowhere.json'}'",
        f"{path}: /robot: there is no file '{tmp_path / 'no_robot.json'}'; did you mean '{tmp_path / 'robot.json'}'?",
    ]
    write(tmp_path / "odd.json", name="odd")
    write(tmp_path / "odd_robot.json", name="odd", topcs={})
    with pytest.raises(DefinitionError) as raised:
        load_campaign(write_campaign(tmp_path, campaign_data(mission="odd.json", robot="odd_robot.json")))
    files = {fault.file for fault in raised.value.faults}
    assert files == {str(tmp_path / "odd.json"), str(tmp_path / "odd_robot.json")}


def test_other_models_replace_those_of_the_file_with_all_that_is_about_them(tmp_path: Path) -> None:
    path = write_campaign(tmp_path, campaign_data(prices={"rules": {"prompt": 1}}))
    loaded = load_campaign(path, models=["oracle", "rules"])
    assert loaded.file.models == ("oracle", "rules")
    assert loaded.file.prices.keys() == {"rules"} and loaded.file.scripts == {}
    assert loaded.digest == load_campaign(path).digest  # the same questions


def write(path: Path, **data: Any) -> Path:
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def test_a_campaign_has_the_fields_of_its_base_but_for_its_own(tmp_path: Path) -> None:
    prices, rates = {"openai:gpt": {"prompt": 1}}, {"openai": {"calls_per_minute": 9}}
    models = ["rules", "teller", "openai:gpt"]
    write_campaign(tmp_path, campaign_data(models=models, prices=prices, rates=rates, retries=5))
    (tmp_path / "further").mkdir()
    own = write(tmp_path / "further" / "own.json", base="../campaign.json", name="own", models=["rules", "oracle"])
    below, file = load_campaign(tmp_path / "campaign.json"), load_campaign(own).file
    assert (file.name, file.models, file.retries) == ("own", ("rules", "oracle"), 5)
    assert (file.prices, file.rates, file.scripts) == ({}, {}, {})  # they are about models that it has not
    assert load_campaign(own).digest == below.digest and file.scenes == below.file.scenes
    alike = write(tmp_path / "alike.json", base="campaign.json")
    assert load_campaign(alike).file == below.file


def test_a_base_that_is_none_is_named(tmp_path: Path) -> None:
    write_campaign(tmp_path, campaign_data())
    middle = write(tmp_path / "middle.json", base="campaign.json")
    with pytest.raises(DefinitionError, match=r"/base: the base 'middle.json' has a base, too; name 'campaign.json'"):
        load_campaign(write(tmp_path / "own.json", base=middle.name))
    with pytest.raises(UsageError, match=r"there is no file .*nowhere\.json"):
        load_campaign(write(tmp_path / "own.json", base="nowhere.json"))
    with pytest.raises(DefinitionError, match="mission"):
        load_campaign(write(tmp_path / "own.json", base="mission.json"))


def test_the_schema_takes_what_the_models_take(tmp_path: Path) -> None:
    schema = campaign_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(campaign_data(budget={"money": 2.5}, rates={"openai": {"calls_per_minute": 60}}), schema)
    wrongs: list[dict[str, Any]] = [{"budget": {"calls": 0}}, {"color": 1}, {"orders": []}]
    for wrong in wrongs:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(campaign_data(**wrong), schema)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_every_shipped_campaign_is_without_fault(path: Path) -> None:
    loaded = load_campaign(path)
    jsonschema.validate(read_json(path), campaign_schema())
    assert list(loaded.file.scenes.scenes())


def test_campaigns_are_shipped() -> None:
    assert {path.name for path in SHIPPED} >= {"quick.json", "tractor.json"}


def test_the_generators_scenes_are_those_of_the_split_in_their_order(tmp_path: Path) -> None:
    counted = {"world": "orchard", "count": 6, "first_seed": 40}
    every = list(load_campaign(write_campaign(tmp_path, campaign_data() | {"scenes": counted})).file.scenes.scenes())
    drawn = {**counted, "split": "report"}
    found = list(load_campaign(write_campaign(tmp_path, campaign_data() | {"scenes": drawn})).file.scenes.scenes())
    assert len(every) == len(found) == 6 and {each.split for each in found} == {"report"}
    assert [each for each in every if each.split == "report"] == found[: sum(each.split == "report" for each in every)]
