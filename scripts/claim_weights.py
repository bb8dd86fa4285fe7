# SPDX-License-Identifier: Apache-2.0
"""Learns how much each word of a model's sentence sounds like a claim: `python scripts/claim_weights.py`.

Reads the sentences in `tests/conversation/data` (`claims.json`, `claims_learned.json`) and writes
`rai_missions/conversation/claim_weights/`. Needs scikit-learn: `pip install -e .[learn]`. `--dry` only prints what each
group of sentences would come to if nothing of its writer had been learned; `claims_held_out.json` is never learned.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from sklearn.feature_extraction import DictVectorizer
from sklearn.linear_model import LogisticRegression
from sklearn.preprocessing import normalize

from rai_missions.conversation import StatusView
from rai_missions.conversation.claim_score import FOLDER, MOST_OF_CLAUSE, UNIT, ClaimWeights, features
from rai_missions.conversation.claims import CERTAIN, Claims, plain, scored_clauses

DATA = Path(__file__).parent.parent / "tests/conversation/data"
VIEW = StatusView(robot="rosbot, simulated", mission="rosbot_patrol")
LEAST_COUNT, MOST_FEATURES, STRENGTH = 3, 8000, 20.0
"""How many sentences a feature is in, how many are kept, and the inverse of the regularization."""
MOST_PASSED = 0.025
"""The share of the writers' claims that may pass, each judged without what its writer has written."""


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


def learn(texts: list[str], are_claims: list[bool]) -> dict[str, int]:
    """The weights of the features that decide most; without a bias, so what is unknown stays in doubt."""
    given = [features(plain(text)) for text in texts]
    counts = Counter(each for one in given for each in one)
    known = [dict.fromkeys((each for each in one if counts[each] >= LEAST_COUNT), 1.0) for one in given]
    vectorizer, labels = DictVectorizer(), np.array(are_claims)
    table = vectorizer.fit_transform(known).tocsr()
    first = _fitted(normalize(table), labels)
    decisive = np.abs(first.coef_[0]) * np.sqrt(np.asarray(table.sum(0)).ravel())
    kept = np.sort(np.argsort(-decisive, kind="stable")[:MOST_FEATURES])
    last = _fitted(normalize(table[:, kept]), labels)
    names = vectorizer.get_feature_names_out()[kept]
    weights = {str(name): round(UNIT * float(weight)) for name, weight in zip(names, last.coef_[0], strict=True)}
    return {name: weight for name, weight in sorted(weights.items()) if weight}


def _fitted(table: Any, labels: Any) -> LogisticRegression:
    return LogisticRegression(C=STRENGTH, fit_intercept=False, max_iter=2000, class_weight="balanced").fit(
        table, labels
    )


class Judged(NamedTuple):
    """A sentence of a writer, scored where nothing of the writer was learned."""

    text: str
    is_claim: bool
    score: float
    has_claim: bool
    """One of its clauses scores as a claim by itself."""


def by_others(code: str) -> list[Judged]:
    """Each sentence of each writer."""
    every, found = groups(code), []
    for number, group in enumerate(every[1:], 1):
        rest = [each for other, each in enumerate(every) if other != number]
        weights = learn(
            [text for each in rest for text in each.texts], [is_claim for each in rest for is_claim in each.are_claims]
        )
        scored = ClaimWeights(weights, 0.0, "")
        for text, is_claim in zip(group.texts, group.are_claims, strict=True):
            bare = plain(text)
            has_claim = any(scored.score(clause) > MOST_OF_CLAUSE for clause in scored_clauses(bare))
            found.append(Judged(text, is_claim, scored.score(bare), has_claim))
    return found


def least_score(code: str) -> float:
    """The highest bound at which as few claims pass as may; prints what that costs."""
    claims, found, best = Claims(code), by_others(code), -9.0
    kinds, total = [claims.why_suspected(each.text, VIEW) for each in found], Counter(each.is_claim for each in found)
    print(f"{code}: {total[True]} claims, {total[False]} harmless, each judged by the sentences of other writers")
    for bound in np.arange(-4.0, MOST_OF_CLAUSE, 0.25):
        passed, replaced = 0, 0
        for each, kind in zip(found, kinds, strict=True):
            is_replaced = kind in CERTAIN or (kind != "" and (each.score > bound or each.has_claim))
            passed += each.is_claim and not is_replaced
            replaced += is_replaced and not each.is_claim
        print(f"  bound {bound:5.2f}: {passed / total[True]:6.1%} of the claims pass, "
              f"{replaced / total[False]:6.1%} of the harmless are replaced")  # fmt: skip
        if passed <= MOST_PASSED * total[True]:
            best = float(bound)
    return best


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
        weights = learn(texts, [is_claim for each in every for is_claim in each.are_claims])
        stored = [[group["claims"][code], group["harmless"][code]] for group in stored_groups()]
        digest = hashlib.sha256(json.dumps(stored, ensure_ascii=False).encode()).hexdigest()
        content = {"learned_from": digest, "least": least, "weights": weights}
        FOLDER.mkdir(exist_ok=True)
        path = FOLDER / f"{code}.json"
        path.write_text(json.dumps(content, ensure_ascii=False, indent=0) + "\n", encoding="utf-8")
        print(f"  {path}: {len(weights)} features")


if __name__ == "__main__":
    main()
