# SPDX-License-Identifier: Apache-2.0
"""An identity's documents are data: nothing is fetched, started or read that they name, and nothing is left over."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.embodiment import Library
from rai_missions.embodiment.chunks import passages_of
from rai_missions.embodiment.index import build_index
from rai_missions.embodiment.reading_process import ReadingProcess
from rai_missions.redaction import Redaction
from tests.rigs.documents import docx, markdown, pdf
from tests.security.test_data import ROOT, SECRET, Place
from tests.security.test_secrets_in_pieces import LETTERS, assert_whole

LINKS = "http://127.0.0.1:9/x file:///etc/passwd ../outside/description.md"
OUTWARD = {
    "a.html": (
        b"<base href='http://127.0.0.1:9/'><link rel=stylesheet href=x.css><script src=/x.js></script><p>seen"
        b"<img src='file:///etc/passwd'><iframe src='../outside/description.md'></iframe>"
        b"<object data='/etc/passwd'></object><meta http-equiv=refresh content='0;url=http://127.0.0.1:9'>"
    ),
    "b.md": f"# seen\n\n![x](../outside/description.md) [y](file:///etc/passwd)\n\n{LINKS}\n".encode(),
    "c.docx": docx([(0, "seen")], '<w:p><w:hyperlink r:id="x" xmlns:r="y"/><w:altChunk r:id="z" xmlns:r="y"/></w:p>'),
    "d.pdf": pdf([(0, "seen")]).replace(b"/Type /Catalog", b"/OpenAction << /S /Launch /F (/bin/sh) >> /Type /Catalog"),
    "e.urdf": b"<robot name='seen'><link name='a'><visual><geometry><mesh filename='file:///etc/passwd'/></geometry>"
    b"</visual></link></robot>",
}
READS = """
import json, sys
from pathlib import Path
from rai_missions.embodiment.readers import read_document
from tests.security import watched
for each in ("a.md", "a.html", "a.txt"): read_document(each, b"loaded")
__import__("pypdf")
sys.addaudithook(watched.audit)
texts = {}
for path in sorted(Path(sys.argv[1]).iterdir()):
    data = path.read_bytes()
    count = len(watched.EVENTS)
    texts[path.name] = str(read_document(path.name, data))
    del watched.EVENTS[count - 1:count]  # the test's own
print(json.dumps([texts, watched.EVENTS]))
"""


def test_nothing_that_a_document_names_is_opened_started_or_fetched(tmp_path: Path) -> None:
    pytest.importorskip("pypdf", reason="pypdf is not installed: the extra `identity`")
    for name, data in OUTWARD.items():
        (tmp_path / name).write_bytes(data)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", READS, str(tmp_path)],
        capture_output=True,
        text=True,
        env=environment,
        check=True,
        timeout=120,
    )
    texts, events = json.loads(done.stdout.splitlines()[-1])
    assert all("seen" in text and "root:" not in text for text in texts.values()) and len(texts) == 5
    own = (sys.prefix, sys.base_prefix, str(ROOT / "rai_missions"), str(ROOT), str(tmp_path), "/usr/lib")
    assert [(kind, what) for kind, what in events if kind in ("reach", "start", "write")] == []
    assert [what for kind, what in events if kind == "read" and not what.startswith(own)] == []


def test_whoami_reads_its_folder_and_starts_its_reader_alone(tmp_path: Path) -> None:
    place = Place(tmp_path)
    home = place.given / "identity"
    home.mkdir()
    (home / "description.md").write_text("I am a robot.")
    (home / "manual.md").write_bytes(markdown([(1, "Tyres"), (0, "The tyres take 1.2 bar.")]))
    (home / "link.md").symlink_to(place.outside / "description.md")
    (home / "up").symlink_to(place.outside)
    for module in ("onnxruntime", "markdown_it", "numpy", "rai_missions"):  # what an unwary program imports
        (place.given / f"{module}.py").write_text("raise SystemExit(9)")
    index = str(place.out / "x.index")
    done = place.watch(
        ["whoami", "build", str(home), "--index", index],
        ["whoami", "ask", str(home), "Which tyres?", "--index", index],
    )
    assert done.ended == [2, 0], "the link is a fault, and the question has an answer all the same"
    assert not done.of("reach")
    assert all("rai_missions.embodiment.reading_process" in each for each in done.of("start"))
    assert not [each for each in done.of("read") if each.startswith(os.path.realpath(place.outside))]
    assert {each for each in done.of("write") if not each.startswith((os.path.realpath(place.out), "/dev/"))} == set()
    assert SECRET.encode() not in Path(index).read_bytes() and os.listdir(place.out) == ["x.index"]


MARKS = ("*a*", "`a`", "<b>", "&amp;", "\\_", "[a](b)", "<!--a-->", "~a~", "__a__", "![", "&", "\\", "=", "a b")
"""What a reader of Markdown or HTML may leave out, or read as a command."""
PLAIN = st.text(LETTERS, min_size=8, max_size=20)
MARKED = st.builds("{}{}{}".format, PLAIN, st.lists(st.sampled_from(MARKS), min_size=1, max_size=4).map("".join), PLAIN)
FRAMES = st.sampled_from(
    ["The word is {} today.", "# {}\n\nSo it is.", "- {}", "> a *{}*", "a|b\n-|-\n{}|c", "<p>{}</p>"]
)


@pytest.fixture(scope="module")
def reader() -> Iterator[ReadingProcess]:
    with ReadingProcess() as process:
        yield process


@given(secret=MARKED, frame=FRAMES, name=st.sampled_from(["a.md", "a.html", "a.txt"]))
def test_no_piece_of_a_secret_is_left_where_a_reader_leaves_out_marks_of_it(
    reader: ReadingProcess, secret: str, frame: str, name: str
) -> None:
    redaction = Redaction([secret])
    document = reader.read(name, frame.replace("{}", secret).encode())
    left = document.title, *(redaction.text(str(each)) for each in passages_of(name, document))
    assert_whole({str(number): each for number, each in enumerate(left)}, secret)


@settings(max_examples=4)
@given(secret=MARKED, frame=FRAMES, name=st.sampled_from(["a.md", "a.html"]))
def test_an_index_that_was_built_where_a_secret_was_unknown_has_no_piece_of_it_where_it_is_known(
    tmp_path_factory: pytest.TempPathFactory, secret: str, frame: str, name: str
) -> None:
    folder = tmp_path_factory.mktemp("identity")
    (folder / name).write_text(frame.replace("{}", secret))
    index = folder / "x.index"
    build_index(folder, index, None)
    redaction = Redaction([secret])
    library = Library(folder, index)
    left = {f"{number}": str(each) for number, each in enumerate(library.passages())}
    assert redaction and left
    assert_whole(left, secret)
