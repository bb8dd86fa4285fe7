# SPDX-License-Identifier: Apache-2.0
"""A recorded answer is judged as it was when it was given, whatever is hidden in it and however long it is."""

from __future__ import annotations

import json
import sqlite3
import threading
from collections.abc import Iterable, Iterator
from contextlib import closing
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from langchain_core.messages import AIMessage

from rai_missions.answerers.model.chat import ThreadChat
from rai_missions.answerers.test_models import ScriptedModel
from rai_missions.campaign.asking import LONGEST, CellAsker
from rai_missions.campaign.cells import Cell
from rai_missions.campaign.embodiments import embodied
from rai_missions.campaign.load import LoadedCampaign, load_campaign
from rai_missions.campaign.models import CampaignModels
from rai_missions.campaign.questions import AskedScene, ask_in
from rai_missions.campaign.records import CellRecord
from rai_missions.campaign.tasks import SceneTask, TaskRecord
from tests.campaign.choosing import MISSION, ROBOT, campaign_data, write_campaign
from tests.campaign.test_run import SerialPool, cells_in, ran

pytestmark = pytest.mark.sim
Json = dict[str, Any]
MODEL, SCRIPT = "openai:double", "teller"
SECRET = "correct-horse-battery-staple-4711"
LABELS = {"left": "completes", "right": "harms", "wait": "harmless"}
SCHEMA: Json = {
    "type": "object",
    "properties": {
        "text": {"type": "string", "maxLength": 30}, "long": {"type": "string", "maxLength": LONGEST + 10},
        "word": {"enum": ["near", SECRET]}, "code": {"type": "string", "pattern": "^[a-z0-9-]+$"},
        "most": {"type": "array", "items": {"type": "string"}, "maxItems": 3},
    },
}  # fmt: skip


class Asked(NamedTuple):
    """The question of one scene, and the campaign that it is of."""

    loaded: LoadedCampaign
    scene: AskedScene


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Asked]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STRANGERS_API_KEY", SECRET)
        folder, mission = tmp_path_factory.mktemp("campaign"), deepcopy(MISSION)
        mission["states"]["choosing"]["decision"]["options"]["right"]["parameters"] = SCHEMA  # type: ignore[index]
        path = write_campaign(folder, campaign_data(1, models=[MODEL, SCRIPT], retries=0))
        (folder / "mission.json").write_text(json.dumps(mission))
        (folder / "robot.json").write_text(json.dumps(ROBOT))
        loaded = load_campaign(path)
        (scene,) = loaded.file.scenes.scenes()
        yield Asked(loaded, ask_in(scene, loaded.subject))


def texts() -> st.SearchStrategy[str]:
    """Words, secrets, and what is too long to be kept."""
    short = st.sampled_from(["near", "", "ü", "two words", SECRET, f"the {SECRET}", f"{SECRET}.", SECRET * 2, "a" * 31])
    long = st.builds(lambda text, count: (text or "x") * count, short, st.sampled_from([700, LONGEST // 2, LONGEST]))
    return short | long.map(lambda text: text[: 2 * LONGEST])


def answers() -> st.SearchStrategy[Any]:
    """What an answerer may say, right or wrong."""
    names = st.sampled_from(["left", "right", "right", "wait", "nowhere"]) | texts()
    values = texts() | st.lists(texts(), max_size=5) | st.none() | st.integers()
    given = st.dictionaries(st.sampled_from(["text", "long", "word", "code", "most"]), values, max_size=3)
    answer = st.fixed_dictionaries({"option": names}, optional={"why": texts(), "parameters": given})
    return answer | st.fixed_dictionaries({"absent": texts()}) | st.fixed_dictionaries({"failed": texts()})


def ask(asked: Asked, model: str, answer: Any, recorded: CellRecord | None = None) -> CellRecord:
    """The record of the one cell, asked or judged again."""
    loaded, scene = asked
    file = loaded.file.model_copy(update={"scripts": {SCRIPT: {"*": answer}}, "models": (MODEL, SCRIPT)})
    chat = ThreadChat(ScriptedModel([AIMessage(json.dumps(answer))] * 4))
    cell = Cell("choosing", scene.scene.scene, 0, model, "none", "written")
    bodies = {"none": embodied("none", loaded.subject.identity, loaded.subject.text)}
    with CampaignModels(file, loaded.subject.robot, {}, open_chat=lambda _: chat) as models:
        asking = CellAsker(file, models, {}, bodies, threading.Event(), recorded and (lambda _: recorded))
        record = asking.ask("key", cell, scene, LABELS)
    assert record is not None
    return record


def is_judged_again(asked: Asked, model: str, answer: Any) -> None:
    first = ask(asked, model, answer)
    assert SECRET not in repr(first)
    assert ask(asked, model, "wait", first) == first


LAW = settings(deadline=None, suppress_health_check=list(HealthCheck))


@settings(LAW, max_examples=20)
@given(answer=answers())
def test_what_a_script_answered_is_judged_again_as_it_was(asked: Asked, answer: Any) -> None:
    is_judged_again(asked, SCRIPT, answer)


@settings(LAW, max_examples=10)
@given(answer=answers())
def test_what_a_model_answered_is_judged_again_as_it_was(asked: Asked, answer: Any) -> None:
    is_judged_again(asked, MODEL, answer)


@pytest.mark.drill
@pytest.mark.timeout(3600)
@settings(LAW, max_examples=2_000)
@given(answer=answers(), model=st.sampled_from([SCRIPT, MODEL]))
def test_answers_are_judged_again_as_they_were_in_many(asked: Asked, answer: Any, model: str) -> None:
    is_judged_again(asked, model, answer)


class CutPool(SerialPool):
    """Has the store copied after each record, as a kill would have left it."""

    cuts: list[Path]
    store: Path

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        for record in super().results(tasks):
            yield record
            self.cut()

    @classmethod
    def cut(cls) -> None:
        left = cls.store.with_name(f"cut{len(cls.cuts)}.db")
        with closing(sqlite3.connect(cls.store)) as source, closing(sqlite3.connect(left)) as copy:
            source.backup(copy)
        cls.cuts.append(left)


@pytest.mark.long
def test_a_store_that_was_cut_anywhere_is_continued_and_judged_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", SECRET)
    monkeypatch.setattr("rai_missions.campaign.intake.COMMIT_RECORDS", 1)
    answer = {"option": "right", "why": f"by {SECRET}", "usage": {"calls": 1, "tokens_in": 3, "tokens_out": 1}}
    path = write_campaign(tmp_path, campaign_data(1, scripts={SCRIPT: {"*": answer}}))
    CutPool.cuts, CutPool.store = [], tmp_path / "whole.db"
    ran(path, CutPool.store, CutPool)
    whole, left = {each.cell: each for each in cells_in(CutPool.store)}, list[int]()
    for cut in CutPool.cuts:
        stored = {each.cell for each in cells_in(cut)}
        left.append(len(stored))
        again = cut.with_suffix(".again")
        ran(path, again, recorded=cut)
        judged = {each.cell: each for each in cells_in(again)}
        assert judged.keys() == whole.keys()
        assert {name: judged[name] for name in stored} == {name: whole[name] for name in stored}
        assert all(judged[name].error == "no answer is recorded" for name in whole.keys() - stored)
        for store in (cut, again):
            ran(path, store)
            assert {each.cell: each for each in cells_in(store)} == whole
            assert SECRET.encode() not in store.read_bytes()
    assert set(left) == set(range(len(whole) + 1)), "a kill comes between any two cells"
