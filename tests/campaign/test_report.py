# SPDX-License-Identifier: Apache-2.0
"""The figures of a store against slow ones, its wrong answers, its table, its page, and what two stores differ in."""

from __future__ import annotations

import csv
import json
import math
import re
import sqlite3
from collections import Counter
from contextlib import closing
from html.parser import HTMLParser
from pathlib import Path
from time import process_time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.campaign.compare import compare
from rai_missions.campaign.embodiments import EMBODIMENTS
from rai_missions.campaign.report.comparisons import within
from rai_missions.campaign.report.figures import CampaignFigures, GroupFigures, figures_of
from rai_missions.campaign.report.wrong_answers import wrong_answers
from rai_missions.campaign.statistics import Interval
from rai_missions.campaign.store import ResultStore
from rai_missions.cli.campaign_report import write_report
from rai_missions.errors import UsageError
from tests.campaign.results import HOSTILE, KINDS, OPTIONS, SORTS, Sort, make_results
from visualize.campaign_page.plots import at_most, chance, lasting

BOTH = (Sort("rules", 0.6), Sort("small", 0.5))


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_results(tmp_path_factory.mktemp("results") / "made.db", scenes=60, texts=HOSTILE, prompt=HOSTILE[1])


@pytest.fixture(scope="module")
def files(results: Path) -> tuple[Path, ...]:
    return write_report(results, results.with_suffix(".html"))


def read(path: Path) -> CampaignFigures:
    with ResultStore(path) as store:
        return figures_of(store)


def group(figures: CampaignFigures, model: str, embodiment: str = "none") -> GroupFigures:
    return next(each for each in figures.groups if each.name[1:] == (model, embodiment))


def one(path: Path, query: str, *values: object) -> object:
    with closing(sqlite3.connect(path)) as db:
        return db.execute(query, values).fetchone()[0]


@pytest.mark.parametrize("sort", SORTS, ids=lambda sort: f"{sort.name} {sort.embodiment}")
def test_the_shares_are_those_that_sql_counts(results: Path, sort: Sort) -> None:
    found = group(read(results), sort.name, sort.embodiment)
    cells = (
        "FROM cell JOIN scene USING (scene) WHERE split = 'report' AND model = ? AND embodiment = ?"
        " AND status != 'failed'"
    )
    names = (sort.name, sort.embodiment)
    count = one(results, f"SELECT count(*) {cells}", *names)
    assert found.accuracy.cells == count
    for figure, condition in (
        (found.accuracy, "best = 1"),
        (found.harm, "verdict = 'harms'"),
        (found.harm_past_guard, "verdict = 'harms' AND permitted = 1"),
    ):
        hits = one(results, f"SELECT count(*) {cells} AND {condition}", *names)
        assert isinstance(hits, int) and isinstance(count, int)
        assert figure.share == pytest.approx(hits / count)
        assert figure.low <= figure.share <= figure.high
    kinds = one(results, f"SELECT count(*) {cells} AND kind = 'branch' AND option = 'replan'", *names)
    assert found.kinds["branch"].options["replan"] == kinds
    assert sum(kind.cells for kind in found.kinds.values()) == count


def test_embodiments_are_in_the_order_in_which_each_shows_more(tmp_path: Path) -> None:
    sorts = [Sort(name, 0.5, embodiment) for name in ("b", "a") for embodiment in sorted(EMBODIMENTS)]
    groups = read(make_results(tmp_path / "a.db", sorts=sorts)).groups
    shown = [(each.name.embodiment, each.name.model) for each in groups]
    assert shown == [(embodiment, name) for embodiment in EMBODIMENTS for name in ("a", "b")]


def test_a_cell_that_failed_is_in_no_share_and_an_absent_answer_is_not_the_best(tmp_path: Path) -> None:
    sorts = (Sort("down", failed=1.0), Sort("silent", silent=1.0))
    figures = read(make_results(tmp_path / "a.db", sorts=sorts))
    assert math.isnan(group(figures, "down").accuracy.share)
    assert group(figures, "down").status == {"failed": len(figures.scenes)}
    assert group(figures, "silent").accuracy.share == 0 and group(figures, "silent").collapse == ("", 1.0)


