# SPDX-License-Identifier: Apache-2.0
"""The browser that pages are measured and pictured in."""

from __future__ import annotations

import shutil

__all__ = ("find_browser",)

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chromium-headless-shell")
"""A whole one first: what a person sees is measured, and pictures have its letters."""


def find_browser() -> str | None:
    """The path of the system's own; None where there is none."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)
