# SPDX-License-Identifier: Apache-2.0
"""Constructors: what an editor completes and `help()` explains is what there is."""

from __future__ import annotations

import importlib
import inspect
import pydoc
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jedi
import pytest
from pydantic_core import PydanticUndefined

from rai_missions import After, DefinitionError, EventSpec, Key, Keys, Log, Mission, On, Ref, Set, When, states
from rai_missions.guards import Guard, Named
from rai_missions.model import MissionModel, Seconds
from rai_missions.states import Action, Budget, Decision, DecisionSpec, Default, Option, Transition, tree
from rai_missions.states.effects import Effect
from rai_missions.states.state import State
from rai_missions.states.tree import TreeNode

ROOT = Path(__file__).parents[2]
KINDS: dict[str, type[Any]] = {
    f"{family.__name__}.{word or 'plain'}": kind
    for family in (Effect, Guard, State, TreeNode)
    for word, kind in family.kinds.items()
} | {kind.__name__: kind for kind in (Budget, DecisionSpec, Default, EventSpec, Key, Mission, Option, Transition)}
RENAMED = {"keys": "blackboard"}


def fields(kind: Any) -> Iterator[tuple[str, Any]]:
    """The words of a constructor as its models have them: name and default."""
    for name, field in kind.model_fields.items():
        if name == "decision":
            yield from fields(DecisionSpec)
        else:
            yield name, field.get_default(call_default_factory=True)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_constructor_is_declared_with_the_fields_and_their_defaults(kind: Any) -> None:
    known, declared = dict(fields(kind)), inspect.signature(kind).parameters
    if kind is states.Tree:
        known["tick_s"] = 0.1
    if kind is Default:
        known = {name: known[name] for name in ("to", "about")} | {"to": PydanticUndefined}
    assert {RENAMED.get(name, name) for name in declared} == set(known)
    for name, parameter in declared.items():
        default = known[RENAMED.get(name, name)]
        assert parameter.annotation is not parameter.empty, name
        if parameter.default is parameter.empty:
            assert default is PydanticUndefined, name
        else:
            assert default == parameter.default or not (default or parameter.default), name


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_help_explains_every_word(kind: Any) -> None:
    text = inspect.getdoc(kind)
    assert text is not None
    for name, parameter in inspect.signature(kind).parameters.items():
        line = next((each for each in text.splitlines() if each.startswith(f"    {name}: ")), None)
        assert line is not None, name
        if parameter.default not in (parameter.empty, None, (), "") and parameter.default != {}:
            assert f"Default: {parameter.default!r}." in text, name


UNITS = {"_s": "econds", "_m": "metres", "seconds": "Seconds", "tokens": "Tokens"}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_help_states_the_unit_of_every_number_that_has_one(kind: Any) -> None:
    texts = kind.meanings()
    for name in inspect.signature(kind).parameters:
        unit = next((unit for end, unit in UNITS.items() if name.endswith(end)), "")
        assert unit in texts[name], f"{name}: {texts[name]}"


def test_help_is_what_a_person_reads() -> None:
    text = pydoc.plain(pydoc.render_doc(Action))
    one_line = re.sub(r"\n \|\s+", " ", text).replace("( ", "(")  # from Python 3.13 each word has a line of its own
    one_line = one_line.replace("'", "")  # until Python 3.13 a type is quoted
    assert "Action(action: str, *, goal: Mapping[str, Value] = {}" in one_line
    assert "    cancel_s: Seconds that the end of a canceled goal may take to be confirmed" in text
    assert "    timeout_s: Seconds after which it reports `timed_out` and the goal is canceled." in text
    assert "*given" not in text
    assert Action.summary() == "Pursues a goal. Its success counts only while `achieved` is true."