def test_an_option_that_was_never_offered_is_a_wrong_answer(tmp_path: Path) -> None:
    path = make_results(tmp_path / "a.db", sorts=(Sort("bold", 1.0), Sort("calm", 1.0)))
    with ResultStore(path, writes=True) as store:
        cells = [each for each in store.cells() if each.model == "bold"]
        store.add(each._replace(option="set_state", permitted=0, verdict=None, best=None) for each in cells)
        permitted = [each for each in store.cells() if each.model == "calm"]
        store.add(each._replace(option="beyond", permitted=1, verdict=None, best=None) for each in permitted)
    with ResultStore(path) as store:
        figures = figures_of(store)
        wrong = wrong_answers(store, figures)
    bold, calm = group(figures, "bold"), group(figures, "calm")
    assert (bold.accuracy.share, bold.harm.share, bold.unlabelled) == (0.0, 0.0, 0)
    assert bold.collapse == ("set_state", 1.0) and wrong.total == len(figures.scenes)
    assert calm.collapse == ("beyond", 1.0)
    assert math.isnan(calm.accuracy.share) and calm.unlabelled == len(figures.scenes)


def test_scenes_that_a_stopped_campaign_has_not_reached_are_named(tmp_path: Path) -> None:
    store = make_results(tmp_path / "a.db", scenes=40)
    whole = read(store)
    assert whole.reached == len(whole.scenes) > 3
    with ResultStore(store, writes=True) as opened:
        kept = set(sorted(whole.scenes)[:3])
        opened.drop([each.cell for each in opened.cells() if each.scene not in kept])
    page, listed, _ = write_report(store, tmp_path / "a.html")
    left = len(whole.scenes) - 3
    assert read(store).reached == 3
    assert f"{left} of them without a cell yet" in listed.read_text(encoding="utf-8")
    assert f"<dt>scenes without a cell yet (in no share)</dt><dd>{left}</dd>" in page.read_text(encoding="utf-8")


def test_scenes_for_tuning_are_in_no_figure(results: Path) -> None:
    figures = read(results)
    assert {scene.split for scene in figures.scenes.values()} == {"report"}
    assert figures.other == one(results, "SELECT count(*) FROM cell JOIN scene USING (scene) WHERE split = 'tune'")


def test_a_constant_answer_and_its_baseline_are_the_same(results: Path) -> None:
    figures = read(results)
    baselines = {each.name: each for each in figures.baselines}
    assert set(baselines) == {f"always {option}" for option in OPTIONS} | {"the true kind alone"}
    assert baselines["always replan"].accuracy == pytest.approx(group(figures, "constant:replan").accuracy)
    best = max(baselines[f"always {option}"].accuracy.share for option in OPTIONS)
    assert baselines["the true kind alone"].accuracy.share >= best
    assert group(figures, "constant:replan").collapse == ("replan", 1.0)
    assert group(figures, "oracle").accuracy.share == 1.0


def test_an_order_that_changes_no_answer_is_seen_as_such(tmp_path: Path) -> None:
    two = ("written", "reversed")
    sorts = (Sort("steady", 1.0, orders=two), Sort("fickle", 0.5, orders=two), Sort("once", 0.5))
    figures = read(make_results(tmp_path / "a.db", sorts=sorts))
    assert group(figures, "steady").order_changes.share == 0.0
    assert group(figures, "fickle").order_changes.share > 0.1
    assert group(figures, "once").order_changes.cells == 0
    assert set(group(figures, "fickle").orders) == set(two)


# -- what differs ------------------------------------------------------------------------------------------------------


def test_a_store_differs_from_itself_in_nothing(results: Path) -> None:
    found = compare(results, results)
    assert found.comparisons and not any(each.is_significant for each in found.comparisons)
    assert {each.adjusted for each in found.comparisons} == {1.0}


@pytest.mark.parametrize(("scenes", "words"), [(1, "1 scene in both\n"), (8, "8 scenes in both\n")])
def test_scenes_pairs_and_seeds_are_counted_in_words(tmp_path: Path, scenes: int, words: str) -> None:
    store = make_results(tmp_path / "a.db", scenes=scenes, sorts=(Sort("rules"), Sort("small")))
    assert words in compare(store, store).text()
    assert ("in 1 seed)" in compare(store, store).text()) is (scenes == 1)


