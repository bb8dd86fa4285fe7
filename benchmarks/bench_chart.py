# SPDX-License-Identifier: Apache-2.0
"""What an event costs a chart, next to its peers, and how that and loading grow with the number of states.

CPU time of this process (XState: its own), the best of several rounds, no journal. Peers that are not installed are
left out; `make bench` installs those of Python, `npm install` in tests/oracles the one of JavaScript.
"""

from __future__ import annotations

import itertools
import json
import shutil
import subprocess
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypedDict

from benchmarks.figures import figure, peak_bytes
from rai_missions.check import check
from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission

Json = dict[str, Any]
Send = Callable[[str], object]
CASES = ("flat", "guarded", "levels", "regions")
MOST_US = 0.7
"""What an event may cost."""
TARGETS = {
    "flat": ("transitions", 5),
    "guarded": ("transitions", 4),
    "levels": ("transitions", 20),
    "regions": ("transitions", 25),
}
EVENTS = ("a", "b")
"""Of each case: there and back again."""


def per_event_us(send: Send, events: tuple[str, ...], *, rounds: int = 5, least_s: float = 0.15) -> float:
    """CPU microseconds an event: as many as fill `least_s`, the best round."""
    for event in events * 20:
        send(event)
    count, best = 100, float("inf")
    while True:
        begun = time.process_time()
        for _ in range(count):
            for event in events:
                send(event)
        spent = time.process_time() - begun
        if spent >= least_s:
            break
        count *= 3
    for _ in range(rounds):
        begun = time.process_time()
        for _ in range(count):
            for event in events:
                send(event)
        best = min(best, time.process_time() - begun)
    return best / (count * len(events)) * 1e6


# -- ours -------------------------------------------------------------------------------------------------------------


def transition(on: str, to: str, **words: Any) -> Json:
    return {"on": on, "to": to, **words}


def loop(a: str, b: str) -> Json:
    return {a: {"transitions": [transition("a", b)]}, b: {"transitions": [transition("b", a)]}}


def document(case: str) -> Json:
    counting = {"when": {"key": "n", ">=": 0}, "do": [{"set": "n", "add": 1}]}
    states: Json = {
        "flat": loop("s", "t"),
        "guarded": {
            "s": {"transitions": [transition("a", "t", **counting)]},
            "t": {"transitions": [transition("b", "s", **counting)]},
        },
        "levels": {
            "x": {
                "initial": "y",
                "states": {"y": {"initial": "s", "states": {"s": {"transitions": [transition("a", "t")]}}}},
            },
            "u": {
                "initial": "v",
                "states": {"v": {"initial": "t", "states": {"t": {"transitions": [transition("b", "s")]}}}},
            },
        },
        "regions": {
            "p": {
                "parallel": {
                    "q": {"initial": "s", "states": loop("s", "t")},
                    "r": {"initial": "u", "states": loop("u", "v")},
                }
            }
        },
    }[case]
    keys = {"n": {"type": "integer", "initial": 0}}
    return {"name": case, "events": ["a", "b"], "initial": next(iter(states)), "states": states, "blackboard": keys}


def ours(case: str) -> Send:
    chart = Chart(Mission.model_validate(document(case)))
    chart.start(0.0)
    send, made = chart.send, {name: Event(name, 0.0) for name in ("a", "b")}
    return lambda name: send(made[name])


# -- peers ------------------------------------------------------------------------------------------------------------


class Counter:
    n = 0

    def may(self, *_: Any) -> bool:
        return self.n >= 0

    def add(self, *_: Any) -> None:
        self.n += 1


def transitions_peer(case: str) -> Send:
    from transitions import Machine
    from transitions.extensions import HierarchicalMachine

    model = Counter()
    words: Json = {"conditions": "may", "after": "add"} if case == "guarded" else {}
    if case in ("flat", "guarded"):
        transitions: list[Any] = [
            {"trigger": "a", "source": "s", "dest": "t", **words},
            {"trigger": "b", "source": "t", "dest": "s", **words},
        ]
        Machine(model, states=["s", "t"], transitions=transitions, initial="s", auto_transitions=False)
    elif case == "levels":
        states: list[Any] = [
            {"name": "x", "initial": "y", "children": [{"name": "y", "initial": "s", "children": ["s"]}]},
            {"name": "u", "initial": "v", "children": [{"name": "v", "initial": "t", "children": ["t"]}]},
        ]
        transitions = [["a", "x_y_s", "u_v_t"], ["b", "u_v_t", "x_y_s"]]
        HierarchicalMachine(model, states=states, transitions=transitions, initial="x", auto_transitions=False)
    else:
        regions = [
            {
                "name": name,
                "initial": one,
                "children": [one, other],
                "transitions": [["a", one, other], ["b", other, one]],
            }
            for name, one, other in (("q", "s", "t"), ("r", "u", "v"))
        ]
        HierarchicalMachine(model, states=[{"name": "p", "parallel": regions}], initial="p", auto_transitions=False)
    triggers = {"a": getattr(model, "a"), "b": getattr(model, "b")}  # noqa: B009 - made by the machine
    return lambda name: triggers[name]()


