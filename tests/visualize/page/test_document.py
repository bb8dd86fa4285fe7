# SPDX-License-Identifier: Apache-2.0
"""Nothing in a page's data ends its script element, and the page's policy names the one script that may run."""

from __future__ import annotations

import base64
import hashlib
import html
import re
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

import visualize
from tests.visualize.page.reading import DATA, HOSTILE, answered, data_of
from tests.visualize.runs import tractor
from visualize.page import document, review, run_of_steps
from visualize.page.html import ASSETS, SCRIPTS

TEXTS = st.one_of(st.sampled_from(HOSTILE), st.text(max_size=40))


@given(st.dictionaries(TEXTS, st.lists(TEXTS, max_size=3), max_size=4))
def test_what_goes_in_comes_out_and_nothing_breaks_out(data: dict[str, list[str]]) -> None:
    page = document(data, title="a")
    found = DATA.search(page)
    assert found is not None
    assert not set(b"<>&") & set(found[1])
    assert data_of(page) == data
    assert page.count(b"</script>") == document({}, title="a").count(b"</script>")


@given(TEXTS)
def test_a_title_is_a_title(title: str) -> None:
    page = document({}, title=title).decode()
    assert page.count("<script") == document({}, title="").decode().count("<script")
    assert re.search(r"<title>[^<>]*</title>", page)


def test_the_policy_names_the_page_s_own_script_and_style_and_no_other_source() -> None:
    page = document({}, title="a").decode()
    policy = html.unescape(re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1])  # type: ignore[index]
    for tag, word in (("style", "style-src"), ("script", "script-src")):
        text = re.search(rf"<{tag}>(.*?)</{tag}>", page, re.DOTALL)[1]  # type: ignore[index]
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{word} 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert "connect-src 'none'" in policy
    assert "unsafe" not in policy
    assert "http" not in policy


def test_the_page_fetches_nothing() -> None:
    page = document({}, title="a").decode().replace("http://www.w3.org/2000/svg", "")
    assert not re.search(r"""(src|href)=["'](?!#)|@import|url\((?!#)|https?://|fetch\(|XMLHttpRequest""", page)


def test_no_script_reads_text_as_markup() -> None:
    for path in ASSETS.glob("*.js"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|new Function", text), path


def test_every_script_is_in_a_page_and_names_its_licence() -> None:
    assert {path.name for path in ASSETS.glob("*.js")} == set(SCRIPTS)
    for path in ASSETS.iterdir():
        if path.suffix != ".html":
            assert "SPDX-License-Identifier: Apache-2.0" in path.read_text(encoding="utf-8").splitlines()[0]


def test_no_line_of_a_script_or_a_style_is_longer_than_one_of_python() -> None:
    folder = Path(visualize.__file__).parent
    for path in (*folder.rglob("*.js"), *folder.rglob("*.css")):
        lines = path.read_text(encoding="utf-8").splitlines()
        assert [number for number, line in enumerate(lines, 1) if len(line) > 120] == [], path


def test_a_step_states_a_verdict_once_and_who_has_control_in_words() -> None:
    [run] = data_of(review(tractor(), runs=[run_of_steps(answered(tractor()))]))["runs"]
    notes = {index: run["pool"][row[6]].get("notes", []) for index, row in enumerate(run["steps"])}
    judged = [each for each in run["questions"] if "answered" in each]
    assert judged and not [each for each in judged if {*notes[each["answered"]]} & {*each["verdict"]}]
    stated = [note for each in notes.values() for note in each if note.startswith("control:")]
    assert "control: agent" not in stated and "control: the mission itself" in stated