def test_help_explains_the_words_of_a_module_that_postpones_no_annotations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    imported = "from rai_missions.model import MissionModel, Seconds"
    text = f'{imported}\n\nclass Wait(MissionModel):\n    for_s: Seconds\n    """Seconds."""\n'
    (tmp_path / "eager_words.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert importlib.import_module("eager_words").Wait.meanings()["for_s"] == "Seconds."


@pytest.mark.parametrize("function", [On, When, After, Ref.near, Ref.is_in])
def test_functions_for_authors_explain_their_words(function: Any) -> None:
    text = inspect.getdoc(function) or ""
    assert [name for name in inspect.signature(function).parameters if f"    {name}: " not in text] in ([], ["self"])


@pytest.mark.parametrize(
    ("wrong", "fault"),
    [
        (lambda: On("a", too="b"), "On(…): /too: 'On' has no 'too'; did you mean 'to'?"),
        (lambda: When(Guard.read({"in": "a"}), wehn=1, to="b"), "/wehn: 'When' has no 'wehn'; did you mean 'when'?"),
        (
            lambda: Mission("m", initial="a", states={"a": State()}, kyes={}),
            "Mission(…): /kyes: a mission has no 'kyes'; did you mean 'keys'?",
        ),
        (lambda: Keys(n=int), "Keys(…): /n: <class 'int'> is no key; write Key(…)"),
        (
            lambda: tree.Sequence([Named("on")]),
            "/sequence/0: a tree node is an object, not a guard; put it in tree.Check(",
        ),
        (
            lambda: tree.Sequence([Ref("on")]),
            "/sequence/0: a tree node is an object, not <on>; put it in tree.Check(…)",
        ),
        (
            lambda: tree.Sequence([Action("go")]),
            "not a state; the nodes of trees are in rai_missions.states.tree: tree.A",
        ),
        (
            lambda: states.Compound(initial="go", states={"go": tree.Wait(1)}),
            "/states/go: a state is an object, not a tree node; a tre",
        ),
        (lambda: State(entry=[Named("on")]), "/entry/0: an effect is an object, not a guard"),
        (lambda: Set("n", add=Ref("k")), "/add: <k> is not a number; its value is known in a run: write a constant"),
        (
            lambda: Action("go", result=Ref("k")),
            "/result: <k> is not an object; its value is known in a run: write a const",
        ),
        (lambda: Option("go", whn=1), "Option(…): /whn: an option has no 'whn'; did you mean 'when'?"),
        (lambda: tree.Call("horn", timeot_s=1), "a tree node with 'call' has no 'timeot_s'; did you mean 'timeout_s'?"),
        (
            lambda: Decision("?", options={"go": Option()}, deadlin_s=3, timeot_s=1),
            "/decision/deadlin_s: a decision has no 'deadlin_s'; did you mean 'deadline_s'?",
        ),
        (
            lambda: Decision("?", options={"go": Option()}, timeot_s=1),
            "/timeot_s: a state with 'decision' has no 'timeot_s'; did you mean 'timeout_s'?",
        ),
    ],
)
def test_a_wrong_word_is_refused_with_the_right_one(wrong: Any, fault: str) -> None:
    with pytest.raises(DefinitionError) as reported:
        wrong()
    assert fault in str(reported.value)


def test_what_is_given_in_the_wrong_order_is_refused_with_the_right_one() -> None:
    with pytest.raises(DefinitionError) as reported:
        tree.Repeat(3, tree.Wait(1))  # type: ignore[arg-type]
    assert "Repeat(child, num_success, …): /child: a tree node is an object, not 3" in str(reported.value)


def test_what_it_prints_is_what_it_was_given() -> None:
    assert repr(Action("go", timeout_s=5)) == "Action(timeout_s=5.0, action='go')"


def test_a_wrong_attribute_is_reported_with_the_right_one() -> None:
    with pytest.raises(AttributeError) as reported:
        Action("go").timeout  # noqa: B018
    assert str(reported.value) == "Action has no attribute 'timeout'; did you mean 'timeout_s'?"
    assert not hasattr(Action("go"), "anything")
    with pytest.raises(AttributeError, match="has no attribute 'Timeot'; did you mean 'Timeout'"):
        tree.Timeot  # noqa: B018


def test_keys_and_fields_are_completed_where_a_program_is_alive() -> None:
    k = Keys(pose=Key("pose"), thing=Key(dict, fields={"kind": str}))
    assert dir(k) == ["pose", "thing"]
    assert {"kind", "is_in", "fresh"} <= set(dir(k.thing))
    assert {"x", "near"} <= set(dir(k.pose))


def test_one_effect_needs_no_list() -> None:
    assert State(entry=Log("in")) == State(entry=[Log("in")])
    assert On("a", do=Log("on the way")) == On("a", do=[Log("on the way")])


def test_a_kind_that_declares_no_constructor_takes_its_fields() -> None:
    class Pause(State):
        positional = ("pause_s",)
        pause_s: Seconds

    assert Pause(2, about="a while").pause_s == 2
    assert vars(Pause)["__init__"] is vars(MissionModel)["__init__"]


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ('Action("drive", timeo', "timeout_s="),
        pytest.param('On("blocked", wh', "when=", marks=pytest.mark.long),
        pytest.param('Decision("What?", deadl', "deadline_s=", marks=pytest.mark.long),
        pytest.param('tree.Call("horn", req', "request=", marks=pytest.mark.long),
        pytest.param("Key(float, sou", "source=", marks=pytest.mark.long),
    ],
)
def test_an_editor_completes_the_words(
    line: str, word: str, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As Jedi does, which reads the source as editors do; its cache is this process's own."""
    monkeypatch.setattr(jedi.settings, "cache_directory", str(tmp_path_factory.getbasetemp() / "jedi"))
    source = f"from rai_missions import Key, On\nfrom rai_missions.states import Action, Decision, tree\n{line}"
    completed = jedi.Script(source, project=jedi.Project(ROOT)).complete(3, len(line))
    assert word in [each.name for each in completed]


@pytest.mark.parametrize("family", [Effect, Guard, State, TreeNode], ids=lambda each: each.__name__)
def test_a_class_where_what_it_makes_is_due_is_answered_with_its_call(family: Any) -> None:
    for kind in family.kinds.values():
        with pytest.raises(ValueError, match=rf"is an object, not .*; write {kind.__name__}\(…\)"):
            family.read(kind)


@pytest.mark.parametrize(
    ("made", "sentence"),
    [
        (
            lambda: Mission("m", initial="a", states={"a": Action}),
            r"/states/a: a state is an object.*; write Action\(…\)",
        ),
        (lambda: State(transitions=[On]), r"/transitions/0: .* is not an object; write On\(…\)"),
        (lambda: State(transitions=On("go", to="a")), r"/transitions: Transition\(.* is not a list; write \[…\]"),
        (lambda: Action("go", timeout_s=min), r"/timeout_s: .* is not a number; write min\(…\)"),
    ],
)
def test_what_is_of_another_kind_is_named_with_what_would_be_right(made: Any, sentence: str) -> None:
    with pytest.raises(DefinitionError, match=sentence):
        made()