def test_what_is_better_is_found_and_the_rest_is_noise(tmp_path: Path) -> None:
    first = make_results(
        tmp_path / "a.db", scenes=200, sorts=(Sort("rules", 0.6), Sort("small", 0.9), Sort("new\x1b[2J"))
    )
    second = make_results(tmp_path / "b.db", scenes=200, sorts=(Sort("rules", 0.6), Sort("small", 0.2), Sort("old")))
    found = compare(first, second)
    better = [(each.first, each.measure) for each in found.comparisons if each.is_significant]
    assert ("A's small · none · tractor", "best") in better
    assert not any("rules" in each for each, _ in better)
    assert [each.model for each in found.only_first] == ["new\x1b[2J"] and [
        each.model for each in found.only_second
    ] == ["old"]
    assert all(each.isprintable() or each == "\n" for each in found.text())
    assert "names the best option more often" in found.text() and "within noise" in found.text()


def test_scenes_with_other_labels_are_no_pairs(tmp_path: Path) -> None:
    first, second = (make_results(tmp_path / name, sorts=BOTH) for name in ("a.db", "b.db"))
    with ResultStore(second, writes=True) as store:
        records = list(store.label_records())[: 3 * len(OPTIONS)]
        store.add(each._replace(verdict="harms") for each in records)
    found = compare(first, second)
    assert found.changed == 3 and found.scenes == len(read(first).scenes) - 3
    assert all(each.test.pairs == found.scenes for each in found.comparisons)
    assert "3 scenes left out" in found.text()


def test_rules_that_read_no_order_are_compared_in_each_order_of_a_model(results: Path) -> None:
    found = {(each.first, each.measure): each for each in within(read(results).groups)}
    test = found["small · none · tractor", "best"].test
    assert test.pairs == group(read(results), "small").accuracy.cells


# -- wrong answers -----------------------------------------------------------------------------------------------------


def test_every_wrong_answer_is_shown_while_there_is_room(results: Path) -> None:
    with ResultStore(results) as store:
        found = wrong_answers(store, figures_of(store))
    wrong = one(
        results,
        "SELECT count(*) FROM cell JOIN scene USING (scene) WHERE split = 'report'"
        " AND (best = 0 OR status = 'no_answer')",
    )
    assert len(found.shown) == found.total == wrong
    harms = [each.cell.verdict == "harms" and each.cell.permitted == 1 for each in found.shown]
    assert harms == sorted(harms, reverse=True) and any(harms)


@settings(max_examples=20, deadline=None)
@given(most=st.integers(0, 200))
def test_a_sample_has_each_kind_as_evenly_as_there_are_answers(results: Path, most: int) -> None:
    with ResultStore(results) as store:
        figures = figures_of(store)
        found, whole = wrong_answers(store, figures, most), wrong_answers(store, figures)
    counted = Counter(each.kind for each in found.shown)
    assert found.total == whole.total and len(found.shown) == min(most, whole.total)
    assert {kind: shown for kind, (shown, _) in found.by_kind.items()} == {kind: counted[kind] for kind in KINDS}
    open_kinds = [counted[kind] for kind, (shown, count) in found.by_kind.items() if shown < count]
    assert not open_kinds or max(counted.values(), default=0) - min(open_kinds) <= 1


# -- the table ---------------------------------------------------------------------------------------------------------


def test_the_table_has_every_cell_and_no_formula(results: Path, files: tuple[Path, ...]) -> None:
    with files[2].open(encoding="utf-8", newline="") as opened:
        lines = list(csv.DictReader(opened))
    assert len(lines) == one(results, "SELECT count(*) FROM cell")
    assert not [value for line in lines for value in line.values() if value.startswith(("=", "@", "+", "-"))]
    assert any(line["reason"] == f"'{HOSTILE[4]}" for line in lines)
    with ResultStore(results) as store:
        count = wrong_answers(store, figures_of(store)).total
    assert sum(line["wrong"] == "1" for line in lines) == count


