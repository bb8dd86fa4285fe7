# SPDX-License-Identifier: Apache-2.0
"""An identity is read from its folder alone; what is wrong in it is reported at once, each with its file."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as Pillow

from rai_missions.embodiment import Body, Identity
from rai_missions.embodiment.urdf import BodyLink, read_body
from rai_missions.errors import DefinitionError
from rai_missions.image import Image

URDF = b"""<?xml version="1.0"?>
<robot name="arm"><link name="base"/><link name="rail"/><link name="hand"><visual><origin xyz="0 0 0"/></visual></link>
<joint name="wrist" type="revolute"><parent link="base"/><child link="hand"/></joint>
<joint name="mount" type="fixed"><parent link="rail"/><child link="base"/></joint>
<gazebo><link name="not_ours"/></gazebo></robot>"""


def picture(kind: str, size: tuple[int, int] = (7, 5)) -> bytes:
    made = io.BytesIO()
    Pillow.new("RGB", size, (10, 120, 30)).save(made, kind)
    return made.getvalue()


def folder(path: Path, files: dict[str, bytes]) -> Path:
    for name, data in {"description.md": b"A tractor.\n", **files}.items():
        (path / name).write_bytes(data)
    return path


def faults(path: Path) -> list[str]:
    with pytest.raises(DefinitionError) as caught:
        Identity.read(path)
    assert caught.value.source == str(path)
    return [str(fault) for fault in caught.value.faults]


# ── What is read ────────────────────────────────────────────────────────────────────────────────────────────────


def test_an_identity_is_a_description_pictures_a_build_and_documents(tmp_path: Path) -> None:
    files = {
        "a.png": picture("png"),
        "portrait.jpg": picture("jpeg"),
        "arm.urdf": URDF,
        "manual.md": b"\xef\xbb\xbfMind the crane.",
    }
    identity = Identity.read(folder(tmp_path, {**files, "notes.txt": b"\xff"}))
    assert identity.description == "A tractor.\n"
    assert [(image.ref, image.encoding, image.width, image.height) for image in identity.images] == [
        ("identity/portrait.jpg", "jpeg", 7, 5),
        ("identity/a.png", "png", 7, 5),
    ]
    assert identity.portrait == identity.images[0]
    assert identity.body is not None and identity.body.name == "arm"
    assert [link.name for link in identity.body.links] == ["base", "rail", "hand"]
    assert [(joint.name, joint.kind) for joint in identity.body.joints] == [("wrist", "revolute"), ("mount", "fixed")]
    assert identity.words() == "A tractor.\n\nBuild of 'arm'. Links: base, rail, hand. Moving joints: wrist (revolute)."


def test_a_description_is_enough(tmp_path: Path) -> None:
    identity = Identity.read(folder(tmp_path, {}))
    assert (identity.portrait, identity.body, identity.words()) == (None, None, "A tractor.")


@pytest.mark.parametrize(
    ("description", "sentence"),
    [
        ("# Who I am\n\nI am a tractor. I work alone.\n", "I am a tractor."), ("I am\na tractor\n", "I am a tractor."),
        ("# Only a heading\n", ""), ("", ""),
    ],
)  # fmt: skip
def test_its_first_sentence_has_no_heading(description: str, sentence: str) -> None:
    assert Identity(description).first_sentence == sentence


@given(st.integers(1, 300), st.integers(1, 300), st.sampled_from(["png", "jpeg"]))
def test_a_pictures_size_is_read_from_its_bytes(width: int, height: int, kind: str) -> None:
    image = Image.of_file("x", picture(kind, (width, height)))
    assert (image.width, image.height, image.encoding) == (width, height, kind)


def test_a_long_build_is_reported_in_short() -> None:
    body = Body("snake", tuple(BodyLink(f"l{number}") for number in range(50)), ())
    assert body.words().endswith("l39, and 10 more. Moving joints: none.")


# ── Bad input ───────────────────────────────────────────────────────────────────────────────────────────────────


@given(st.binary() | st.binary().map(picture("png")[:16].__add__) | st.binary().map(picture("jpeg")[:20].__add__))
def test_any_bytes_are_a_picture_or_refused(data: bytes) -> None:
    try:
        image = Image.of_file("x", data)
    except ValueError:
        return
    assert min(image.width, image.height) >= 1


@given(st.binary() | st.text().map(str.encode) | st.integers(0, len(URDF)).map(lambda end: URDF[:end]))
def test_any_bytes_are_a_build_or_refused(data: bytes) -> None:
    try:
        body = read_body("x", data)
    except ValueError:
        return
    assert isinstance(body, Body)


BOMB = b'<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><robot name="&b;"/>'
OUTSIDE = b'<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot name="x">&a;</robot>'


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("description.md", b"\xff\xfe", "is not UTF-8 at byte 0; save it as UTF-8"),
        ("description.md", b" \n", "is empty; write in it who the robot is"),
        ("description.md", b"x" * 200_001, "is larger than 200000 bytes; move what is not the description elsewhere"),
        ("a.png", b"GIF89a", "is neither a PNG nor a JPEG file"),
        ("a.png", picture("png")[:20], "is a broken PNG file: it does not report its size"),
        ("a.JPG", picture("jpeg")[:10], "is a broken JPEG file: it does not report its size"),
        ("a.urdf", b"<robot>", "is not well-formed XML: no element found: line 1, column 7"),
        ("a.urdf", b"<sdf/>", "is no URDF: it begins with <sdf> instead of <robot>"),
        ("a.urdf", BOMB, "brings a document type (<!DOCTYPE …>), which it does not need; remove it"),
        ("a.urdf", OUTSIDE, "brings a document type (<!DOCTYPE …>), which it does not need; remove it"),
        ("a.urdf", b"<robot>" + b"<a>" * 200, "is nested more than 100 deep"),
        ("a.urdf", b"<robot>" + b"<link/>" * 2001, "has more than 2000 links or joints"),
        ("a.urdf", b'<?xml version="1.0" encoding="x-none"?><robot/>', "is not well-formed XML: unknown encoding"),
    ],
)
def test_a_bad_file_is_reported_with_its_name(tmp_path: Path, name: str, data: bytes, sentence: str) -> None:
    (fault,) = faults(folder(tmp_path, {name: data}))
    assert fault.startswith(f"/{name}: {sentence}")


def test_every_fault_is_reported_at_once(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"")
    (tmp_path / "a.urdf").write_bytes(URDF)
    (tmp_path / "b.urdf").write_bytes(URDF)
    assert faults(tmp_path) == [
        "/a.png: is neither a PNG nor a JPEG file",
        "/: a.urdf and b.urdf both describe the build; keep one",
        "/description.md: is missing; write in it who the robot is",
    ]


def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    inside = tmp_path / "identity"
    inside.mkdir()
    (tmp_path / "secret.md").write_text("the key")
    (inside / "description.md").symlink_to(tmp_path / "secret.md")
    assert faults(inside) == ["/description.md: leads out of the identity's folder; copy the file into it"]


def test_a_link_within_the_folder_is_followed(tmp_path: Path) -> None:
    (tmp_path / "me.md").write_text("A tractor.")
    (tmp_path / "description.md").symlink_to("me.md")
    assert Identity.read(tmp_path).description == "A tractor."


def test_what_is_no_file_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(folder(tmp_path, {}) / "pipe.png")
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "loop.png").symlink_to("loop.png")
    assert faults(tmp_path) == [
        "/folder.png: is a folder, no file",
        "/loop.png: is no file",
        "/pipe.png: is a named pipe (FIFO), no file",
    ]


@pytest.mark.parametrize("make", [lambda path: path / "none", lambda path: folder(path, {}) / "description.md"])
def test_what_is_no_folder_is_reported(tmp_path: Path, make: Any) -> None:
    (fault,) = faults(make(tmp_path))
    assert fault.startswith("/: the identity's folder cannot be read (")
    assert fault.endswith("; it is one with a description.md")


def test_a_folder_of_very_many_files_is_refused(tmp_path: Path) -> None:
    assert faults(folder(tmp_path, {f"{number}.md": b"" for number in range(200)})) == [
        "/: has 201 files; at most 200 are read"
    ]
