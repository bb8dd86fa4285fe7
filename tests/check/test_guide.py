# SPDX-License-Identifier: Apache-2.0
"""The guide to checks lists the rules that there are, each under its severity."""

from __future__ import annotations

import re
from pathlib import Path

from rai_missions.check.rules import RULES

GUIDE = (Path(__file__).parents[2] / "docs/guide/checks.md").read_text(encoding="utf-8")
PART = re.compile(r"^### ([^\n]+)\n(.*?)(?=^##)", re.DOTALL | re.MULTILINE)


def test_the_guide_lists_every_rule_under_its_severity() -> None:
    listed = [
        (name, "warning" if title == "Warnings" else "error")
        for title, text in PART.findall(GUIDE)
        for name in re.findall(r"^- `([a-z-]+)`:", text, re.MULTILINE)
    ]
    assert sorted(listed) == sorted((rule.name, rule.severity) for rule in RULES)
