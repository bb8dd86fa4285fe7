# SPDX-License-Identifier: Apache-2.0
"""Every format gives the same text under the same headings; what no person sees is no text; bad files are refused."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Iterator
from importlib.util import find_spec

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.embodiment.chunks import LONGEST_SENTENCE, passages_of
from rai_missions.embodiment.document import Section, TextDocument
from rai_missions.embodiment.readers import FORMATS, read_document
from rai_missions.embodiment.reading_process import ReadingProcess
from tests.rigs.documents import WRITERS, W, docx, html_page, markdown, pdf, zipped

needs_pypdf = pytest.mark.skipif(find_spec("pypdf") is None, reason="pypdf is not installed: the extra `identity`")
PARTS = [
    (0, "A paragraph ahead of all headings."), (1, "Care"), (0, "Wipe it & dry it."), (2, "Every week"),
    (0, "Pressure: 1.2 bar <cold>."), (0, "Grease it."), (1, "Storage"), (0, "Dry."),
]  # fmt: skip


def read(name: str, data: bytes) -> TextDocument:
    return read_document(name, data)


def text(document: TextDocument) -> str:
    return "\n\n".join(section.text for section in document.sections)


def fault(name: str, data: bytes) -> str:
    with pytest.raises(ValueError, match=r"\w") as caught:
        read(name, data)
    return str(caught.value)


@pytest.mark.parametrize("ending", [".docx", ".html", ".txt"])
def test_a_document_is_the_same_in_every_format(ending: str) -> None:
    document = read(f"care{ending}", WRITERS[ending](PARTS))
    assert [(section.heading, section.text) for section in document.sections] == [
        ((), "A paragraph ahead of all headings."),
        (("Care",), "Wipe it & dry it."),
        (("Care", "Every week"), "Pressure: 1.2 bar <cold>.\n\nGrease it."),
        (("Storage",), "Dry."),
    ]


@needs_pypdf
def test_a_pdf_has_its_text_by_page_and_the_headings_of_its_outline() -> None:
    document = read("care.pdf", pdf(PARTS, pages=3))
    (section,) = document.sections
    assert section.heading == ("Storage", "page 1")
    assert "Wipe it & dry it." in section.text and "Pressure: 1.2 bar <cold>." in section.text


def test_markdown_is_read_as_its_reader_sees_it() -> None:
    source = (
        b"---\nkey: value\n---\n# Use `it`\n\nA [link](http://x.y) and **bold**.\n\n| a | b |\n|---|---|\n| 1 | 2 |\n"
    )
    document = read("use.md", source + b"\n```\n# no heading\n```\n\nUnder\n-----\n- one\n- two\n")
    assert [(section.heading, section.text) for section in document.sections] == [
        (("Use it",), "A link and bold.\n\na | b\n\n1 | 2\n\n# no heading"),
        (("Use it", "Under"), "one\n\ntwo"),
    ]


@pytest.mark.parametrize("mark", ["> ", "- ", "1. ", "> - "])
def test_markdown_is_read_whole_or_refused_with_the_line_that_is_nested_too_deep(mark: str) -> None:
    for depth in range(1, 60):
        page = f"seen\n\n{mark * depth}here".encode()
        try:
            assert text(read("a.md", page)) == "seen\n\nhere"
        except ValueError:
            assert depth > 12 and "is nested more than 40 deep in line 3" in fault("a.md", page)
    assert fault("a.md", page)


def test_tables_keep_their_lines() -> None:
    table = "<table><tr><th>What</th><th>Value</th></tr><tr><td>Mass</td><td><p>6 kg</p></td></tr></table>"
    assert text(read("a.html", table.encode())) == "What | Value\n\nMass | 6 kg"
    cells = "".join(f"<w:tc><w:p><w:r><w:t>{each}</w:t></w:r></w:p></w:tc>" for each in ("Mass", "6 kg"))
    assert text(read("a.docx", docx([], f"<w:tbl><w:tr>{cells}</w:tr></w:tbl>"))) == "Mass | 6 kg"


HIDDEN = "HIDDENWORDS"
UNRENDERED = ("audio", "canvas", "datalist", "dialog", "noembed", "noframes", "rp", "video")
UNSEEN_BY_STYLE = (
    "style='display:/**/none'",
    "style='d\\69 splay:none'",
    "style='font-size:0.0px'",
    "style='opacity:.0'",
    "style='visibility:collapse'",
    "style='color: transparent'",
)


def run_of(written: str, settings: str = "") -> str:
    return f"<w:r><w:rPr>{settings}</w:rPr><w:t>{written}</w:t></w:r>"


def gone_from_a_table(setting: str) -> str:
    return f"<w:tbl><w:tr><w:trPr>{setting}</w:trPr><w:tc><w:p>{run_of(HIDDEN)}</w:p></w:tc></w:tr></w:tbl>"


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.html", f"<p>seen</p><script>{HIDDEN}</script><style>{HIDDEN}</style><!-- {HIDDEN} -->".encode()),
        ("a.html", f"<p>seen<span style='color: red; display : none'>{HIDDEN}<b>{HIDDEN}</b></span></p>".encode()),
        ("a.html", f"<p>seen</p><div hidden><p>{HIDDEN}</div><p aria-hidden='true'>{HIDDEN}".encode()),
        ("a.html", f"<p>seen<template>{HIDDEN}</template><span style='font-size:0'>{HIDDEN}</span>".encode()),
        ("a.md", f"seen <!-- {HIDDEN} -->\n\n<!-- {HIDDEN} -->\n\n[x]: http://{HIDDEN}.com\n".encode()),
        ("a.md", f"seen <span hidden>{HIDDEN}</span>".encode()),
        ("a.md", f"seen\n\n<div hidden>\n\n{HIDDEN}\n\n- {HIDDEN}\n\n</div>\n\n<b>here</b>".encode()),
        ("a.md", f"---\r\nkey: {HIDDEN}\r\n---\r\nseen\r\n".encode()),
        ("a.md", f"---\nkey: {HIDDEN}\n...\nseen\n".encode()),
        *(("a.html", f"<p>seen</p><{tag}><p>{HIDDEN}</p></{tag}>".encode()) for tag in UNRENDERED),
        *(("a.html", f"<p>seen</p><div {each}>{HIDDEN}</div>".encode()) for each in UNSEEN_BY_STYLE),
        ("a.html", f"<p>seen</p><div popover>{HIDDEN}</div><img hidden alt='{HIDDEN}'>".encode()),
        ("a.docx", docx([(0, "seen")], gone_from_a_table("<w:del/>"))),
        ("a.docx", docx([(0, "seen")], gone_from_a_table("<w:hidden/>"))),
        ("a.docx", docx([(0, "seen")], f"<w:p><w:r><w:rPr><w:vanish/></w:rPr><w:t>{HIDDEN}</w:t></w:r></w:p>")),
        ("a.docx", docx([(0, "seen")], f"<w:p><w:del><w:r><w:delText>{HIDDEN}</w:delText></w:r></w:del></w:p>")),
    ],
)
def test_what_no_person_sees_is_no_text(name: str, data: bytes) -> None:
    found = text(read(name, data))
    assert "seen" in found and HIDDEN not in found


HIDES = ["<!-- note", "<script>", "<title>", "<textarea>", "<![CDATA["]


@pytest.mark.parametrize(
    ("name", "opening"),
    [
        *(("a.html", each) for each in (*HIDES, "<div hidden>", "<select>", "<a href='x")),
        *(("a.md", each) for each in HIDES),
    ],
)
def test_what_would_hide_the_rest_of_a_page_is_refused_with_its_line(name: str, opening: str) -> None:
    data = f"<p>seen</p>\n\n{opening} <p>It never enters the kitchen.".encode()
    assert fault(name, data).startswith(f"never closes the {opening.split()[0].rstrip('>')}")
    assert " of line 3, which hides what follows; close it, or write &lt; for <" in fault(name, data)


def test_a_page_full_of_beginnings_is_refused_at_once() -> None:
    begun = time.process_time()
    for opening in (b"<!--", b"<a ", b"<![CDATA["):
        assert fault("a.html", b"<p>seen</p>" + opening * 100_000).startswith("never closes the <")
    assert time.process_time() - begun < 2


@pytest.mark.parametrize(
    ("page", "shown"),
    [
        ("<head><title>x</title><body><p>seen", "seen"),
        ("<p hidden>note<div>seen</div>", "seen"),
        ("<table>" + "<tr><td>a<td>b" * 600 + "</table>", "\n\n".join(["a | b"] * 600)),
        ("<ul>" + "<li><p>a" * 600 + "</ul>", "\n\n".join(["a"] * 600)),
        ("<ul><li>a<ul><li>b<li>c</ul><li>d</ul>", "a\n\nb\n\nc\n\nd"),
        ("<p>1 < 2 & 5 <7", "1 < 2 & 5 <7"),
        (f"<p>&#{'9' * 5000}; seen", "\N{REPLACEMENT CHARACTER} seen"),
    ],
)
def test_a_page_may_leave_out_the_end_tags_that_html_lets_it(page: str, shown: str) -> None:
    assert text(read("a.html", page.encode())) == shown


def alternatives(written: str) -> str:
    box = f"<w:txbxContent><w:p>{written}</w:p></w:txbxContent>"
    return (
        '<w:r><mc:AlternateContent xmlns:mc="http://schemas.openxmlformats.org/markup-compatibility/2006">'
        f"<mc:Choice>{box}</mc:Choice><mc:Fallback>{box}</mc:Fallback></mc:AlternateContent></w:r>"
    )


@pytest.mark.parametrize(
    ("body", "shown"),
    [
        *((run_of("a") + run_of("b", f'<w:vanish w:val="{off}"/>'), "ab") for off in ("off", "0", "false")),
        *((run_of("a") + run_of("b", f'<w:vanish w:val="{on}"/>'), "a") for on in ("on", "1", "true")),
        (run_of("a ") + alternatives(run_of("box")) + run_of("b"), "box\n\na b"),
        (run_of("a ") + alternatives(run_of("box")).replace("<w:r>", "<w:r><w:vanish/>", 1) + run_of("b"), "a b"),
        (alternatives(alternatives(run_of("box"))) + run_of("b"), "box\n\nb"),
        (f"<w:moveFrom>{run_of('a')}</w:moveFrom><w:moveTo>{run_of('a')}</w:moveTo>", "a"),
        (run_of("a", "<w:rPrChange><w:rPr><w:vanish/></w:rPr></w:rPrChange>"), "a"),
        ("<w:r><w:t>A</w:t><w:noBreakHyphen/><w:t>1</w:t></w:r>", "A-1"),
    ],
)
def test_a_word_document_is_read_once_and_as_it_is_now(body: str, shown: str) -> None:
    assert text(read("a.docx", docx([], f"<w:p>{body}</w:p>"))) == shown


def test_a_heading_keeps_its_level_around_a_text_box_and_after_a_change() -> None:
    heading = '<w:pPr><w:pStyle w:val="berschrift1"/></w:pPr>'
    changed = f"<w:pPr><w:pPrChange>{heading}</w:pPrChange></w:pPr>"
    body = f"<w:p>{heading}{alternatives(run_of('box'))}{run_of('Care')}</w:p><w:p>{changed}{run_of('wipe it')}</w:p>"
    sections = read("a.docx", docx([], body)).sections
    assert [(each.heading, each.text) for each in sections] == [((), "box"), (("Care",), "wipe it")]


@pytest.mark.parametrize("style", ['<w:name w:val="heading {}"/>', '<w:outlineLvl w:val="{}"/>'])
@pytest.mark.parametrize("level", ["9" * 5_000, "²", "-1"])
def test_a_level_that_is_none_makes_no_heading(style: str, level: str) -> None:
    styles = f'<w:style w:styleId="a">{style.format(level)}</w:style>'
    body = f'<w:p><w:pPr><w:pStyle w:val="a"/></w:pPr>{run_of("a")}</w:p>'
    parts = {"word/styles.xml": f'<w:styles xmlns:w="{W}">{styles}</w:styles>'}
    parts["word/document.xml"] = f'<w:document xmlns:w="{W}"><w:body>{body}</w:body></w:document>'
    assert read("a.docx", zipped(parts)).sections == (Section((), "a"),)


STYLES = (
    '<w:style w:styleId="note"><w:basedOn w:val="secret"/></w:style>'
    '<w:style w:styleId="secret"><w:basedOn w:val="note"/><w:rPr><w:vanish/></w:rPr></w:style>'
    '<w:style w:styleId="shown"><w:basedOn w:val="note"/><w:rPr><w:vanish w:val="0"/></w:rPr></w:style>'
    '<w:style w:styleId="title"><w:name w:val="heading 1"/></w:style>'
    '<w:style w:styleId="small"><w:basedOn w:val="title"/></w:style>'
    '<w:style w:styleId="plain"><w:basedOn w:val="small"/><w:outlineLvl w:val="9"/></w:style>'
)


@pytest.mark.parametrize(
    ("paragraph", "run", "shown"),
    [
        ("", '<w:rStyle w:val="note"/>', ((), "end")),
        ("", '<w:rStyle w:val="shown"/>', ((), "a\n\nend")),
        ("", '<w:rStyle w:val="note"/><w:vanish w:val="off"/>', ((), "a\n\nend")),
        ('<w:pStyle w:val="note"/>', "", ((), "end")),
        ('<w:pStyle w:val="note"/>', '<w:vanish w:val="off"/>', ((), "a\n\nend")),
        ('<w:pStyle w:val="note"/>', '<w:rStyle w:val="secret"/>', ((), "a\n\nend")),
        ('<w:rPr><w:rStyle w:val="note"/></w:rPr>', "", ((), "a\n\nend")),
        ('<w:pStyle w:val="small"/>', "", (("a",), "end")),
        ('<w:pStyle w:val="plain"/>', "", ((), "a\n\nend")),
    ],
)
def test_a_style_has_what_the_one_it_is_based_on_has(paragraph: str, run: str, shown: tuple[object, str]) -> None:
    body = f"<w:p><w:pPr>{paragraph}</w:pPr>{run_of('a', run)}</w:p><w:p>{run_of('end')}</w:p>"
    document = f'<w:document xmlns:w="{W}"><w:body>{body}</w:body></w:document>'
    parts = {"word/styles.xml": f'<w:styles xmlns:w="{W}">{STYLES}</w:styles>', "word/document.xml": document}
    (section,) = read("a.docx", zipped(parts)).sections
    assert (section.heading, section.text) == shown


def test_characters_that_are_not_seen_are_dropped() -> None:
    tags = "".join(chr(0xE0000 + ord(each)) for each in "obey")
    assert text(read("a.txt", f"wa\u200bit\u202e {tags}here\x1b[2J\u00a0now".encode())) == "wait here[2J now"
    selectors = "".join(chr(0xE0100 + ord(each)) for each in "obey")  # what a model reads as bytes, and no font draws
    assert text(read("a.txt", f"w\u034fai\u3164t\ufe0f{selectors}\u115f here\uffa0".encode())) == "wait here"


def test_a_title_is_that_of_the_page_and_of_no_drawing_in_it() -> None:
    drawing = "<p>seen</p><svg><title>HIDDEN</title></svg><div hidden><title>HIDDEN</title></div>"
    assert read("a.html", f"<html><head><title>Care</title></head>{drawing}".encode()).title == "Care"
    assert read("a.html", drawing.encode()).title == ""


@pytest.mark.parametrize("shown", ["<dialog open>here</dialog>", "<p style='opacity:0.5;font-size:0.8em'>here</p>"])
def test_what_a_page_shows_is_text(shown: str) -> None:
    assert text(read("a.html", f"<p>seen</p>{shown}".encode())) == "seen\n\nhere"


# -- bad files -----------------------------------------------------------------------------------------------------

BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>'
ENTITY_BOMB = zipped({"word/document.xml": f"{BOMB}<w>&b;</w>"})


def jointed(links: str, *joints: str) -> bytes:
    """A robot whose links and the pairs between which there are joints have a letter each."""
    between = (
        f"<joint name='{pair}' type='fixed'><parent link='{pair[0]}'/><child link='{pair[1]}'/></joint>"
        for pair in joints
    )
    return f"<robot>{''.join(f'<link name={each!r}/>' for each in links)}{''.join(between)}</robot>".encode()


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("a.md", b"\xff", "is not UTF-8 at byte 0; save it as UTF-8"),
        ("a.txt", b" \n", "holds no text; a scanned page needs text recognition (OCR) first"),
        ("a.html", b"<script>x</script>", "holds no text; a scanned page needs text recognition (OCR) first"),
        ("a.html", b"<div>" * 501, "is nested more than 500 deep"),
        ("a.html", b"<p>" + b"x y " * 600_000, "holds more than 2000000 characters of text; split it"),
        ("a.txt", b"a\n===\nb\n\n" * 5_002, "has more than 5000 sections; split it"),
        ("a.docx", b"PK\x03\x04", "is no readable .docx (File is not a zip file); open it and save it again as .docx"),
        (
            "a.docx",
            zipped({"x": ""}),
            "has no word/document.xml, so it is no .docx; open it and save it again as .docx",
        ),
        (
            "a.docx",
            zipped({str(at): "" for at in range(5_001)}),
            "is an archive of more than 5000 parts; save it again",
        ),
        (
            "a.docx",
            zipped({"word/document.xml": "x" * 40_000_001}),
            "unpacks to more than 40000000 bytes (word/document",
        ),
        ("a.docx", ENTITY_BOMB, "brings a document type (<!DOCTYPE …>), which it does not need; remove it"),
        ("a.docx", zipped({"word/document.xml": "<a>" * 300}), "is nested more than 200 deep"),
        pytest.param(
            "a.pdf",
            pdf([], pages=10_000),
            "has 10000 pages; at most 1000 are read: split it, or leave out what is not",
            marks=needs_pypdf,
        ),
        pytest.param("a.pdf", b"%PDF-1.7", "is a broken PDF (", marks=needs_pypdf),
        pytest.param(
            "a.pdf",
            pdf([(0, "")]),
            "holds no text; a scanned page needs text recognition (OCR) first",
            marks=needs_pypdf,
        ),
        (
            "a.urdf",
            b"<robot><link name='a'><inertial>\n<mass value='x'/>",
            "the mass in line 2 is 'x', which is no number",
        ),
        ("a.urdf", b"<robot><link name='a'><inertial><mass value='-1'/>", "has a negative mass in line 1: -1.0"),
        (
            "a.urdf",
            b"<robot><link name='a'><inertial><mass value='1.7e308'/>",
            "the mass in line 1 is '1.7e308'; at most 1e+100 is read",
        ),
        (
            "a.urdf",
            b"<robot><joint name='a'><limit upper='-1e300'/>",
            "the limit 'upper' in line 1 is '-1e300'; at most 1e+100 is read",
        ),
        (
            "a.urdf",
            b"<robot><link name='a'><collision><geometry><box size='1 -1 2'/>",
            "has a box of negative size in line 1: 1.0, -1.0, 2.0",
        ),
        ("a.urdf", b"<robot><joint name='a'><axis xyz='1 0'/>", "the axis in line 1 is '1 0'; it is 3 numbers"),
        (
            "a.urdf",
            b"<robot><link name='base'/><joint name='j'><parent link='base'/><child link='bace'/></joint></robot>",
            "the child of the joint 'j' is 'bace', which is no link; did you mean 'base'?",
        ),
        (
            "a.urdf",
            b"<robot><link name='base'/><joint name='j'><parent link='base'/></joint></robot>",
            "the joint 'j' lacks its child; write <child link=",
        ),
        ("a.urdf", b"<robot><link name='a'/><link name='a'/></robot>", "has two links called 'a'; rename one"),
        (
            "a.urdf",
            b"<robot><link name='a'/><link name='b'/><joint name='j'><parent link='a'/><child link='b'/>"
            b"<limit lower='2' upper='-2'/></joint></robot>",
            "the limits of the joint 'j' are 2 to -2; exchange them",
        ),
        (
            "a.urdf",
            b"<robot><link name='a'/><link name='b'/><joint name='j' type='hinge'><parent link='a'/><child link='b'/>"
            b"</joint></robot>",
            "the joint 'j' is of the type 'hinge'; there is: continuous, fixed, floating, planar, prismatic, revolute",
        ),
        ("a.urdf", jointed("ab", "ab", "ba"), "its joints are a circle: b, a, b; remove one of them"),
        ("a.urdf", jointed("ab", "ab", "bb"), "the link 'b' is the child of 2 joints; leave it one"),
        ("a.urdf", jointed("a", "aa"), "its joints are a circle: a, a; remove one of them"),
        ("a.urdf", jointed("abc", "ac"), "has 2 links without a parent: a, b; connect them by joints"),
        (
            "a.urdf",
            b"<robot name='a' xmlns:xacro='x'><xacro:include filename='b.xacro'/></robot>",
            "has no link; a xacro file is expanded first: xacro FILE -o robot.urdf",
        ),
        ("a.urdf", b"<robot><joint name='a'><limit lower='nan'/>", "the limit 'lower' in line 1 is 'nan', which is no"),
    ],
)
def test_a_bad_file_is_refused_with_its_remedy(name: str, data: bytes, sentence: str) -> None:
    assert fault(name, data).startswith(sentence)


@needs_pypdf
def test_a_pdf_that_is_encrypted_is_refused() -> None:
    import io

    from pypdf import PdfReader, PdfWriter

    writer, made = PdfWriter(clone_from=PdfReader(io.BytesIO(pdf(PARTS)))), io.BytesIO()
    writer.encrypt("secret", algorithm="RC4-128")
    writer.write(made)
    assert fault("a.pdf", made.getvalue()) == "is encrypted; save a copy of it without a password"


def test_a_zip_bomb_is_unpacked_up_to_the_bound_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    bomb = zipped({"word/document.xml": " " * 20_000_000})
    monkeypatch.setattr("rai_missions.embodiment.readers.docx.LARGEST_PART", 100_000)
    tracemalloc.start()
    try:
        assert fault("a.docx", bomb).startswith("unpacks to more than 100000 bytes")
        assert tracemalloc.get_traced_memory()[1] < 5_000_000
    finally:
        tracemalloc.stop()


SEEDS = {ending: write(PARTS) for ending, write in WRITERS.items()}


def damaged() -> Iterator[st.SearchStrategy[tuple[str, bytes]]]:
    for ending, seed in SEEDS.items():
        cut = st.tuples(st.integers(0, len(seed)), st.integers(0, len(seed)), st.binary(max_size=20))
        yield cut.map(
            lambda found, seed=seed, ending=ending: (f"a{ending}", seed[: found[0]] + found[2] + seed[found[1] :])
        )


@given(st.one_of(*damaged()) | st.tuples(st.sampled_from([f"a{each}" for each in FORMATS]), st.binary(max_size=200)))
def test_any_bytes_are_a_document_or_refused(given_file: tuple[str, bytes]) -> None:
    try:
        document = read(*given_file)
    except ValueError:
        return
    assert document.sections and all(section.text.strip() for section in document.sections)


# -- the process that reads ----------------------------------------------------------------------------------------


def test_a_file_that_hangs_or_ends_its_reader_costs_that_file_alone() -> None:
    with ReadingProcess(longest_s=1.5) as process:
        began = time.monotonic()
        with pytest.raises(ValueError, match=r"took longer than 1.5 s to read; split it, or save it again"):
            process.read("a.html", b"<b>" * 490 + b"</i>" * 400_000)  # each end is sought among all that is open
        assert time.monotonic() - began < 10
        assert process.read("a.md", markdown(PARTS)) == read("a.md", markdown(PARTS))
        with pytest.raises(ValueError, match="is nested more than 500 deep"):
            process.read("b.html", b"<div>" * 600)
        assert process.read("c.html", html_page(PARTS)) == read("c.html", html_page(PARTS))


# -- passages ------------------------------------------------------------------------------------------------------


@given(
    st.lists(st.text("ab .", min_size=1, max_size=60) | st.integers(1, 4000).map(lambda count: "x" * count), min_size=1)
)
def test_passages_are_short_and_lose_no_word(paragraphs: list[str]) -> None:
    try:
        document = read("a.txt", "\n\n".join(paragraphs).encode())
    except ValueError:
        return
    passages = list(passages_of("a.txt", document))
    assert all(len(each.text) <= LONGEST_SENTENCE + 1 for each in passages)
    assert "".join("".join(each.text for each in passages).split()) == "".join(text(document).split())
