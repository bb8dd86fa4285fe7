# SPDX-License-Identifier: Apache-2.0
"""The site of the documents, beyond the files of `docs/`: the start, the reference, the schemas, what links lead to.

MkDocs loads this as a hook (`mkdocs.yml`, `make docs`). Links keep the meaning that they have in the repository: one
that leads out of `docs/` leads to a copy of that file.
"""

from __future__ import annotations

import ast
import json
import posixpath
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from rai_missions.campaign.file import campaign_schema

ROOT = Path(__file__).parent.parent
PARTS = re.compile(
    r"(?P<code>^```.*?^```$|`[^`\n]+`)|\]\((?P<path>[^)#:\s]+)(?P<rest>[^)]*)\)", re.DOTALL | re.MULTILINE
)
COPIES = "files"
"""The folder of the site for files of the repository outside `docs/`."""
PAGES = {"README.md": "index.md", "CHANGELOG.md": "changelog.md"}
"""File of the repository → its place in the site."""
SCHEMAS = ("mission", "robot", "campaign")
SECTIONS = {
    "Tutorial": "tutorial/**/*.md", "Guides": "guide/*.md", "Coming from": "coming-from/*.md",
    "Notebooks": "notebooks/*.md", "Campaigns": "campaigns/*.md",
}  # fmt: skip
INSIDE = ("paper.md", "architecture.md", "guarantees.md", "performance.md", "security.md")


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Makes the navigation from what is there."""
    docs = ROOT / "docs"
    pages = {
        name: sorted(docs.glob(pattern), key=lambda path: (path.parent, path)) for name, pattern in SECTIONS.items()
    }
    found = {name: [_uri(path, docs) for path in paths] for name, paths in pages.items()}
    config.nav = [
        {"Start": "index.md"},
        *({name: paths} for name, paths in found.items() if paths),
        {"Reference": [{name: f"reference/{name}.md"} for name in packages()]},
        {"Schemas": [{f"{name.capitalize()} file": f"schemas/{name}.md"} for name in SCHEMAS]},
        {"Inside": [*INSIDE, "decisions/README.md", "testing/README.md"]},
        {"Changelog": "changelog.md"},
    ]
    return config


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Adds the pages that are made, and copies of what links lead to."""
    made = {place: (ROOT / source).read_text("utf-8") for source, place in PAGES.items()}
    made |= {f"reference/{name}.md": reference(name, modules) for name, modules in packages().items()}
    made |= {f"schemas/{name}.md": schema_page(name) for name in SCHEMAS}
    for place, text in made.items():
        files.append(File.generated(config, place, content=text))
    waiting = [(_source(file.src_uri), file.content_string) for file in files.documentation_pages()]
    while waiting:
        source, text = waiting.pop()
        for target in targets(text, source):
            place = _place(target)
            if place.startswith(COPIES) and (ROOT / target).is_file() and files.get_file_from_path(place) is None:
                content = (ROOT / target).read_bytes()
                files.append(File.generated(config, place, content=content))
                if target.endswith(".md"):
                    waiting.append((target, content.decode("utf-8")))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Leads links of the repository to the site's pages; a link to a folder of code becomes its name alone."""
    source, here = _source(page.file.src_uri), posixpath.dirname(page.file.src_uri)

    def moved(found: re.Match[str]) -> str:
        if found["code"]:
            return found[0]
        place = _place(_resolved(found["path"], source))
        if files.get_file_from_path(place) is None:
            return found[0]
        return f"]({posixpath.relpath(place, here or '.')}{found['rest']})"

    return PARTS.sub(moved, markdown)


# -- places -----------------------------------------------------------------------------------------------------------


def _source(place: str) -> str:
    """The file of the repository from which a page of the site comes; the links in it are relative to that."""
    named = {page: source for source, page in PAGES.items()}
    return named.get(place) or (place.removeprefix(f"{COPIES}/") if place.startswith(f"{COPIES}/") else f"docs/{place}")


