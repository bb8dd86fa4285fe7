# SPDX-License-Identifier: Apache-2.0
"""A difference as JSON, for programs; `difference.schema.json` describes it, and it stays so within one `format`."""

from __future__ import annotations

import json
from typing import Any

from visualize.diff.change import Change, heading
from visualize.diff.difference import Difference

__all__ = ("FORMAT", "as_json", "plain_difference")

FORMAT = 1


def plain_difference(given: Difference) -> dict[str, Any]:
    """What changed, as JSON values."""
    return {
        "format": FORMAT,
        "mission": given.new.name,
        "old": {"name": given.old.name, "version": given.versions[0]},
        "new": {"name": given.new.name, "version": given.versions[1]},
        "safety": len(given.safety),
        "other": len(given.others),
        "renamed": [each._asdict() for each in given.names],
        "changes": [_change(change) for change in given.changes],
    }


def _change(change: Change) -> dict[str, Any]:
    return {**change._asdict(), "heading": heading(change)}


def as_json(given: Difference) -> bytes:
    """The file."""
    return (json.dumps(plain_difference(given), indent=2, ensure_ascii=False) + "\n").encode("utf-8", "replace")