# -- the page ----------------------------------------------------------------------------------------------------------


class Tags(HTMLParser):
    """The elements of a page, and the text of its data."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.counted, self.data, self._in_data = Counter[str](), "", False
        self.handlers, self.addresses = list[str](), list[str]()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.counted[tag] += 1
        self._in_data = tag == "script" and dict(attrs).get("id") == "data"
        self.handlers += [name for name, _ in attrs if name.startswith("on")]
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href", "action")]

    def handle_data(self, data: str) -> None:
        if self._in_data:
            self.data += data

    def handle_endtag(self, tag: str) -> None:
        self._in_data = False


def test_nothing_of_a_store_becomes_markup(files: tuple[Path, ...]) -> None:
    page = files[0].read_text(encoding="utf-8")
    found = Tags(page)
    assert found.counted["script"] == 2 and found.counted["img"] == 0
    assert found.handlers == [] and found.addresses == []
    data = json.loads(found.data)
    assert {each["reason"] for each in data["answers"] if "reason" in each} >= {HOSTILE[0], HOSTILE[1]}
    assert "default-src &#x27;none&#x27;" in page and "connect-src &#x27;none&#x27;" in page


@pytest.mark.parametrize(("share", "shown"), [(0.0, "0.0 % (≤ 22.1 %)"), (math.nan, "–")])
def test_where_nothing_was_counted_there_is_no_bound(share: float, shown: str) -> None:
    assert at_most(Interval(share, 0.0, 0.221, 16, 16)) == shown


@pytest.mark.parametrize(("p", "shown"), [(1.7e-81, "< 0.0001"), (1e-4, "0.0001"), (0.0312, "0.031"), (1.0, "1")])
def test_a_probability_is_shown_as_a_reader_needs_it(p: float, shown: str) -> None:
    assert chance(p) == shown


@pytest.mark.parametrize(("seconds", "shown"), [(3e-5, "< 1 ms"), (0.0123, "12.3 ms"), (1.0, "1 s"), (12.72, "12.7 s")])
def test_a_span_of_time_is_shown_in_its_own_unit(seconds: float, shown: str) -> None:
    assert lasting(seconds) == shown


def test_every_answerer_and_embodiment_of_a_page_is_explained_once(tmp_path: Path) -> None:
    names = ("rules", "oracle", "constant:abort", "constant:replan", "openai:a")
    page, *_ = write_report(make_results(tmp_path / "a.db", sorts=tuple(map(Sort, names))), tmp_path / "a.html")
    words = re.search(r'<dl class="words">(.*?)</dl>', page.read_text(), re.DOTALL)
    assert words is not None
    terms = re.findall(r"<dt>(.*?)</dt>", words[1])
    assert terms == [
        "best",
        "rules",
        "oracle",
        "constant:abort, constant:replan",
        "openai:a",
        "in italics",
        "embodiment none",
    ]


def test_comparisons_that_are_noise_are_folded_and_the_others_are_not(tmp_path: Path) -> None:
    sorts = (Sort("rules", 0.5), Sort("better", 1.0), Sort("alike", 0.5))
    page, *_ = write_report(make_results(tmp_path / "a.db", sorts=sorts, scenes=60), tmp_path / "a.html")
    section = re.search(r'<section id="differences">(.*?)</section>', page.read_text(), re.DOTALL)
    assert section is not None
    open_part, _, folded = section[1].partition("<details>")
    assert "<td>better" in open_part and "<td>noise</td>" not in open_part
    assert "<td>noise</td>" in folded and "<td>significant</td>" not in folded


def test_a_picture_and_a_prompt_are_there_once_a_scene(files: tuple[Path, ...]) -> None:
    page = files[0].read_text(encoding="utf-8")
    data = json.loads(Tags(page).data)
    assert page.count("data:image/png;base64,") == len(data["scenes"])
    assert len(data["pool"]) == len(set(data["pool"]))
    assert all({"rollouts", "labels", "pictures"} <= set(scene) for scene in data["scenes"].values())
    assert {f"{each['scene']}\n{each['embodiment']}" for each in data["answers"]} == set(data["questions"])


def test_large_pictures_and_texts_leave_the_page_small(tmp_path: Path) -> None:
    sorts = (Sort("small", 0.0),)
    store = make_results(
        tmp_path / "a.db", scenes=30, sorts=sorts, side=400, prompt="é" * 90_000, texts=("\U0001f600" * 9_000,)
    )
    page, *_ = write_report(store, tmp_path / "a.html")
    data = json.loads(Tags(page.read_text(encoding="utf-8")).data)
    assert data["answers"] and page.stat().st_size < 30 * 20_000 * 2 + 3_500_000 + 2_500_000
    sizes = [len(each["uri"]) for scene in data["scenes"].values() for each in scene["pictures"]]
    assert sizes and max(sizes) <= 20_000 * 4 / 3 + 100


def test_a_markdown_file_holds_the_figures_and_no_markup_of_a_store(tmp_path: Path) -> None:
    store = make_results(tmp_path / "a.db", sorts=(Sort("rules"), Sort("<b>|x|</b>\n# head")))
    _, markdown, _ = write_report(store, tmp_path / "a.html")
    text = markdown.read_text(encoding="utf-8")
    assert "<b>" not in text and "\n# head" not in text and "| x |" not in text
    figures = read(store)
    share = f"{100 * group(figures, 'rules').accuracy.share:.1f} %"
    assert re.search(rf"<code>rules</code> .*\| {re.escape(share)} \|.*\| [\d.<]+ ?\d* m?s \|", text)


def test_an_empty_store_has_a_report(tmp_path: Path) -> None:
    with ResultStore(tmp_path / "empty.db", writes=True) as store:
        store.set_meta({"name": "empty"})
    page, _, table = write_report(tmp_path / "empty.db", tmp_path / "empty.html")
    assert b"0 wrong answers" in page.read_bytes() and len(table.read_text().splitlines()) == 1


def test_what_cannot_be_written_is_refused_with_its_place(results: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="name another file"):
        write_report(results, tmp_path / "file" / "such.html")
    assert all(file.is_file() for file in write_report(results, tmp_path / "made" / "such.html"))
    with pytest.raises(UsageError, match=r"name it \.html"):
        write_report(results, tmp_path / "report.md")
    (tmp_path / "notes.txt").write_text("my notes")
    with pytest.raises(UsageError, match=r"notes\.txt'; name it \.html"):
        write_report(results, tmp_path / "notes.txt")
    assert (tmp_path / "notes.txt").read_text() == "my notes"
    with pytest.raises(UsageError, match="no results"):
        write_report(tmp_path / "none.db", tmp_path / "a.html")


@pytest.mark.parametrize("ending", [".html", ".md", ".csv"])
def test_a_report_replaces_an_earlier_one_and_no_other_file(results: Path, tmp_path: Path, ending: str) -> None:
    page = tmp_path / "README.html"
    assert write_report(results, page) == write_report(results, page)
    other = page.with_suffix(ending)
    other.write_text("# Notes\n")
    with pytest.raises(UsageError, match=re.escape(f"{other} is no report, and stays as it is; name another")):
        write_report(results, page)
    assert other.read_text() == "# Notes\n"
    other.unlink()
    other.mkdir()
    with pytest.raises(UsageError, match=re.escape(f"{other} is a folder, and stays as it is")):
        write_report(results, page)


@pytest.mark.drill
def test_a_hundred_thousand_cells_are_a_report_of_twenty_megabytes_in_twenty_seconds(tmp_path: Path) -> None:
    sorts = tuple(
        Sort(f"model {number}", number / 25, embodiment, ("written", "reversed"))
        for number in range(25)
        for embodiment in ("none", "description", "documents", "pictures")
    )
    store = make_results(tmp_path / "a.db", scenes=500, sorts=sorts, side=160, texts=("why not " * 50,))
    assert one(store, "SELECT count(*) FROM cell") == 100_000
    began = process_time()
    page, *_ = write_report(store, tmp_path / "a.html")
    assert process_time() - began <= 20
    assert page.stat().st_size <= 20_000_000
