# SPDX-License-Identifier: Apache-2.0
"""Wrong answers as the data of a page: scenes, pictures and prompts once each, whatever is too much left out by name.

Rule: the page stays below 20 MB whatever the store holds; what is left out states where it is.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from rai_missions.campaign.report.figures import CampaignFigures
from rai_missions.campaign.report.scene_pictures import ScenePicture
from rai_missions.campaign.report.wrong_answers import WrongAnswer, WrongAnswers
from rai_missions.plain_data import json_value, plain
from rai_missions.redaction import cut, redacted
from visualize.page.as_json import Json, Pool, without_empty

__all__ = ("answers_data",)

PROMPT = 20_000
"""Characters of a prompt."""
REASON, RAW, DETAIL = 800, 1_500, 4_000
"""Characters of a model's reason, of its answer as it came, and of a rollout's details as JSON."""
PROMPTS, SCENES, ANSWERS = 3_500_000, 1_500_000, 2_500_000
"""Bytes of the page for each part; pictures have a bound of their own."""
LEFT_OUT = "left out: the page holds no more; it is in the store"


class ByteBudget:
    """Bytes that are left for a part of the page."""

    def __init__(self, size: int) -> None:
        self.left = size

    def take(self, value: Any) -> Any:
        """The value; words where its JSON does not fit any more."""
        size = len(json.dumps(value))
        if size > self.left:
            return LEFT_OUT
        self.left -= size
        return value


def answers_data(
    wrong: WrongAnswers, figures: CampaignFigures, pictures: Mapping[str, tuple[ScenePicture, ...]]
) -> Json:
    """What the page's script reads."""
    scenes = sorted({each.cell.scene for each in wrong.shown})
    pool, prompts = Pool(), ByteBudget(PROMPTS)
    questions = {
        f"{scene}\n{embodiment}": {
            "prompt": _prompt(record.prompt, pool, prompts),
            "facts": prompts.take(_clean(record.facts)),
            "options": json_value(record.options, record.options),
            "permitted": json_value(record.permitted, record.permitted),
        }
        for (scene, embodiment), record in wrong.questions.items()
    }
    kept, answers = ByteBudget(SCENES), ByteBudget(ANSWERS)
    return {
        "kind": "campaign",
        "answers": [_answer(each, answers) for each in wrong.shown],
        "count": wrong.total,
        "kinds": {kind: list(counts) for kind, counts in wrong.by_kind.items()},
        "scenes": {scene: _scene(scene, wrong, figures, pictures.get(scene, ()), kept) for scene in scenes},
        "questions": questions,
        "pool": pool.values,
    }


def _answer(answer: WrongAnswer, budget: ByteBudget) -> Json:
    cell = answer.cell
    return without_empty(
        {
            "cell": cell.cell[:12],
            "mission": cell.mission,
            "scene": cell.scene,
            "model": cell.model,
            "embodiment": cell.embodiment,
            "order": cell.option_order,
            "kind": answer.kind,
            "status": cell.status,
            "option": cell.option,
            "refused": cell.permitted == 0,
            "verdict": cell.verdict or "",
            "best": list(answer.best),
            "reason": budget.take(cut(cell.reason, REASON)),
            "error": budget.take(cut(cell.error, REASON)),
            "raw": budget.take(cut(cell.raw, RAW)),
            "latency_s": round(cell.latency_s, 3),
            "tokens": cell.prompt_tokens + cell.completion_tokens,
        }
    )


def _scene(
    scene: str, wrong: WrongAnswers, figures: CampaignFigures, pictures: tuple[ScenePicture, ...], budget: ByteBudget
) -> Json:
    record, labels = figures.scenes[scene], figures.labels[scene]
    return {
        "kind": record.kind,
        "seed": record.seed,
        "labels": dict(labels),
        "rollouts": {option: budget.take(_detail(wrong.details.get((scene, option)))) for option in labels},
        "spec": budget.take(_clean(record.spec)),
        "pictures": [_picture(each) for each in pictures],
    }


def _picture(evidence: ScenePicture) -> Json:
    if evidence.file is None:
        return {"name": evidence.name, "why": evidence.why}
    return {"name": evidence.name, "uri": f"data:{evidence.file.media_type};base64,{evidence.file.base64}"}


def _prompt(text: str, pool: Pool, budget: ByteBudget) -> list[int] | str:
    """A prompt's paragraphs as numbers of the pool, since prompts share most of them."""
    shown = cut(text, PROMPT)
    if len(text) > PROMPT:
        shown += f"\n\n… {len(text)} characters in all; the rest is in the store"
    before = len(pool.values)
    numbers = [pool.add(part) for part in shown.split("\n\n")]
    taken = budget.take([numbers, pool.values[before:]])
    if taken == LEFT_OUT:
        return LEFT_OUT
    return numbers


def _clean(text: str) -> Any:
    """JSON as plain data without secrets; a text that is no JSON as itself, cut."""
    shown = redacted(text)
    return plain(json_value(shown, shown)) if len(shown) <= DETAIL else cut(shown, DETAIL) + " …"


def _detail(value: Any) -> Any:
    text = json.dumps(plain(value))
    return _clean(text)
