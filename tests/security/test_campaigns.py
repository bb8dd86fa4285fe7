# SPDX-License-Identifier: Apache-2.0
"""A marked secret that enters a campaign anywhere is in no cell, page, table, comparison, log or output.

Rule: the campaign's own files are left out of the search: what an author writes into them is theirs.
"""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from langchain_core.messages import AIMessage

from rai_missions.answerers.model.chat import ThreadChat
from rai_missions.answerers.test_models import ScriptedModel
from rai_missions.campaign.asking import CellAsker, question_record
from rai_missions.campaign.cells import ORDERS, Cell
from rai_missions.campaign.embodiments import embodied
from rai_missions.campaign.load import LoadedCampaign, load_campaign
from rai_missions.campaign.models import CampaignModels
from rai_missions.campaign.questions import ask_in
from rai_missions.campaign.store import ResultStore
from rai_missions.cli.main import main
from tests.campaign.choosing import MISSION, ROBOT, campaign_data, labels, write_campaign
from tests.campaign.test_run import counted, ended, ran
from tests.security.test_leaks import files, log_of
from tests.security.test_secrets_in_pieces import SECRETS, assert_whole, secret_of

pytestmark = pytest.mark.sim
Json = dict[str, Any]
MODEL = "openai:double"
ENTRIES = ("question", "about", "fact", "script", "option", "why", "words", "raised", "parameters", "description",
           "document")  # fmt: skip
"""Where a secret may enter."""
BODIES = ("none", "documents")


