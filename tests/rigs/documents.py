# SPDX-License-Identifier: Apache-2.0
"""Writes small documents of each format, as office programs do, for tests that read them."""

from __future__ import annotations

import html
import io
import zipfile
from collections.abc import Sequence
from xml.sax.saxutils import escape

__all__ = ("WRITERS", "Part", "docx", "html_page", "markdown", "pdf", "plain", "urdf")

W = "http://schemas.openxmlformats.org/wordprocessingml/2006/main"
Part = tuple[int, str]
"""A level and a text: 1 to 6 a heading, 0 a paragraph."""


def plain(parts: Sequence[Part]) -> bytes:
    lines = [f"{text}\n{'=-~'[level - 1] * max(3, len(text))}\n" if level else f"{text}\n" for level, text in parts]
    return "\n".join(lines).encode()


def markdown(parts: Sequence[Part]) -> bytes:
    return "\n\n".join(f"{'#' * level} {text}" if level else text for level, text in parts).encode()


def html_page(parts: Sequence[Part]) -> bytes:
    tags = [(f"h{level}" if level else "p", html.escape(text)) for level, text in parts]
    body = "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags)
    return f"<!DOCTYPE html><html><head><title>A page</title></head><body>{body}</body></html>".encode()


def docx(parts: Sequence[Part], extra: str = "") -> bytes:
    paragraphs = "".join(
        f'<w:p>{f"""<w:pPr><w:pStyle w:val="berschrift{level}"/></w:pPr>""" if level else ""}'
        f'<w:r><w:t xml:space="preserve">{escape(text)}</w:t></w:r></w:p>'
        for level, text in parts
    )
    styles = "".join(
        f'<w:style w:type="paragraph" w:styleId="berschrift{level}"><w:name w:val="heading {level}"/></w:style>'
        for level in range(1, 7)
    )
    return zipped({
        "[Content_Types].xml": "<Types/>",
        "word/styles.xml": f'<w:styles xmlns:w="{W}">{styles}</w:styles>',
        "word/document.xml": f'<w:document xmlns:w="{W}"><w:body>{paragraphs}{extra}</w:body></w:document>',
    })  # fmt: skip


def zipped(parts: dict[str, str]) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in parts.items():
            archive.writestr(name, text)
    return made.getvalue()


def pdf(parts: Sequence[Part], pages: int = 1) -> bytes:
    """A PDF in one of its built-in fonts: the text on the first page, the others empty; headings are its outline."""
    lines = [line for _, text in parts for line in (*_wrapped(text), "")]
    shown = "".join(f"({_literal(line)}) Tj T*\n" for line in lines)
    content = f"BT /F1 8 Tf 9 TL 40 800 Td\n{shown}ET".encode("latin-1", "replace")
    heads = [text for level, text in parts if level]
    first_page, outlines = 4, 4 + pages
    kids = " ".join(f"{first_page + at} 0 R" for at in range(pages))
    objects = [
        f"<< /Type /Catalog /Pages 2 0 R /Outlines {outlines} 0 R >>".encode(),
        f"<< /Type /Pages /Count {pages} /Kids [{kids}] >>".encode(),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ]
    last = outlines + 1 + len(heads)
    for at in range(pages):
        contents = f"/Contents {last} 0 R" if at == 0 else ""
        place = "/Parent 2 0 R /MediaBox [0 0 595 842] /Resources << /Font << /F1 3 0 R >> >>"
        objects.append(f"<< /Type /Page {place} {contents} >>".encode())
    ends = f"/First {outlines + 1} 0 R /Last {outlines + len(heads)} 0 R /Count {len(heads)}" if heads else ""
    objects.append(f"<< /Type /Outlines {ends} >>".encode())
    for at, head in enumerate(heads):
        follows = f"/Next {outlines + 2 + at} 0 R" if at + 1 < len(heads) else ""
        objects.append(
            f"<< /Title ({_literal(head)}) /Parent {outlines} 0 R /Dest [{first_page} 0 R /Fit] {follows} >>".encode(
                "latin-1", "replace"
            )
        )
    objects.append(f"<< /Length {len(content)} >>\nstream\n".encode() + content + b"\nendstream")
    return _file(objects)


def _file(objects: Sequence[bytes]) -> bytes:
    made, places = bytearray(b"%PDF-1.7\n"), []
    for number, each in enumerate(objects, start=1):
        places.append(len(made))
        made += f"{number} 0 obj\n".encode() + each + b"\nendobj\n"
    start = len(made)
    made += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n".encode()
    made += b"".join(f"{place:010d} 00000 n \n".encode() for place in places)
    made += f"trailer << /Size {len(objects) + 1} /Root 1 0 R >>\nstartxref\n{start}\n%%EOF\n".encode()
    return bytes(made)


def _wrapped(text: str) -> list[str]:
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) > 100:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def _literal(text: str) -> str:
    return text.replace("\\", "\\\\").replace("(", "\\(").replace(")", "\\)")


def urdf(names: Sequence[str], robot: str = "r") -> bytes:
    """A robot whose links have these names, all of them fixed to the first."""
    links = "".join(f"<link name={_quoted(name)}><inertial><mass value='1'/></inertial></link>" for name in names)
    joints = "".join(
        f"<joint name='j{number}' type='fixed'><parent link={_quoted(names[0])}/><child link={_quoted(name)}/></joint>"
        for number, name in enumerate(names[1:])
    )
    return f"<robot name={_quoted(robot)}>{links}{joints}</robot>".encode()


def _quoted(text: str) -> str:
    return '"' + escape(text, {'"': "&quot;"}) + '"'


WRITERS = {".docx": docx, ".html": html_page, ".md": markdown, ".pdf": pdf, ".txt": plain}
"""Ending → what writes such a document."""