def _place(source: str) -> str:
    """Where a file of the repository is in the site; a folder is at its first page."""
    path = ROOT / source
    if path.is_dir():
        source = f"{source}/README.md" if (path / "README.md").is_file() else f"{source}/index.md"
    if source in PAGES:
        return PAGES[source]
    return source.removeprefix("docs/") if source.startswith("docs/") else f"{COPIES}/{source}"


def targets(text: str, source: str) -> Iterator[str]:
    for found in PARTS.finditer(text):
        if found["path"]:
            yield _resolved(found["path"], source)


def _resolved(path: str, source: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(source), path))


def _uri(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()


# -- made pages -------------------------------------------------------------------------------------------------------


def packages() -> dict[str, list[str]]:
    """Package → its modules that offer something in `__all__`; nothing is imported."""
    found: dict[str, list[str]] = {}
    for home in ("rai_missions", "visualize"):
        for path in sorted((ROOT / home).rglob("*.py")):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
            if _offers(path) and "._" not in module and "__main__" not in module:
                inner = module.split(".")
                found.setdefault(".".join(inner[:2]) if _is_package(inner) else home, []).append(module)
    return found


def _is_package(names: list[str]) -> bool:
    return len(names) > 1 and (ROOT / names[0] / names[1]).is_dir()


def _offers(path: Path) -> bool:
    body = ast.parse(path.read_text("utf-8")).body
    return any(isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__" for node in body)


def reference(package: str, modules: list[str]) -> str:
    """The page of a package: its modules one after the other."""
    return "\n\n".join((f"# {package}", *(f"::: {module}" for module in modules)))


def schema_page(name: str) -> str:
    """A JSON Schema as tables: a heading for each definition, a line for each word that it has."""
    path = ROOT / f"rai_missions/{name}.schema.json"
    made = f"Made from [`{path.name}`](../../{path.relative_to(ROOT).as_posix()}), which editors read."
    if path.is_file():
        schema = json.loads(path.read_text("utf-8"))
    else:
        schema, made = campaign_schema(), "`rai-missions schema campaign` prints it, for editors to read."
    lines = [f"# The {name} file", "", made, ""]
    for title, each in ((name, schema), *schema.get("$defs", {}).items()):
        lines += [f"## {title} {{#{_anchor(title)}}}", "", *_definition(each)]
    return "\n".join(lines)


def _definition(schema: Mapping[str, Any]) -> Iterator[str]:
    if text := schema.get("description"):
        yield from (text, "")
    words = schema.get("properties") or {}
    if words:
        needed = schema.get("required", ())
        yield from ("| word | value | meaning |", "|---|---|---|")
        for word, each in words.items():
            star = " (needed)" if word in needed else ""
            yield f"| `{word}`{star} | {_value(each)} | {_cell(each.get('description', ''))} |"
    else:
        yield f"Value: {_value(schema)}"
    yield ""


def _value(schema: Any) -> str:
    """What may be written, in words, with links to definitions."""
    if not isinstance(schema, dict) or not schema:
        return "anything"
    if reference := schema.get("$ref"):
        title = reference.rpartition("/")[2]
        return f"[{title}](#{_anchor(title)})"
    for word in ("anyOf", "oneOf"):
        if word in schema:
            return " or ".join(dict.fromkeys(_value(each) for each in schema[word]))
    if "const" in schema or "enum" in schema:
        return ", ".join(f"`{json.dumps(each)}`" for each in schema.get("enum", [schema.get("const")]))
    kind = schema.get("type", "anything")
    words = " or ".join(kind) if isinstance(kind, list) else kind
    if "items" in schema:
        words = f"list of {_value(schema['items'])}"
    elif isinstance(inner := schema.get("additionalProperties"), dict):
        words = f"names, each with {_value(inner)}"
    default = f"; `{_cell(json.dumps(schema['default']))}` by default" if schema.get("default") is not None else ""
    return words + default


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _anchor(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")
