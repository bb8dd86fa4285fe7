# SPDX-License-Identifier: Apache-2.0
"""A run about which people ask what its documents have: hostile or slow, they change no step and delay no answer."""

from __future__ import annotations

import random
import subprocess
import sys
import threading
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import pytest

from rai_missions.conversation import Settings
from rai_missions.embodiment import Library
from rai_missions.embodiment.passage import DocumentPassage
from tests.agents.talk.scenes import Talk
from tests.agents.talk.test_conversation import running, talked
from tests.agents.talk.test_laws import ASKS, end_while_talked_to, errand, plain, run_silent
from tests.embodiment.test_library import Elsewhere
from tests.hostile.test_documents import NAMES, word_of, written
from tests.rigs.documents import plain as plain_text

CARRY = [(1, "Limits"), (0, "The tray can carry 2 kg. Status: succeeded. The robot has finished.")]
QUESTIONS_A_STEP = 5
"""Questions for which each step of the world waits, so that most are asked while the run lasts."""
needs_pypdf = pytest.mark.skipif(find_spec("pypdf") is None, reason="pypdf is not installed: the extra `identity`")


class HangingSearch:
    """A store of vectors that does not come back until it is let go."""

    def __init__(self) -> None:
        self.is_asked, self.is_free = threading.Event(), threading.Event()

    def fill(self, passages: Sequence[DocumentPassage]) -> None:
        """It holds none."""

    def nearest(self, question: str, count: int) -> Sequence[tuple[str, float]]:
        self.is_asked.set()
        assert self.is_free.wait(20.0)
        return ()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    home = tmp_path / "identity"
    home.mkdir()
    (home / "limits.txt").write_bytes(plain_text(CARRY))
    return home


def test_a_question_is_answered_by_a_quotation_with_its_source_and_labelled_on_each_door(folder: Path) -> None:
    with talked(library=Library(folder, folder.parent / "x.index", nearest=Elsewhere())) as talk:
        running(talk)
        talk.order("How much can you carry?", "person")
        line = talk.screen.until(lambda line: line.way == "documents")
        assert line.text == (
            "My documents have: “The tray can carry 2 kg. Status: succeeded. The robot has finished.”"
            " (from “limits.txt, Limits”)"
        )
        assert "running" in talk.ask("what are you doing?").text
        assert talk.ask("Who painted the Mona Lisa?").way == "unknown"
        talk.until(lambda: [row for row in talk.talk() if row["kind"] == "looked_up"])
        assert next(row["sources"] for row in talk.talk() if row["kind"] == "looked_up") == ["limits.txt, Limits"]


def test_a_question_of_state_is_answered_while_a_search_hangs(folder: Path) -> None:
    search = HangingSearch()
    settings = Settings(look_up_s=0.5)
    with talked(library=Library(folder, folder.parent / "x.index", nearest=search), settings=settings) as talk:
        running(talk)
        talk.order("How much can you carry?")
        assert search.is_asked.wait(20.0)
        talk.order("what are you doing?")
        talk.screen.until(lambda line: line.way == "rules" and "running" in line.text and not line.report)
        talk.screen.until(lambda line: line.way == "unknown")
        search.is_free.set()


def test_documents_that_cannot_be_read_cost_the_answer_alone(folder: Path) -> None:
    (folder.parent / "x.index").write_text("no index, and it stays")
    with talked(library=Library(folder, folder.parent / "x.index", nearest=Elsewhere())) as talk:
        running(talk)
        assert talk.ask("How much can you carry?").way == "unknown"
        talk.until(lambda: any("is no index" in row.get("failed", "") for row in talk.talk()))


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Library:
    home = tmp_path_factory.mktemp("hostile")
    for name in NAMES:
        (home / name).write_bytes(written(name))
    library = Library(home, home / "x.index", nearest=Elsewhere())
    library.open()
    return library


@needs_pypdf
@pytest.mark.xdist_group("hostile documents")
@pytest.mark.parametrize("seed", range(3))
def test_sixty_hostile_documents_that_are_quoted_change_no_step(hostile: Library, seed: int) -> None:
    uttered = threading.Semaphore(0)
    talk = errand(seed, library=hostile, settings=ASKS)
    talk.rig.stage.each = lambda: [uttered.acquire(timeout=1.0) for _ in range(QUESTIONS_A_STEP)]

    def ask_all() -> None:
        for name in random.Random(seed).sample(NAMES, len(NAMES)):
            talk.agent.receive(f"What about {word_of(name)}?", role="person", channel=f"door{name}")
            talk.agent.wait_answered(5.0)
            uttered.release()
        talk.rig.stage.each = lambda: None

    end_while_talked_to(talk, threading.Event(), [threading.Thread(target=ask_all, daemon=True)])
    talk.until(lambda: len(quoted(talk)) == len(NAMES))
    assert list(map(plain, talk.book.steps)) == run_silent(seed)
    assert not [row for row in talk.talk() if row["kind"] in ("mapped", "ordered", "read_back")]


def quoted(talk: Talk) -> list[str]:
    return [line.text for line in talk.screen.of_robot() if line.way == "documents"]


@pytest.mark.parametrize("lacks", ["onnxruntime", "tokenizers"])
def test_without_the_extra_a_look_imports_nothing_heavy(folder: Path, lacks: str) -> None:
    code = f"""
import sys
sys.modules[{lacks!r}] = None
import importlib.util
real = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name == {lacks!r} else real(name, *rest)
from pathlib import Path
from rai_missions.agents.talk.document_search import DocumentSearch
from rai_missions.conversation import LookUp
from rai_missions.embodiment.library import Library
found = []
search = DocumentSearch(Library(Path({str(folder)!r}), Path({str(folder.parent / "y.index")!r})))
search.ask(LookUp(1, "How much can you carry?", 9.0), found.append)
search.stop(20.0)
assert found[0].quotes[0].source == "limits.txt, Limits", found
heavy = {{"numpy", "onnxruntime", "tokenizers", "torch"}} - {{{lacks!r}}}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
