# SPDX-License-Identifier: Apache-2.0
"""How requests in free words are read: `python -m benchmarks.bench_requests [--model local] [--count N]`.

The requests of `tests/data/requests`, each over its scene: read by rules, then judged by feasibility. Those held out
are counted apart. With `--model`, a language model reads the same requests into the same schema, and its goals pass the
guards that any goal passes: each thing and number is said in the request, and no rule refuses it.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import json
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.errors import MissionError
from rai_missions.planning import Goal, Scene, feasible, read_goal, read_scene
from rai_missions.planning.reading import RequestReading, goal_parameters, is_said, reading_of
from rai_missions.planning.relations import at_first_poses

FOLDER = Path(__file__).parents[1] / "tests/data/requests"
HELD_OUT = 77
"""Of 256: the first byte of a request's hash below which it is held out."""
LANGUAGES = ("en", "de", "later", "outside")
"""Files of requests; the last two are English too: written after the grammar, and by one who had not read it."""
UNORDERED = frozenset({"next_to", "grouped", "apart", "swapped"})
NUMBERS = ("x", "y", "dx", "dy", "gap_m")
"""Fields of predicates that are numbers."""


class Request(NamedTuple):
    """A request of the corpus."""

    text: str
    scene: Scene
    wanted: Mapping[str, Any]

    @property
    def is_held_out(self) -> bool:
        return hashlib.sha256(self.text.encode()).digest()[0] < HELD_OUT


class Outcome(NamedTuple):
    """What came of it: a goal, a refusal by its code, or a question."""

    goal: Goal | None = None
    refused: str = ""


def corpus(language: str) -> list[Request]:
    """The requests of a language."""
    scenes = {name: read_scene(each) for name, each in _stored("scenes")["scenes"].items()}
    return [Request(each["request"], scenes[each["scene"]], each) for each in _stored(language)["requests"]]


def _stored(name: str) -> Any:
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def by_rule(request: Request) -> Outcome:
    """What the rules read, judged by feasibility."""
    return read_outcome(reading_of(request.text, request.scene), request.scene)


def read_outcome(found: RequestReading, scene: Scene) -> Outcome:
    """What was read, judged by feasibility."""
    if found.goal is None:
        return Outcome(refused="" if found.question else found.reason)
    return judged(found.goal, scene)


def judged(goal: Goal, scene: Scene) -> Outcome:
    """The goal, or its refusal by rule."""
    refusal = feasible(at_first_poses(goal, scene), scene)
    return Outcome(refused=refusal.refused) if refusal is not None else Outcome(goal)


def verdict(request: Request, outcome: Outcome) -> str:
    """`exact`, `asked`, `refused` (though it can be done), `wrong` or `acted` (where it must not)."""
    wanted = request.wanted
    if "goals" in wanted:
        if outcome.goal is not None:
            is_right = any(same(outcome.goal, each) for each in wanted["goals"])
            return "exact" if is_right else "wrong"
        return "refused" if outcome.refused else "asked"
    if outcome.goal is not None:
        return "acted"
    return "exact" if bool(outcome.refused) == ("refused" in wanted) else "refused" if outcome.refused else "asked"


def same(goal: Goal, wanted: Sequence[Mapping[str, Any]]) -> bool:
    """Whether the goal is the one wanted: the same set of predicates, a free tower in any order."""
    found = frozenset(_predicates(goal.written()["all"]))
    return any(found == frozenset(_predicates(each)) for each in _orders(wanted))


def _predicates(goal: Sequence[Mapping[str, Any]]) -> Iterator[tuple[Any, ...]]:
    carrying = {each["on"][1] for each in goal if "on" in each}
    for each in goal:
        if "on" in each and each["on"][1] == "desk" and each["on"][0] in carrying:
            continue  # the foot of a tower
        kind = next(name for name in each if name not in NUMBERS)
        names = [each[kind]] if isinstance(each[kind], str) else each[kind]
        numbers = [round(each[name], 6) for name in NUMBERS if each.get(name) is not None]
        yield kind, *(sorted(names) if kind in UNORDERED else names), *numbers


