# SPDX-License-Identifier: Apache-2.0
"""What is written of a difference: whole, in order, no more than its readers take, and harmless whatever it quotes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from markdown_it import MarkdownIt

import visualize.diff
from benchmarks.bench_draw import chain
from rai_missions.mission.mission import Mission
from tests.strategies import mission_documents, missions
from tests.visualize.changed import changed
from tests.visualize.diff.test_laws import shuffled
from tests.visualize.grammar import read as read_mermaid
from tests.visualize.runs import document, hostile, tractor
from visualize import difference
from visualize.diff.as_json import as_json, plain_difference
from visualize.diff.markdown import LONGEST, markdown
from visualize.diff.page import difference_data, page
from visualize.outline import outline

SCHEMA: dict[str, Any] = json.loads(
    (Path(visualize.diff.__file__).parent / "difference.schema.json").read_text(encoding="utf-8")
)
HTML = MarkdownIt("commonmark", {"html": True}).enable("table")
EVIL = "<script>alert(1)</script> @everyone #1 [a](http://b) `x` | ![i](http://c) </details> ``` <!-- :tada:"


@given(missions(), missions())
def test_json_holds_each_change_and_fits_its_schema(old: Mission, new: Mission) -> None:
    found = difference(old, new)
    reported = json.loads(as_json(found))
    jsonschema.validate(reported, SCHEMA)
    assert reported == json.loads(json.dumps(plain_difference(found)))
    assert [each["sentence"] for each in reported["changes"]] == [each.sentence for each in found.changes]
    assert reported["safety"] + reported["other"] == len(reported["changes"])


@given(missions(), missions())
def test_the_page_leads_from_each_change_to_where_it_is_seen(old: Mission, new: Mission) -> None:
    found = difference(old, new)
    data = difference_data(found)
    transitions = [transition["place"] for transition in data["chart"]["transitions"]]
    states = {state["name"] for state in data["chart"]["states"]}
    assert [each["sentence"] for each in data["changes"]] == [each.sentence for each in found.changes]
    for change in data["changes"]:
        assert not change["transition"] or change["transition"] in transitions
        assert not change["state"] or change["state"] in states
        assert bool(change["transition"]) is ("/transitions/" in change["place"]), change
    marks = {
        transition["place"].startswith("was:")
        for transition in data["chart"]["transitions"]
        if transition.get("mark") == "-"
    }
    assert marks <= {True}


def evil() -> Mission:
    """The design's example, changed in all its texts by an attacker."""
    new = document()
    new["version"] = new["about"] = EVIL
    new["states"]["assessing"]["decision"]["question"] = EVIL
    options = new["states"]["assessing"]["decision"]["options"]
    options["drive_over"] = {"about": EVIL, "when": {"key": "obstacle.kind", "==": EVIL}}
    new["states"]["crossing"]["entry"] = [{"say": EVIL}]
    return Mission.model_validate(new)


def test_markdown_is_inert_whatever_a_mission_holds() -> None:
    text = markdown(difference(tractor(), evil())).decode()
    shown = HTML.render(text)
    assert "@everyone" in shown
    reported = re.sub("<code>[^<>]*</code>", "", shown)  # no host looks for mentions, links or signs in code
    for word in ("<script", "<img", "<a ", "<!--", "everyone", "http:", "tada"):
        assert word not in reported.partition("language-mermaid")[0]
    assert not re.search("@|http://|<script|<!--|:tada:", text)
    assert shown.count("<details>") == shown.count("</details>") == 2
    assert shown.count("<table>") == 2
    cells = [line.count(" | ") for line in text.splitlines() if line.startswith("| ") and "---" not in line]
    assert {count for count in cells if count > 2} <= {3, 4}


def test_markdown_shows_safety_first_and_draws_both() -> None:
    text = markdown(difference(tractor(), changed())).decode()
    head, _, rest = text.partition("<details>")
    assert "6 safety-relevant changes, 5 others" in head
    assert head.count("| ~ changed |") + head.count("| + added |") + head.count("| - removed |") == 6
    assert "5 other changes" in rest
    drawn = read_mermaid(rest.partition("```mermaid\n")[2].partition("```")[0])
    assert any("signalling" in reported for reported in drawn.states.values())


def test_a_comment_stays_within_what_its_host_takes() -> None:
    old, new = chain(500), json.loads(json.dumps(chain(500).written()).replace('"timeout_s": 30', '"timeout_s": 31'))
    for state in new["states"].values():
        for inner in state.get("states", {}).values():
            inner["about"] = EVIL * 3
    text = markdown(difference(old, Mission.model_validate(new)))
    assert len(text.decode()) < LONGEST + 500 < 65_536
    assert b"for which there is no room" in text
    assert b"too large for a comment" in text


def test_nothing_changed_is_reported_in_a_line() -> None:
    text = markdown(difference(tractor(), tractor())).decode()
    assert text.splitlines()[2] == "No difference in meaning."
    assert len(text.splitlines()) == 3


@pytest.mark.parametrize("new", [evil(), hostile()], ids=["evil", "hostile"])
def test_the_page_holds_texts_as_data_alone(new: Mission) -> None:
    text = page(difference(tractor(), new)).decode()
    assert "alert(1)</script>" not in text
    assert text.count("</script>") == 2


@given(mission_documents())
def test_an_outline_does_not_know_the_order_of_keys(given: dict[str, Any]) -> None:
    from random import Random

    one, other = (outline(Mission.model_validate(each)) for each in (given, shuffled(given, Random(1))))
    assert one == other


@given(missions(), missions())
def test_an_outline_is_the_same_for_equal_missions_alone(old: Mission, new: Mission) -> None:
    assert (outline(old) == outline(new)) is (old == new)
