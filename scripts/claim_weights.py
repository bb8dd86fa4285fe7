# SPDX-License-Identifier: Apache-2.0
"""Learns how much each word of a model's sentence sounds like a claim: `python scripts/claim_weights.py`.

Reads the sentences in `tests/conversation/data` (`claims.json`, `claims_learned.json`) and writes
`rai_missions/conversation/claims/claim_weights/`. Needs scikit-learn: `pip install -e .[learn]`. `--dry`
only prints what each group of sentences would come to if nothing of its writer had been learned;
`claims_held_out.json` is never learned.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from sklearn.feature_extraction import DictVectorizer
from sklearn.linear_model import LogisticRegression
from sklearn.preprocessing import normalize

from rai_missions.conversation import StatusView
from rai_missions.conversation.claims.claim_score import FOLDER, FREQUENT, ClaimWeights, features, words_of
from rai_missions.conversation.claims.claims import Claims, plain, scored_clauses
from rai_missions.conversation.claims.judged_sentence import CERTAIN

DATA = Path(__file__).parent.parent / "tests/conversation/data"
VIEW = StatusView(robot="rosbot, simulated", mission="rosbot_patrol")
UNIT = 1000
"""Weights and rarities are written as whole numbers of such parts."""
LEAST_COUNT, MOST_FEATURES, STRENGTH = 3, 16000, 20.0
"""How many sentences a feature is in, how many are kept, and the inverse of the regularization."""
MOST_REPLACED = 0.22
"""The share of the writers' harmless sentences that may be replaced, each judged without what its writer has written;
they wrote hard ones on purpose."""


class Sentences(NamedTuple):
    """Sentences of one writer: those that are claims, and those that are none."""

    texts: list[str]
    are_claims: list[bool]


def sentences(group: dict[str, Any], code: str) -> Sentences:
    claims, harmless = group["claims"][code], group["harmless"][code]
    return Sentences([*claims, *harmless], [True] * len(claims) + [False] * len(harmless))


def stored_groups() -> list[dict[str, Any]]:
    """What is stored for the rules first, then what each writer wrote who did not know them."""
    learned = json.loads((DATA / "claims_learned.json").read_text(encoding="utf-8"))
    return [json.loads((DATA / "claims.json").read_text(encoding="utf-8")), *learned["writers"]]


def groups(code: str) -> list[Sentences]:
    """The same in one language."""
    first, *writers = stored_groups()
    return [
        _joined(sentences(first, code), first["joined"][code] + first["joined_more"][code]),
        *(sentences(each, code) for each in writers),
    ]


def _joined(given: Sentences, forms: list[str]) -> Sentences:
    """The same, and each twice more with harmless words around it, which so count for neither side."""
    texts = list(given.texts)
    for step in (0, len(forms) // 2):
        for number, text in enumerate(given.texts):
            bare = text.rstrip(".!?")
            texts.append(forms[(number + step) % len(forms)].format(bare[:1].lower() + bare[1:]) + ".")
    return Sentences(texts, given.are_claims * 3)


def words_by_count(every: Sequence[Sentences]) -> list[str]:
    """The words of the writers, those first that are in most sentences."""
    counts = Counter(word for group in every[1:] for text in group.texts for word in set(words_of(plain(text))))
    return sorted((word for word in counts if word[0].isalpha()), key=lambda each: (-counts[each], each))


@cache
def _features(text: str, frequent: frozenset[str]) -> frozenset[str]:
    return features(plain(text), frequent)


def learn(texts: list[str], are_claims: list[bool], frequent: frozenset[str]) -> dict[str, tuple[int, int]]:
    """The weights of the features that decide most; without a bias, so what is unknown stays in doubt."""
    given = [_features(text, frequent) for text in texts]
    counts = Counter(each for one in given for each in one)
    known = [dict.fromkeys((each for each in one if counts[each] >= LEAST_COUNT), 1.0) for one in given]
    vectorizer, labels = DictVectorizer(), np.array(are_claims)
    table = vectorizer.fit_transform(known).tocsr()
    number_with = np.asarray(table.sum(0)).ravel()
    rarity = np.log((1 + len(texts)) / (1 + number_with))
    decisive = np.abs(_fitted(table, rarity, labels)) * rarity * np.sqrt(number_with)
    kept = np.sort(np.argsort(-decisive, kind="stable")[:MOST_FEATURES])
    last = _fitted(table[:, kept], rarity[kept], labels) * rarity[kept]
    names = vectorizer.get_feature_names_out()[kept]
    return {
        str(name): (round(UNIT * float(weight)), round(UNIT * float(rare)))
        for name, weight, rare in sorted(zip(names, last, rarity[kept], strict=True))
    }


def _fitted(table: Any, rarity: Any, labels: Any) -> Any:
    """The weight of each feature."""
    model = LogisticRegression(
        C=STRENGTH, fit_intercept=False, max_iter=1000, class_weight="balanced", solver="liblinear"
    )
    return model.fit(normalize(table.multiply(rarity).tocsr()), labels).coef_[0]


class Judged(NamedTuple):
    """A sentence of a writer, judged where nothing of the writer was learned."""

    is_claim: bool
    is_certain: bool
    score: float
    """Below any bound where the rules find nothing and the sentence scores as harmless."""

    def is_replaced(self, bound: float) -> bool:
        return self.is_certain or self.score > bound


def by_others(code: str) -> Iterator[Judged]:
    """Each sentence of each writer."""
    claims, every = Claims(code), groups(code)
    frequent = frozenset(words_by_count(every)[:FREQUENT])
    for number, group in enumerate(every[1:], 1):
        rest = [each for other, each in enumerate(every) if other != number]
        texts = [text for each in rest for text in each.texts]
        learned = learn(texts, [claim for each in rest for claim in each.are_claims], frequent)
        weights = ClaimWeights(learned, frequent, frequent, math.inf, "")
        for text, is_claim in zip(group.texts, group.are_claims, strict=True):
            kind, bare = claims.why_suspected(text, VIEW), plain(text)
            if kind:
                is_certain = kind in CERTAIN or not weights.is_harmless(bare, scored_clauses(bare))
                yield Judged(is_claim, is_certain, weights.score(bare))
            else:
                yield Judged(is_claim, weights.is_claim(bare), -math.inf)


def least_score(code: str) -> float:
    """The lowest bound at which as few harmless sentences are replaced as may be; prints what passes at each."""
    found, best = list(by_others(code)), 0.0
    stated, harmless = [each for each in found if each.is_claim], [each for each in found if not each.is_claim]
    print(f"{code}: {len(stated)} claims, {len(harmless)} harmless, each judged by the sentences of other writers")
    for bound in np.arange(0.0, -4.25, -0.25):
        passed, replaced = _share_that_passes(stated, bound), 1 - _share_that_passes(harmless, bound)
        print(f"  bound {bound:5.2f}: {passed:6.1%} of the claims pass, {replaced:6.1%} of the harmless are replaced")
        if replaced <= MOST_REPLACED:
            best = float(bound)
    return best


def _share_that_passes(judged: Sequence[Judged], bound: float) -> float:
    return sum(not each.is_replaced(bound) for each in judged) / len(judged)


def _a_line_each(content: dict[str, Any]) -> str:
    """JSON, with each feature on a line of its own."""
    text = json.dumps(content, ensure_ascii=False)
    return text.replace("], ", "],\n").replace("{", "{\n", 2).replace("}", "\n}") + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--dry", action="store_true", help="write nothing")
    chosen = parser.parse_args()
    for code in ("en", "de"):
        least, every = least_score(code), groups(code)
        print(f"  the bound is {least:.2f}")
        if chosen.dry:
            continue
        texts = [text for each in every for text in each.texts]
        words, are_claims = words_by_count(every), [is_claim for each in every for is_claim in each.are_claims]
        weights = learn(texts, are_claims, frozenset(words[:FREQUENT]))
        stored = [[group["claims"][code], group["harmless"][code]] for group in stored_groups()]
        digest = hashlib.sha256(json.dumps(stored, ensure_ascii=False).encode()).hexdigest()
        content = {"learned_from": digest, "least": least, "words": words, "weights": weights}
        FOLDER.mkdir(exist_ok=True)
        path = FOLDER / f"{code}.json"
        path.write_text(_a_line_each(content), encoding="utf-8")
        print(f"  {path}: {len(weights)} features")


if __name__ == "__main__":
    main()
