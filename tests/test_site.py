# SPDX-License-Identifier: Apache-2.0
"""The site of the documents: its links keep their meaning, it has every definition, and it fetches nothing."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def pages() -> Any:
    pytest.importorskip("mkdocs", reason="MkDocs comes with `make docs`")
    sys.path.insert(0, str(ROOT / "scripts"))
    try:
        import site_pages
    finally:
        sys.path.remove(str(ROOT / "scripts"))
    return site_pages


@pytest.mark.parametrize("name", ["mission", "robot", "campaign"])
def test_a_schema_s_page_has_every_definition_and_its_links_lead_to_them(pages: Any, name: str) -> None:
    text = pages.schema_page(name)
    anchors = re.findall(r"\{#([a-z0-9-]+)\}", text)
    assert len(anchors) == len(set(anchors)) > 5
    assert set(re.findall(r"\]\(#([^)]+)\)", text)) <= set(anchors)


def test_the_reference_has_each_package_and_nothing_private(pages: Any) -> None:
    found = pages.packages()
    assert {"rai_missions", "rai_missions.engine", "rai_missions.states", "visualize", "visualize.live"} <= set(found)
    assert not [module for modules in found.values() for module in modules if "._" in module]


def test_no_file_takes_the_place_of_a_page() -> None:
    pages = {path.with_suffix(".html") for path in (ROOT / "docs").rglob("*.md")}
    assert [path for path in sorted(pages) if path.exists()] == []


def test_a_folder_of_documents_that_a_page_leads_to_has_a_first_page(pages: Any) -> None:
    sources = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    leads = {
        target for path in sources for target in pages.targets(path.read_text("utf-8"), str(path.relative_to(ROOT)))
    }
    folders = {lead for lead in leads if lead.startswith("docs/") and (ROOT / lead).is_dir()}
    assert [lead for lead in sorted(folders) if not (ROOT / lead / "README.md").is_file()] == []


@pytest.mark.drill
def test_the_site_is_built_without_a_warning_and_fetches_nothing(pages: Any, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(tmp_path / "site")]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    fetched = re.compile(
        r"<(?:script|img|iframe)[^>]*\ssrc=[\"']?(https?:)?//|<link[^>]*stylesheet[^>]*href=[\"']?(https?:)?//"
    )
    found = [path for path in (tmp_path / "site").rglob("*.html") if fetched.search(path.read_text("utf-8"))]
    assert found == []
    assert (tmp_path / "site/search/search_index.json").stat().st_size > 10**5