def python_statemachine_peer(case: str) -> Send:
    from statemachine.io.scxml.processor import SCXMLProcessor

    from tests.oracles.scxml_text import scxml_text

    reader = SCXMLProcessor(trusted=True)
    reader.parse_scxml(case, scxml_text(document(case)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        machine: Any = reader.start()  # type: ignore[no-untyped-call]
    send: Send = machine.send
    return send


def python_statemachine_native(case: str) -> Send:
    from statemachine import State, StateChart

    if case == "flat":

        class Flat(StateChart[Any]):
            s, t = State(initial=True), State()
            a, b = s.to(t), t.to(s)

        return Flat().send
    if case == "guarded":

        class Guarded(StateChart[Any]):
            s, t = State(initial=True), State()
            a, b = s.to(t, cond="may", on="add"), t.to(s, cond="may", on="add")
            n = 0

            def may(self) -> bool:
                return self.n >= 0

            def add(self) -> None:
                self.n += 1

        return Guarded().send
    return python_statemachine_peer(case)


def sismic_peer(case: str) -> Send:
    from sismic.interpreter import Interpreter
    from sismic.io.datadict import import_from_dict

    def written(name: str, state: Json) -> Json:
        transitions = [
            {
                "event": each["on"],
                "target": each["to"],
                **({"guard": "n >= 0", "action": "n = n + 1"} if "when" in each else {}),
            }
            for each in state.get("transitions", [])
        ]
        made: Json = {"name": name, **({"transitions": transitions} if transitions else {})}
        if "states" in state:
            made |= {"initial": state["initial"], "states": [written(*each) for each in state["states"].items()]}
        if "parallel" in state:
            made["parallel states"] = [written(*each) for each in state["parallel"].items()]
        return made

    given = document(case)
    root = written("root", {"states": given["states"], "initial": given["initial"]})
    chart = import_from_dict({"statechart": {"name": case, "preamble": "n = 0", "root state": root}})
    interpreter = Interpreter(chart)
    interpreter.execute()

    def send(name: str) -> object:
        return interpreter.queue(name).execute_once()

    return send


def langgraph_peer(case: str) -> Send:
    """One invocation an event: the nearest that a graph of nodes has to a state machine; three levels it has not."""
    from langgraph.graph import END, START, StateGraph

    if case == "levels":
        raise NotImplementedError

    class Known(TypedDict):
        event: str
        state: str
        other: str
        n: int

    flip = {("s", "a"): "t", ("t", "b"): "s"}

    def step(known: Known) -> Json:
        return {
            "state": flip.get((known["state"], known["event"]), known["state"]),
            "n": known["n"] + (case == "guarded"),
        }

    def parallel(known: Known) -> Json:
        return {"other": flip.get((known["other"], known["event"]), known["other"])}

    graph = StateGraph(Known)
    graph.add_node("one", step)
    if case == "guarded":
        graph.add_conditional_edges(START, lambda known: "one" if known["n"] >= 0 else END)
    else:
        graph.add_edge(START, "one")
    graph.add_edge("one", END)
    if case == "regions":
        graph.add_node("two", parallel)
        graph.add_edge(START, "two")
        graph.add_edge("two", END)
    app = graph.compile()
    known: Any = {"event": "", "state": "s", "other": "s", "n": 0}

    def send(name: str) -> object:
        known.update(app.invoke({**known, "event": name}))
        return known

    return send


PEERS: dict[str, Callable[[str], Send]] = {
    "transitions": transitions_peer,
    "sismic": sismic_peer,
    "python-statemachine": python_statemachine_native,
    "LangGraph": langgraph_peer,
}


def xstate_us(case: str) -> float | None:
    """CPU microseconds an event in XState; None where it is not installed."""
    place = Path(__file__).parent.parent / "tests" / "oracles"
    node = shutil.which("node")
    if node is None or not (place / "node_modules" / "xstate").is_dir():
        return None
    run = [node, str(Path(__file__).parent / "bench_chart.mjs"), json.dumps(document(case)["states"]), place.as_posix()]
    return float(subprocess.run(run, capture_output=True, text=True, check=True).stdout)


def measured(peer: str, case: str) -> float | None:
    try:
        send = PEERS[peer](case)
    except (ImportError, NotImplementedError):
        return None
    least = 0.15 if peer != "LangGraph" else 0.1
    return per_event_us(send, EVENTS, rounds=3, least_s=least)


def in_turn(send: Send, events: tuple[str, ...]) -> Callable[[], object]:
    """Sends one event after the other, from the beginning again."""
    names = itertools.cycle(events)
    return lambda: send(next(names))


def cell(us: float | None, own: float) -> str:
    return f"{us:8.2f} ({us / own:4.0f}x)" if us is not None else f"{'–':>16}"


def table() -> None:
    own = {case: per_event_us(ours(case), EVENTS) for case in CASES}
    print("CPU µs an event (times ours)")
    print(f"{'':22}" + "".join(f"{case:>17}" for case in CASES))
    print(f"{'rai_missions':22}" + "".join(f"{own[case]:10.2f}       " for case in CASES))
    peers = {peer: {case: measured(peer, case) for case in CASES} for peer in PEERS}
    peers["XState (node)"] = {case: xstate_us(case) for case in CASES}
    for peer, found in peers.items():
        print(f"{peer:22}" + " ".join(cell(found[case], own[case]) for case in CASES))
    for case, us in own.items():
        nearest = min(((found[case], peer) for peer, found in peers.items() if found[case] is not None), default=None)
        figure(f"an event to a chart: {case}", us, "µs", peer=nearest and (nearest[1], nearest[0] or 0.0), most=MOST_US)
    for case in CASES:
        send = ours(case)
        figure(f"an event to a chart: {case}, memory at its peak", peak_bytes(in_turn(send, EVENTS)), "bytes")
    for case, (peer, times) in TARGETS.items():
        theirs = peers[peer][case]
        if theirs is not None:
            verdict = "reached" if own[case] * times <= theirs else "MISSED"
            print(f"target {case}: at most 1/{times} of {peer}: 1/{theirs / own[case]:.1f}, {verdict}")


# -- size -------------------------------------------------------------------------------------------------------------


def big(count: int) -> Json:
    """A ring of states: `a` leads on, `b` back, and the mission's own row to the end from anywhere."""
    states: Json = {
        f"s{n}": {
            "transitions": [transition("a", f"s{(n + 1) % count}"), transition("b", f"s{n - 1 if n else count - 1}")]
        }
        for n in range(count)
    }
    states["end"] = {"final": "aborted"}
    return {
        "format": 1,
        "name": "big",
        "events": {"a": {}, "b": {}, "stop": {}},
        "initial": "s0",
        "states": states,
        "transitions": [transition("stop", "end")],
    }


def sizes(path: Path) -> None:
    print("states   µs to and fro   µs round the ring   load s   check s   chart s")
    for count in (10, 100, 1_000, 10_000):
        path.write_text(json.dumps(big(count)))
        began = time.process_time()
        mission = load(path)
        loaded = time.process_time()
        findings = check(mission)
        checked = time.process_time()
        chart = Chart(mission)
        chart.start(0.0)
        ready = time.process_time()
        events = {name: Event(name, 0.0) for name in ("a", "b")}
        near = per_event_us(sending(chart, events), ("a", "b"))
        for _ in range(2 * count):
            chart.send(events["a"])
        far = per_event_us(sending(chart, events), ("a",))
        assert not [found for found in findings if found.severity == "error"], findings[:3]
        if count == 10_000:
            figure("10,000 states: load, check and compile", ready - began, "s", most=0.6)
        spent = f"{loaded - began:9.2f} {checked - loaded:9.2f} {ready - checked:9.2f}"
        print(f"{count:6} {near:15.2f} {far:19.2f} {spent}")


def sending(chart: Chart, events: dict[str, Event]) -> Send:
    return lambda name: chart.send(events[name])


def main() -> None:
    import tempfile

    # Before the peers are imported: the garbage collector walks their objects as well.
    with tempfile.TemporaryDirectory() as folder:
        sizes(Path(folder) / "mission.json")
    print()
    table()


if __name__ == "__main__":
    main()