class MarkedCampaign:
    """A campaign into which a secret enters.

    Args:
        secret: What is marked.
        entries: Where it enters.
        folder: For the campaign's own files; what it leaves is in `left` there.
        scenes: How many it asks about.
    """

    def __init__(self, secret: str, entries: frozenset[str], folder: Path, scenes: int = 1) -> None:
        self._secret, self._entries, self._folder, self._scenes = secret, entries, folder, scenes
        self.left = folder / "left"
        self.left.mkdir()
        self._path = self._written()

    def mark(self, entry: str) -> str:
        """The secret, where it enters here; else a word."""
        return self._secret if entry in self._entries else "something"

    def _written(self) -> Path:
        scripts = {"teller": {"*": {"option": "left", "why": f"as {self.mark('script')} has it"}}}
        path = write_campaign(
            self._folder,
            campaign_data(
                self._scenes,
                models=["rules", "teller"],
                scripts=scripts,
                embodiments=list(BODIES),
                retries=0,
                arguments={"note": self.mark("fact")},
            ),
        )
        mission: Json = deepcopy(MISSION)
        mission["blackboard"]["note"] = {"type": "string", "source": "argument", "initial": ""}
        asked = mission["states"]["choosing"]["decision"]
        text = {"type": "object", "properties": {"text": {"type": "string"}}}
        asked |= {"question": f"Which way is {self.mark('question')}?", "evidence": ["depth", "note"]}
        asked["options"]["right"] = {"about": f"by {self.mark('about')}", "parameters": text}
        identity = self._folder / "identity"
        identity.mkdir()
        (identity / "description.md").write_text(f"I carry {self.mark('description')} about.\n")
        (identity / "words.md").write_text(f"# Ways\n\nWhich way is it? It is the way of {self.mark('document')}.\n")
        (self._folder / "mission.json").write_text(json.dumps(mission))
        (self._folder / "robot.json").write_text(json.dumps(ROBOT | {"identity": "identity"}))
        return path

    def replies(self) -> Iterator[Any]:
        """What a model makes of the question, one time after the other."""
        mark = self.mark
        yield AIMessage(json.dumps({"option": mark("option"), "why": f"it is {mark('why')}"}))
        yield AIMessage(json.dumps({"option": "right", "parameters": {"text": mark("parameters")}, "why": mark("why")}))
        yield AIMessage(f"I would rather not: {mark('words')}")
        yield RuntimeError(f"401 {mark('raised')}")

    def run(self) -> None:
        """Ask all who answer, and write what a campaign writes."""
        stores = [self.left / f"{name}.db" for name in ("one", "two")]
        for store in stores:
            with ResultStore(store, writes=True) as opened:
                opened.add(labels(["s0"]))
            ran(self._path, store)
            self._ask_model(load_campaign(self._path), store)
        assert main(["campaign", "report", str(stores[0]), "--report", str(self.left / "page.html")]) == 0
        assert main(["campaign", "compare", *map(str, stores)]) == 0

    def killed(self) -> bytes:
        """Have a process ask those who need no model, and kill it in its midst; what it has printed."""
        store, temporary = self.left / "killed.db", self.left / "temporary"
        temporary.mkdir()
        command = [sys.executable, "-m", "rai_missions.cli.main", "campaign", "run", str(self._path)]
        process = subprocess.Popen(
            [*command, "--store", str(store), "--jobs", "2"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env={**os.environ, "TMPDIR": str(temporary)},
        )
        while not counted(store) and not ended(process):
            pass
        process.kill()
        return process.communicate()[0]

    def _ask_model(self, loaded: LoadedCampaign, store: Path) -> None:
        (scene,) = loaded.file.scenes.scenes()
        asked, subject = ask_in(scene, loaded.subject), loaded.subject
        bodies = {name: embodied(name, subject.identity, subject.text) for name in BODIES}
        for order, reply in zip(ORDERS, self.replies(), strict=False):
            chat = ThreadChat(ScriptedModel([reply] * len(BODIES)))
            with CampaignModels(loaded.file, subject.robot, {}, open_chat=lambda _, chat=chat: chat) as models:
                asking = CellAsker(loaded.file, models, {}, bodies, threading.Event())
                for body in BODIES:
                    cell = Cell("choosing", scene.scene, 0, MODEL, body, order)
                    record = asking.ask(f"{order} {body}", cell, asked, {})
                    assert record is not None
                    with ResultStore(store, writes=True) as opened:
                        opened.add([record, question_record(asked, body, bodies[body])])


Meet = Callable[[str, set[str]], None]


@pytest.fixture
def meet(
    caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str], tmp_path_factory: pytest.TempPathFactory
) -> Meet:
    """Has a secret enter a campaign at these places, and nothing with it come out."""

    def check(secret: str, entries: set[str]) -> None:
        caplog.set_level(logging.DEBUG)
        caplog.clear()
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("STRANGERS_API_KEY", secret)
            made = MarkedCampaign(secret, frozenset(entries), tmp_path_factory.mktemp("campaign"))
            made.run()
            printed = capsys.readouterr()
            left = files(made.left) | {"out": printed.out, "err": printed.err, "log": log_of(caplog)}
        assert {"one.db", "page.html", "page.csv", "page.md"} <= left.keys()
        assert_whole(left, secret)

    return check


LAW = settings(
    deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.generate], report_multiple_bugs=False
)
DRAWN = (SECRETS, st.sets(st.sampled_from(ENTRIES), min_size=1))


@settings(LAW, max_examples=2)
@given(*DRAWN)
def test_a_secret_that_enters_a_campaign_leaves_nowhere(meet: Meet, secret: str, entries: set[str]) -> None:
    meet(secret, entries)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "length"), [(1, 40), (2, 2_001)])
def test_a_secret_that_enters_a_campaign_that_is_killed_leaves_nowhere(
    seed: int, length: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    secret = secret_of(seed, length, 0.0)
    monkeypatch.setenv("STRANGERS_API_KEY", secret)
    made = MarkedCampaign(secret, frozenset(ENTRIES), tmp_path, scenes=8)
    printed = made.killed()
    assert counted(made.left / "killed.db")
    left = {str(path): path.read_bytes() for path in made.left.rglob("*") if path.is_file()}
    assert_whole(left | {"printed": printed}, secret)


@pytest.mark.drill
@pytest.mark.timeout(3600)
@settings(LAW, max_examples=200)
@given(*DRAWN)
def test_a_secret_that_enters_a_campaign_leaves_nowhere_in_many(meet: Meet, secret: str, entries: set[str]) -> None:
    meet(secret, entries)
