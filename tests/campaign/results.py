# SPDX-License-Identifier: Apache-2.0
"""Stores of results as a campaign would leave them, drawn by a seed: some models, some scenes, hostile texts."""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from rai_missions.campaign.records import (
    BEST_FIRST,
    CellRecord,
    LabelRecord,
    PictureRecord,
    QuestionRecord,
    SceneRecord,
    graded,
)
from rai_missions.campaign.store import ResultStore
from rai_missions.image import png

OPTIONS = ("drive_over", "signal", "replan")
KINDS = ("branch", "plastic_bag", "sleeping_cat", "tall_grass")
HOSTILE = (
    "<script>document.title='broken'</script>", "</script><script>document.title='broken'</script>",
    "<img src=x onerror=\"document.title='broken'\">", "]]> --> {{data}} {{body}} \u202e\u2028 '\"&amp;",
    "=HYPERLINK(\"http://example.org\")", "@everyone | `code` [link](javascript:alert(1))", "\x1b[31mred\x00",
)  # fmt: skip


class Sort(NamedTuple):
    """How a model answers."""

    name: str
    right: float = 0.5
    """How often it names a best option."""
    embodiment: str = "none"
    orders: Sequence[str] = ("written",)
    failed: float = 0.0
    silent: float = 0.0


SORTS = (
    Sort("rules", 0.7), Sort("oracle", 1.0), Sort("constant:replan", 0.0),
    Sort("small", 0.5, "none", ("written", "reversed"), 0.05, 0.05),
    Sort("small", 0.8, "pictures", ("written", "reversed"), 0.05, 0.05),
)  # fmt: skip


def make_results(
    path: Path,
    *,
    scenes: int = 40,
    seed: int = 1,
    sorts: Sequence[Sort] = SORTS,
    side: int = 24,
    prompt: str = "You are a robot.\n\nWhich option?",
    texts: Sequence[str] = ("it looks soft",),
) -> Path:
    """A store at `path`; four scenes share each seed."""
    chance = random.Random(seed)
    with ResultStore(path, writes=True) as store:
        store.set_meta({"name": "made", "texts": list(texts)})
        made = [_scene(number, chance) for number in range(scenes)]
        labels = {scene.scene: {option: chance.choice(BEST_FIRST) for option in OPTIONS} for scene in made}
        store.add(made)
        for scene in made:
            store.add(_known_of(scene, labels[scene.scene], {each.embodiment for each in sorts}, chance, side, prompt))
        store.add(cell for sort in sorts for scene in made for cell in _cells(sort, scene, labels, chance, texts))
    return path


def _scene(number: int, chance: random.Random) -> SceneRecord:
    spec = json.dumps({"world": "orchard", "options": {"height_m": chance.random()}})
    split = "tune" if number % 10 == 9 else "report"
    return SceneRecord(f"orchard-{number:04d}", "orchard", KINDS[number % len(KINDS)], number // 4, split, spec)


def _known_of(
    scene: SceneRecord, labels: dict[str, str], embodiments: set[str], chance: random.Random, side: int, prompt: str
) -> Iterator[NamedTuple]:
    for option, verdict in labels.items():
        details = json.dumps({"force_n": round(1000 * chance.random(), 1), "contacts": ["wheel", scene.kind]})
        yield LabelRecord(scene.scene, option, verdict, details)
    facts = json.dumps({"obstacle": {"kind": scene.kind, "height_m": 0.3}, "battery": 0.8})
    for embodiment in sorted(embodiments):
        text = f"{prompt}\n\n{scene.scene} {embodiment}"
        yield QuestionRecord(scene.scene, embodiment, text, facts, json.dumps(OPTIONS), json.dumps(OPTIONS[1:]))
    yield PictureRecord(scene.scene, "camera", png(side, side, chance.randbytes(3 * side * side)))


def _cells(
    sort: Sort, scene: SceneRecord, labels: dict[str, dict[str, str]], chance: random.Random, texts: Sequence[str]
) -> Iterator[CellRecord]:
    known = labels[scene.scene]
    for order in sort.orders:
        key = hashlib.sha256(f"{sort.name} {sort.embodiment} {scene.scene} {order}".encode()).hexdigest()
        start = CellRecord(key, "tractor", scene.scene, scene.seed, sort.name, sort.embodiment, order, "answered")
        drawn = chance.random()
        if drawn < sort.failed:
            yield start._replace(status="failed", error="no route to the provider")
            continue
        cost = start._replace(prompt_tokens=200, completion_tokens=20, calls=1, latency_s=chance.expovariate(1))
        if drawn < sort.failed + sort.silent:
            yield cost._replace(status="no_answer", error="no JSON came back")
            continue
        ranked = sorted(known, key=lambda option: BEST_FIRST.index(known[option]))
        option = ranked[0] if chance.random() < sort.right else "replan"
        answer = cost._replace(
            option=option, permitted=int(option != "drive_over"), reason=chance.choice(texts), raw=chance.choice(texts)
        )
        yield graded(answer, known)
