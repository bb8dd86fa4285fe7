# SPDX-License-Identifier: Apache-2.0
"""Campaigns from file to store: every cell once, whatever dies on the way."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.campaign.intake import Progress
from rai_missions.campaign.load import load_campaign
from rai_missions.campaign.plan import plan_of
from rai_missions.campaign.pool import LocalPool
from rai_missions.campaign.ray_pool import RayPool
from rai_missions.campaign.records import CellRecord
from rai_missions.campaign.run import CampaignResult, run_campaign
from rai_missions.campaign.store import ResultStore
from rai_missions.campaign.tasks import SceneTask, TaskRecord, Workplace, WorkSettings
from rai_missions.errors import UsageError
from tests.campaign.choosing import ROBOT, campaign_data, labels, table, write_campaign

pytestmark = pytest.mark.sim


class SerialPool:
    """A pool without processes: the oracle of the others. It may be stopped by a test after some cells."""

    def __init__(self, settings: WorkSettings) -> None:
        self._place = Workplace(settings)

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        for task in tasks:
            yield from self._place.work(task)
        yield None

    def stop(self) -> None:
        self._place.is_over.set()

    def close(self) -> None:
        self._place.__exit__()


def ran(path: Path, store: Path, open_pool: Any = SerialPool, **words: Any) -> CampaignResult:
    """A run of a campaign into a store."""
    recorded, workers = str(words.pop("recorded", "")), words.pop("workers", 1)
    loaded, settings = load_campaign(path), WorkSettings(str(path), (), workers, recorded)
    with ResultStore(store, writes=True) as opened:
        return run_campaign(loaded, opened, settings, open_pool=open_pool, **words)


def cells_in(store: Path) -> list[CellRecord]:
    with ResultStore(store) as opened:
        return table(opened.cells())


def test_every_cell_has_its_answer_and_its_verdict(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data()), tmp_path / "results.db"
    with ResultStore(store, writes=True) as opened:
        opened.add(labels(["s0", "s1"]))
    result = ran(path, store)
    assert result.counts == {"answered": 12} and result.missing == 0 and not result.stopped
    found = {(cell.scene, cell.model): cell for cell in cells_in(store) if cell.option_order == "reversed"}
    assert {key: (cell.option, cell.verdict, cell.best, cell.permitted) for key, cell in found.items()} == {
        ("s0", "rules"): ("left", "completes", 1, 1),
        ("s1", "rules"): ("left", "completes", 1, 1),
        ("s0", "constant:wait"): ("wait", "harmless", 0, 1),
        ("s1", "constant:wait"): ("wait", "harmless", 0, 1),
        ("s0", "teller"): ("left", "completes", 1, 1),
        ("s1", "teller"): ("right", "harms", 0, 1),
    }
    with ResultStore(store) as opened:
        (question, *_), scenes = opened.questions(), list(opened.scenes())
    assert (question.options, question.permitted) == ('["left", "right", "wait"]',) * 2
    assert "Which way?" in question.prompt and "- right: to the right" in question.prompt
    assert [scene.kind for scene in scenes] == ["even", "odd"]


def test_who_answers_later_questions_is_a_scene_s_own_over_what_the_campaign_has(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(3)), tmp_path / "results.db"
    mission, data = json.loads((tmp_path / "mission.json").read_text()), json.loads(path.read_text())
    mission["states"]["choosing"]["transitions"] = [{"on": ["left", "right", "wait"], "to": "checking"}]
    mission["states"]["checking"] = {
        "decision": {
            "question": "Was it right?", "options": {"yes": {"about": "it was"}, "no": {"about": "it was not"}},
            "ask": ["operator"], "deadline_s": 5, "fallback": "no",
        },
        "transitions": [{"on": "yes", "to": "right"}, {"on": "no", "to": "ended"}],
    }  # fmt: skip
    mission["states"]["right"] = {"final": "aborted"}
    data |= {"labels": "rollouts", "rollouts": {"longest_s": 3.0, "later": {"operator": {"checking": "no"}}}}
    data["scenes"]["given"][1]["later"] = {"operator": {"checking": "yes"}}
    data["scenes"]["given"][2]["later"] = {"agent": {"choosing": "left"}}
    (tmp_path / "mission.json").write_text(json.dumps(mission))
    path.write_text(json.dumps(data))
    ran(path, store, labels_alone=True)
    with ResultStore(store) as opened:
        ends = {(each.scene, *json.loads(each.details)["states"]) for each in opened.label_records()}
    assert ends == {("s0", "ended"), ("s1", "right"), ("s2", "ended")}


def test_what_the_rules_do_not_offer_is_refused_and_a_silent_script_gives_no_answer(tmp_path: Path) -> None:
    scripts = {"deep": {"*": "right"}, "mute": {"*": None}, "liar": {"*": {"option": "fly", "why": "I can"}}}
    data = campaign_data(1, models=[*scripts, "oracle"], scripts=scripts, arguments={"depth": 7}, orders=["written"])
    ran(write_campaign(tmp_path, data), tmp_path / "results.db")
    found = {cell.model: cell for cell in cells_in(tmp_path / "results.db")}
    assert (found["deep"].status, found["deep"].permitted) == ("answered", 0)
    assert found["deep"].error == "'right' was not offered; offered: left, wait"
    assert (found["liar"].permitted, found["liar"].reason) == (0, "I can")
    assert (found["mute"].status, found["mute"].permitted) == ("no_answer", None)
    assert found["oracle"].status == "failed"
    assert found["oracle"].error == "no option that is offered has a label, by which the oracle chooses"


def test_scenes_are_labelled_by_rolling_out_each_option_unless_the_store_has_labels(tmp_path: Path) -> None:
    data = campaign_data(2, labels="rollouts", models=["oracle"], scripts={}, arguments={"depth": 7})
    store = tmp_path / "results.db"
    with ResultStore(store, writes=True) as opened:
        opened.add(labels(["s1"]))
    ran(write_campaign(tmp_path, data), store)
    with ResultStore(store) as opened:
        found, details = opened.labels(), [json.loads(each.details) for each in opened.label_records()]
    assert found["s0"] == dict.fromkeys(("left", "right", "wait"), "harmless")  # each ends the mission, aborted
    assert found["s1"] == {"left": "completes", "right": "harms", "wait": "harmless"}
    assert [each["offered"] for each in details if each] == [True, False, True]
    answers = {(cell.scene, cell.option, cell.verdict, cell.best) for cell in cells_in(store)}
    assert answers == {("s0", "left", "harmless", 1), ("s1", "left", "completes", 1)}


@pytest.mark.parametrize("source", ["trials", "rollouts"])
def test_a_scene_in_which_nothing_stops_the_tractor_ends_no_campaign(tmp_path: Path, source: str) -> None:
    home = Path(__file__).parents[2] / "missions/tractor"
    scenes = [{"scene": "free", "kind": "none", "seed": 1, "options": {"obstacles": ["none"], "alleys": 1}}]
    data = {
        "format": 1, "name": "free", "decision": "assessing", "arguments": {"alleys": 1}, "labels": source,
        "mission": str(home / "mission.json"), "robot": str(home / "robot.sim.json"), "models": ["rules"],
        "scenes": {"world": "orchard", "given": scenes},
    }  # fmt: skip
    result = ran(write_campaign(tmp_path, data), tmp_path / "results.db")
    assert (result.counts, result.missing) == ({"failed": 1}, 0)
    with ResultStore(tmp_path / "results.db") as opened:
        assert opened.labels() == {} and "asked nothing" in next(iter(opened.cells())).error
    alone = ran(tmp_path / "campaign.json", tmp_path / "labels.db", labels_alone=True)
    assert alone.missing == 1 and sum(alone.unlabelled.values()) == 1
    assert "asked nothing" in next(iter(result.unlabelled))


def test_why_no_option_can_be_tried_in_a_scene_is_reported(tmp_path: Path) -> None:
    path = write_campaign(tmp_path, campaign_data(2, labels="rollouts", orders=["written"]))
    mission = json.loads((tmp_path / "mission.json").read_text())
    seconds = {"type": "object", "properties": {"s": {"type": "number"}}, "required": ["s"]}
    mission["states"]["choosing"]["decision"]["options"]["left"]["parameters"] = seconds
    (tmp_path / "mission.json").write_text(json.dumps(mission))
    why = "'left' cannot be tried in 'choosing': "
    for words in ({}, {"labels_alone": True}):
        found = ran(path, tmp_path / f"{len(words)}.db", **words).unlabelled
        assert list(found.values()) == [2] and next(iter(found)).startswith(why)


def test_a_world_that_a_function_makes_may_lack_what_rollouts_need(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "plugins" / "installed"))
    monkeypatch.syspath_prepend(str(tmp_path))
    make = "from orchard_kinds.greenhouse import Greenhouse\ndef make(seed: int = 0): return Greenhouse(seed=seed)\n"
    (tmp_path / "made_house.py").write_text(make)
    (tmp_path / "made_house-1.0.dist-info").mkdir()
    (tmp_path / "made_house-1.0.dist-info/METADATA").write_text("Metadata-Version: 2.1\nName: made_house\nVersion: 1\n")
    (tmp_path / "made_house-1.0.dist-info/entry_points.txt").write_text("[rai_missions.worlds]\nmade=made_house:make\n")
    path = write_campaign(tmp_path, campaign_data(2, labels="rollouts"))
    data = json.loads(path.read_text())
    path.write_text(json.dumps(data | {"scenes": data["scenes"] | {"world": "made", "options": {}}}))
    found = ran(path, tmp_path / "made.db").unlabelled
    needs = "branch, harm, measures and work_done"
    assert found == {f"nothing is rolled out in the world 'made': that needs {needs}": 2}


def test_labels_alone_are_made_once_and_a_part_of_them_is_made_again(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(2, labels="rollouts")), tmp_path / "results.db"
    with ResultStore(store, writes=True) as opened:
        opened.add(labels(["s1"])[:2])  # a kill came in between
    noted: list[Progress] = []
    result = ran(path, store, labels_alone=True, on_progress=noted.append)
    assert result.counts == {} and result.missing == 0
    assert (noted[-1].done, noted[-1].total) == (2, 2) and noted[-1].words("USD").startswith("2 of 2 scenes, ")
    harmless = dict.fromkeys(("left", "right", "wait"), "harmless")
    with ResultStore(store) as opened:
        assert opened.labels() == {"s0": harmless, "s1": harmless}
    assert ran(path, store, lambda settings: RefusingPool(), labels_alone=True).missing == 0
    with pytest.raises(UsageError, match="no source of labels"):
        ran(write_campaign(tmp_path, campaign_data(2)), store, labels_alone=True)


@pytest.mark.drill
def test_a_pool_of_processes_gives_the_table_of_one_process(tmp_path: Path) -> None:
    path = write_campaign(tmp_path, campaign_data(3))
    ran(path, tmp_path / "serial.db")
    ran(path, tmp_path / "pool.db", LocalPool, workers=2)
    assert cells_in(tmp_path / "pool.db") == cells_in(tmp_path / "serial.db")
    with ResultStore(tmp_path / "pool.db") as pool, ResultStore(tmp_path / "serial.db") as serial:
        assert list(pool.questions()) == list(serial.questions())


def test_a_campaign_continues_with_what_is_missing(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(2)), tmp_path / "results.db"
    ran(path, tmp_path / "whole.db")
    ran(path, store)
    with ResultStore(store, writes=True) as opened:
        keys = sorted(opened.done())
        opened.drop(keys[:5])
        opened.add([next(opened.cells())._replace(status="failed", option="", error="gone")])
    asked: list[Progress] = []
    ran(path, store, on_progress=asked.append)
    assert asked[0].total == 12 and asked[-1].done == 12
    assert cells_in(store) == cells_in(tmp_path / "whole.db")


def test_nothing_is_asked_where_nothing_is_missing(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(1)), tmp_path / "results.db"
    ran(path, store)
    result = ran(path, store, lambda settings: RefusingPool())
    assert result.counts == {"answered": 6}


class RefusingPool:
    """Has nothing to do."""

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        assert list(tasks) == []
        yield None

    def stop(self) -> None: ...

    def close(self) -> None: ...


def test_a_changed_script_is_asked_again_and_the_rest_is_kept(tmp_path: Path) -> None:
    store = tmp_path / "results.db"
    ran(write_campaign(tmp_path, campaign_data(1)), store)
    before = cells_in(store)
    ran(write_campaign(tmp_path, campaign_data(1, scripts={"teller": {"*": "wait"}})), store)
    after = cells_in(store)
    assert len(after) == len(before) == 6
    assert [cell for cell in after if cell.model != "teller"] == [cell for cell in before if cell.model != "teller"]
    assert {cell.option for cell in after if cell.model == "teller"} == {"wait"}


def test_a_scene_whose_data_changed_is_labelled_shown_and_asked_again(tmp_path: Path) -> None:
    store, given = tmp_path / "results.db", campaign_data(2, labels="rollouts", scripts={}, models=["oracle"])
    ran(write_campaign(tmp_path, given), store)
    with ResultStore(store, writes=True) as opened:
        opened.add(labels(["s0", "s1"]))  # by which a label that is kept is known
    given["scenes"]["given"][1]["seed"] = 9
    ran(write_campaign(tmp_path, given), store)
    with ResultStore(store) as opened:
        found = opened.labels()
    assert found == {
        "s0": {"left": "completes", "right": "harms", "wait": "harmless"},
        "s1": dict.fromkeys(("left", "right", "wait"), "harmless"),
    }


def test_a_scene_in_a_file_of_its_own_is_the_content_of_that_file(tmp_path: Path) -> None:
    people = [{"at": [3.0, 3.0]}]
    (tmp_path / "kitchen.json").write_text(json.dumps({"people": people}))
    data = campaign_data(1, models=["rules"], scripts={}, orders=["written"])
    data["scenes"] = {**data["scenes"], "world": "house", "options": {"camera": False, "scene": "kitchen.json"}}
    path = write_campaign(tmp_path, data)
    keys = []
    for _ in range(2):
        plan = plan_of(load_campaign(path))
        keys.append(list(plan.cells))
        assert json.loads(plan.scenes[0].spec)["options"]["scene"] == {"people": people}
        people.append({"at": [2.0, 3.0]})
        (tmp_path / "kitchen.json").write_text(json.dumps({"people": people}))
    assert keys[0] != keys[1]
    (tmp_path / "kitchen.json").unlink()
    with pytest.raises(UsageError, match=r"kitchen\.json' cannot be read: No such file"):
        load_campaign(path)


def test_an_embodiment_is_asked_again_once_what_it_shows_has_changed(tmp_path: Path) -> None:
    identity, store = tmp_path / "identity", tmp_path / "results.db"
    identity.mkdir()
    (identity / "description.md").write_text("A robot that chooses.")
    (identity / "manual.md").write_text("Which way? The left way is wide.")
    data = campaign_data(1, models=["constant:wait"], scripts={}, orders=["written"])
    data["embodiments"] = ["none", "description", "documents"]
    path = write_campaign(tmp_path, data)
    (tmp_path / "robot.json").write_text(json.dumps({**ROBOT, "identity": "identity"}))

    def keys() -> dict[str, str]:
        return {cell.embodiment: key for key, cell in plan_of(load_campaign(path)).cells.items()}

    ran(path, store)
    before = keys()
    (identity / "manual.md").write_text("Which way? The right way is wide.")
    after = keys()
    assert {name for name, key in after.items() if key != before[name]} == {"documents"}
    ran(path, store)
    assert {cell.embodiment: cell.cell for cell in cells_in(store)} == after
    with ResultStore(store) as opened:
        prompts = {each.embodiment: each.prompt for each in opened.questions()}
    assert "The right way is wide." in prompts["documents"] and "wide" not in prompts["description"]


def test_a_script_is_asked_again_once_the_kind_of_its_scene_has_changed(tmp_path: Path) -> None:
    data, store = campaign_data(3), tmp_path / "results.db"
    ran(write_campaign(tmp_path, data), store)
    before = cells_in(store)
    data["scenes"]["given"][0]["kind"] = "odd"
    ran(write_campaign(tmp_path, data), store)
    after = cells_in(store)
    assert [cell for cell in after if cell.model != "teller"] == [cell for cell in before if cell.model != "teller"]
    assert {cell.scene: cell.option for cell in after if cell.model == "teller"} == {
        "s0": "right",
        "s1": "right",
        "s2": "left",
    }


def test_answers_that_were_there_before_the_labels_are_graded_by_them(tmp_path: Path) -> None:
    store = tmp_path / "results.db"
    ran(write_campaign(tmp_path, campaign_data(2)), store)
    assert {cell.verdict for cell in cells_in(store)} == {None}
    ran(write_campaign(tmp_path, campaign_data(2, labels="rollouts")), store, labels_alone=True)
    graded = cells_in(store)
    assert {(cell.verdict, cell.best) for cell in graded} == {("harmless", 1)}
    ran(write_campaign(tmp_path, campaign_data(2, labels="rollouts")), tmp_path / "at_once.db")
    assert cells_in(tmp_path / "at_once.db") == graded


def test_labels_of_another_source_are_made_again(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(1, labels="rollouts")), tmp_path / "results.db"
    with ResultStore(store, writes=True) as opened:
        opened.set_meta({"file": campaign_data(1, labels="trials")})
        opened.add(labels(["s0"]))
    ran(path, store)
    assert {(cell.verdict, cell.best) for cell in cells_in(store)} == {("harmless", 1)}


def test_a_store_of_another_mission_is_left_as_it_is(tmp_path: Path) -> None:
    store = tmp_path / "results.db"
    ran(write_campaign(tmp_path, campaign_data(1)), store)
    other = write_campaign(tmp_path, campaign_data(1, arguments={"depth": 2}))
    with pytest.raises(UsageError, match="holds the answers of another mission or profile; name another store"):
        ran(other, store)
    assert len(cells_in(store)) == 6


def test_recorded_answers_are_judged_again_without_asking(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(2)), tmp_path / "results.db"
    ran(path, store)
    ran(path, tmp_path / "again.db", recorded=store)
    assert cells_in(tmp_path / "again.db") == cells_in(store)
    deep = write_campaign(tmp_path, campaign_data(2, arguments={"depth": 7}))  # now `right` is not offered
    ran(deep, tmp_path / "deep.db", recorded=store)
    refused = [(cell.model, cell.scene) for cell in cells_in(tmp_path / "deep.db") if not cell.permitted]
    assert refused == [("teller", "s1")] * 2
    more = write_campaign(tmp_path, campaign_data(3))
    result = ran(more, tmp_path / "more.db", recorded=store)
    assert result.counts == {"answered": 12, "failed": 6}


USED = {"option": "left", "usage": {"calls": 1, "tokens_in": 100, "tokens_out": 20}}


def test_what_asks_no_one_is_bound_by_no_budget_of_calls_and_by_no_rate(tmp_path: Path) -> None:
    words = {"models": ["teller"], "scripts": {"teller": {"*": USED}}, "orders": ["written"]}
    path, store = write_campaign(tmp_path, campaign_data(3, **words)), tmp_path / "results.db"
    ran(path, store)
    with ResultStore(store, writes=True) as opened:
        opened.add([each._replace(latency_s=2.5) for each in opened.cells()])
    write_campaign(
        tmp_path,
        campaign_data(3, **words, budget={"calls": 1}, rates={"teller": {"calls_per_minute": 0.01}}, labels="rollouts"),
    )
    again = tmp_path / "again.db"
    result = ran(path, again, recorded=store)
    assert (result.counts, result.missing, result.stopped) == ({"answered": 3}, 0, "")
    with ResultStore(again) as opened:
        assert [(each.calls, each.prompt_tokens, each.latency_s) for each in opened.cells()] == [(1, 100, 2.5)] * 3
    assert not ran(path, again, labels_alone=True).stopped


@pytest.mark.parametrize(("budget", "words", "calls"), [
    ({"calls": 2}, "the budget of 2 calls is spent", 2),
    ({"tokens": 300}, "the budget of 300 tokens is spent", 3),
    ({"money": 0.5}, "the budget of 0.5 money is spent", 1),
    ({"seconds": 1e-9}, "the budget of 1e-09 seconds is spent", 0),
])  # fmt: skip
def test_a_spent_budget_stops_cleanly_and_the_next_run_asks_the_rest(
    tmp_path: Path, budget: dict[str, Any], words: str, calls: int
) -> None:
    store, given = tmp_path / "results.db", {"scripts": {"teller": {"*": USED}}}
    prices = {"teller": {"prompt": 4000, "completion": 5000}}  # 0.5 a call
    result = ran(write_campaign(tmp_path, campaign_data(2, budget=budget, prices=prices, **given)), store)
    assert result.stopped == words and 0 < result.missing <= 12
    assert sum(result.counts.values()) + result.missing == 12
    assert sum(cell.calls for cell in cells_in(store)) == calls
    again = ran(write_campaign(tmp_path, campaign_data(2, budget=budget, **given)), store) if calls else None
    assert again is None or again.missing == result.missing  # what the store holds counts
    assert ran(write_campaign(tmp_path, campaign_data(2, **given)), store).missing == 0


def test_what_failed_cells_used_counts_in_every_run_that_follows(tmp_path: Path) -> None:
    store, given = tmp_path / "results.db", {"scripts": {"teller": {"*": USED}}}
    ran(write_campaign(tmp_path, campaign_data(2, **given)), store)
    with ResultStore(store, writes=True) as opened:
        cells = [cell for cell in opened.cells() if cell.model == "teller"]
        failed = [cell._replace(status="failed", option="", calls=3, cost=0.5) for cell in cells[:2]]
        opened.add(failed)
        spent = sum(cell.calls for cell in opened.cells())
    budget = {"calls": spent}
    assert ran(write_campaign(tmp_path, campaign_data(2, budget=budget, **given)), store).counts["failed"] == 2
    assert ran(write_campaign(tmp_path, campaign_data(2, **given)), store).counts == {"answered": 12}
    again = {cell.cell: cell for cell in cells_in(store)}
    assert [(again[each.cell].calls, again[each.cell].cost) for each in failed] == [(4, 0.5)] * 2
    assert [again[each.cell].prompt_tokens for each in failed] == [200] * 2


def test_labels_of_other_scenes_are_no_progress(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(2, labels="rollouts")), tmp_path / "results.db"
    with ResultStore(store, writes=True) as opened:
        opened.add(labels(["s0", "s1", "s2"]))
    noted: list[Progress] = []
    ran(path, store, lambda settings: RefusingPool(), labels_alone=True, on_progress=noted.append)
    assert {(each.done, each.total) for each in noted} == {(2, 2)}


def test_cells_of_other_scenes_and_models_are_no_progress(tmp_path: Path) -> None:
    store, noted = tmp_path / "results.db", list[Progress]()
    ran(write_campaign(tmp_path, campaign_data(2)), store)
    fewer = campaign_data(1, models=["rules", "constant:left"], scripts={})
    ran(write_campaign(tmp_path, fewer), store, on_progress=noted.append)
    assert noted[-1].done == 4 and all(each.done <= each.total == 4 for each in noted)


def test_failed_cells_of_models_that_are_not_asked_are_not_counted(tmp_path: Path) -> None:
    path, store = write_campaign(tmp_path, campaign_data(2)), tmp_path / "results.db"
    ran(path, store)
    with ResultStore(store, writes=True) as opened:
        opened.add(
            [
                cell._replace(status="failed", option="", error="429")
                for cell in opened.cells()
                if cell.model == "teller"
            ]
        )
    loaded = load_campaign(path, models=["rules"])
    with ResultStore(store, writes=True) as opened:
        result = run_campaign(loaded, opened, WorkSettings(str(path), ("rules",), 1, ""), open_pool=SerialPool)
    assert (result.counts, result.failures, result.missing) == ({"answered": 4}, {}, 0)


def test_a_scene_that_cannot_be_built_fails_alone(tmp_path: Path) -> None:
    data = campaign_data(2)
    data["scenes"]["given"][1]["options"] = {"obstacles": ["dragon"]}
    result = ran(write_campaign(tmp_path, data), tmp_path / "results.db")
    assert result.counts == {"answered": 6, "failed": 6}
    (why,) = result.failures
    assert result.failures[why] == 6 and "no kind 'dragon'" in why
    failed = [cell for cell in cells_in(tmp_path / "results.db") if cell.status == "failed"]
    assert {cell.scene for cell in failed} == {"s1"} and "no kind 'dragon'" in failed[0].error


# -- what dies ---------------------------------------------------------------------------------------------------------


class KillingPool:
    """Kills one of its own workers after each of some records."""

    def __init__(self, pool: Any, kills: set[int], chance: random.Random) -> None:
        self._pool, self._kills, self._chance, self.killed = pool, kills, chance, 0
        self.stop, self.close = pool.stop, pool.close

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        count = 0
        for record in self._pool.results(tasks):
            count += isinstance(record, CellRecord)
            while self._pool.pids and any(each <= count for each in self._kills):
                self._kills.discard(min(self._kills))
                os.kill(self._chance.choice(self._pool.pids), signal.SIGKILL)
                self.killed += 1
            yield record


def killed_workers(tmp_path: Path, scenes: int, kills: int) -> None:
    chance = random.Random(7)
    path = write_campaign(tmp_path, campaign_data(scenes))
    ran(path, tmp_path / "whole.db")
    total = 6 * scenes
    pools: list[KillingPool] = []

    def open_pool(settings: WorkSettings) -> KillingPool:
        pools.append(KillingPool(LocalPool(settings), set(chance.sample(range(1, total - 6), kills)), chance))
        return pools[-1]

    ran(path, tmp_path / "killed.db", open_pool, workers=2)
    assert pools[0].killed == kills
    assert cells_in(tmp_path / "killed.db") == cells_in(tmp_path / "whole.db")


def killed_whole(tmp_path: Path, scenes: int, kills: int) -> None:
    """Kill the whole campaign whenever it has stored some more cells, until it is done."""
    chance, store, left = random.Random(7), tmp_path / "killed.db", list[int]()
    path = write_campaign(tmp_path, campaign_data(scenes, scripts={"teller": {"*": USED}}))  # stored one by one
    ran(path, tmp_path / "whole.db")
    command = [sys.executable, "-m", "rai_missions.cli.main", "campaign", "run", str(path), "--store", str(store)]
    for kill in range(kills):
        process = subprocess.Popen([*command, "--jobs", "2"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wanted = (6 * scenes - 6) * (kill + chance.random()) / kills
        while counted(store) < wanted and not ended(process):
            pass
        process.kill()
        process.wait()
        left.append(6 * scenes - counted(store))
    assert any(left), "it was killed in its midst"
    assert subprocess.run([*command, "--jobs", "2"], capture_output=True, check=False).returncode == 0
    assert cells_in(store) == cells_in(tmp_path / "whole.db")


def ended(process: subprocess.Popen[bytes]) -> bool:
    """Whether a process ends within a moment."""
    try:
        process.wait(0.001)
    except subprocess.TimeoutExpired:
        return False
    return True


def counted(store: Path) -> int:
    """Cells in a store that may be in the making."""
    try:
        with ResultStore(store) as opened:
            return len(opened.ends())
    except UsageError:
        return 0


@pytest.mark.parametrize("calls", [0, 1])
def test_an_answer_that_cost_calls_is_stored_before_the_next_comes(
    tmp_path: Path, calls: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rai_missions.campaign.intake.COMMIT_S", float("inf"))
    answer = {"option": "left", "usage": {"calls": calls, "tokens_in": 3, "tokens_out": 1}}
    path = write_campaign(tmp_path, campaign_data(models=["teller"], scripts={"teller": {"*": answer}}))
    stored = list[int]()

    class LookingPool(SerialPool):
        def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
            for record in super().results(tasks):
                yield record
                stored.append(len(cells_in(tmp_path / "results.db")))

    ran(path, tmp_path / "results.db", LookingPool)
    assert max(stored) == 4 * calls


@pytest.mark.long
def test_workers_that_are_killed_lose_no_cell_and_double_none(tmp_path: Path) -> None:
    killed_workers(tmp_path, scenes=2, kills=1)


@pytest.mark.long
def test_a_campaign_that_is_killed_continues(tmp_path: Path) -> None:
    killed_whole(tmp_path, scenes=2, kills=1)


@pytest.mark.drill
def test_ray_gives_the_table_of_one_process(tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="the extra `ray`")
    path = write_campaign(tmp_path, campaign_data(3))
    ran(path, tmp_path / "serial.db")
    store = ["--store", str(tmp_path / "ray.db")]
    command = [sys.executable, "-m", "rai_missions.cli.main", "campaign", "run", str(path), *store, "--ray"]
    elsewhere = {**os.environ, "RAY_ADDRESS": "127.0.0.1:1"}
    done = subprocess.run([*command, "--jobs", "2"], capture_output=True, text=True, check=False, env=elsewhere)
    assert done.returncode == 0, f"without an address Ray starts on this machine: {done.stderr}"
    assert cells_in(tmp_path / "ray.db") == cells_in(tmp_path / "serial.db")


@pytest.fixture
def two_machines() -> Iterator[str]:
    """The address of a cluster of two nodes on this machine, of one core each."""
    pytest.importorskip("ray", reason="the extra `ray`")
    from ray.cluster_utils import Cluster

    cluster = Cluster()
    for _ in range(2):
        cluster.add_node(num_cpus=1, include_dashboard=False)
    yield cluster.address
    cluster.shutdown()


@pytest.mark.drill
@pytest.mark.timeout(1800)
@pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::ResourceWarning", "ignore::DeprecationWarning")
def test_more_workers_than_cores_on_two_ray_nodes_and_a_killed_one_give_the_table_of_one_process(
    tmp_path: Path, two_machines: str
) -> None:
    path = write_campaign(tmp_path, campaign_data(6))
    ran(path, tmp_path / "serial.db")
    pools: list[KillingPool] = []

    def open_pool(settings: WorkSettings) -> KillingPool:
        pools.append(KillingPool(RayPool(settings, two_machines), {6}, random.Random(7)))
        return pools[-1]

    result = ran(path, tmp_path / "ray.db", open_pool, workers=3)
    assert (result.missing, pools[0].killed) == (0, 1)
    assert cells_in(tmp_path / "ray.db") == cells_in(tmp_path / "serial.db")


@pytest.mark.drill
@pytest.mark.timeout(1800)
@pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::ResourceWarning", "ignore::DeprecationWarning")
def test_a_ray_worker_that_cannot_begin_ends_the_campaign_with_its_reason(two_machines: str, tmp_path: Path) -> None:
    path = write_campaign(tmp_path, campaign_data(1))
    settings, tasks = WorkSettings(str(path)), list(plan_of(load_campaign(path)).tasks(set(), set()))
    path.unlink()
    pool = RayPool(settings, two_machines)
    try:
        with pytest.raises(UsageError, match=r"a worker of the campaign cannot work: .*campaign\.json"):
            list(pool.results(tasks))
    finally:
        pool.close()


@pytest.mark.drill
@pytest.mark.timeout(1800)
def test_ten_kills_of_workers_lose_no_cell(tmp_path: Path) -> None:
    killed_workers(tmp_path, scenes=12, kills=10)


@pytest.mark.drill
@pytest.mark.timeout(1800)
def test_ten_kills_of_the_whole_lose_no_cell(tmp_path: Path) -> None:
    killed_whole(tmp_path, scenes=24, kills=10)


def test_a_plan_names_each_cell_once(tmp_path: Path) -> None:
    loaded = load_campaign(write_campaign(tmp_path, campaign_data(4)))
    plan = plan_of(loaded)
    assert len(plan.cells) == len(set(plan.cells.values())) == 24