def _orders(wanted: Sequence[Mapping[str, Any]]) -> Iterator[list[Any]]:
    choices: list[list[list[Any]]] = [
        [
            [{"on": [above, below]} for below, above in itertools.pairwise(order)]
            for order in itertools.permutations(names)
        ]
        if (names := each.get("tower"))
        else [[each]]
        for each in wanted
    ]
    yield from (list(itertools.chain(*combination)) for combination in itertools.product(*choices))


def report(name: str, requests: Sequence[Request], read: Callable[[Request], Outcome]) -> None:
    """Prints the shares of each part."""
    began = time.process_time()
    found = [(each, verdict(each, read(each))) for each in requests]
    spent = time.process_time() - began
    for part, is_held in (("open", False), ("held out", True)):
        can = Counter(result for each, result in found if "goals" in each.wanted and each.is_held_out == is_held)
        must_not = Counter(
            result for each, result in found if "goals" not in each.wanted and each.is_held_out == is_held
        )
        count = max(1, can.total())
        print(
            f"{name:12} {part:9} {can.total():4} can be done: {can['exact'] / count:6.1%} exact, "
            f"{can['asked'] / count:6.1%} asked, {can['refused']} refused, {can['wrong']} wrong; "
            f"{must_not.total():3} must not: {must_not['acted']} acted on, {must_not['exact']} as wanted"
        )
    print(f"{name:12} {1e3 * spent / max(1, len(found)):.2f} ms of CPU a request")


PROMPT = (
    'You turn a request about things on a desk into JSON: {"all": [predicate, …]}. Predicates: {"on": ["a", "b"]} is a '
    'on b, {"in": ["a", "tray"]}, {"at": "a", "x": 0.5, "y": 0.1} in metres, {"left_of": ["a", "b"]}, '
    '{"next_to": ["a", "b"]}, {"grouped": ["a", "b"]}, {"apart": ["a", "b"]}, {"swapped": ["a", "b"]}. '
    "a, b are names of things seen, or desk."
)


def by_model(chat: Any, replies: dict[tuple[str, int], str], *, is_guarded: bool) -> Callable[[Request], Outcome]:
    """A language model's goals, held to the schema by its server.

    Args:
        chat: A langchain chat model.
        replies: What it answered before, which it is not asked again.
        is_guarded: Whether they must pass what any goal must: said in the request, and feasible by rule.
    """

    def read(request: Request) -> Outcome:
        if not request.scene.things:
            return Outcome(refused="absent")
        key = request.text, id(request.scene)
        if key not in replies:
            replies[key] = asked(chat, request)
        try:
            goal = read_goal(json.loads(replies[key]))
        except (ValueError, MissionError):  # cut off, or none of the goal's own schema
            return Outcome()
        if not isinstance(goal, Goal) or (is_guarded and not is_said(goal, request.text, request.scene)):
            return Outcome()
        return judged(goal, request.scene) if is_guarded else Outcome(goal)

    return read


def asked(chat: Any, request: Request) -> str:
    """What the model answers, held to the schema by its server."""
    form = {"type": "json_schema", "json_schema": {"name": "goal", "schema": goal_parameters(request.scene)}}
    things = ", ".join(thing.name for thing in request.scene.things)
    question = [("system", PROMPT), ("user", f"Things: {things}\nRequest: {request.text}")]
    return str(chat.bind(extra_body={"response_format": form}).invoke(question).content)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", help="local, or local:FILE.gguf: a small model on this machine")
    parser.add_argument("--count", type=int, default=40, help="requests that the model reads")
    given = parser.parse_args()
    for language in LANGUAGES:
        report(f"rules, {language}", corpus(language), by_rule)
    if given.model:
        from rai_missions.answerers.model.local_server import ModelServer, packaged_weights

        file = Path(given.model.partition(":")[2]) if ":" in given.model else packaged_weights()
        requests = corpus("en")
        sample = requests[:: max(1, len(requests) // given.count)]
        with ModelServer(file, longest=200) as server:
            chat, replies = server.chat(timeout_s=300.0), dict[tuple[str, int], str]()
            report("model alone", sample, by_model(chat, replies, is_guarded=False))
            report("and guards", sample, by_model(chat, replies, is_guarded=True))


if __name__ == "__main__":
    main()
