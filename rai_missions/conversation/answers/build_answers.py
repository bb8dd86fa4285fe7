# SPDX-License-Identifier: Apache-2.0
"""Answers about a robot's build: how heavy, large and fast it is, by its description."""

from __future__ import annotations

from rai_missions.conversation.language.language import Language
from rai_missions.conversation.view import StatusView

__all__ = ("BUILD", "build_sentence", "knows_build")

BUILD = {
    "weight": ("mass_kg", "kg", ("mass",)), "size": ("size_m", "m", ("length", "width", "height")),
    "speed": ("speed_m_s", "m/s", ("speed",)),
}  # fmt: skip
"""Question → the field of the build that answers it, its unit, and what its numbers are called in the answer."""


def knows_build(name: str, view: StatusView) -> bool:
    """Whether a question is answered by what is known of the build."""
    return getattr(view.build, BUILD[name][0], None) is not None


def build_sentence(name: str, view: StatusView, language: Language) -> str:
    """The answer to a question of the build; that it is unknown, where it is."""
    if view.build is None or not knows_build(name, view):
        return language.text("build_unknown")
    field, unit, names = BUILD[name]
    value = getattr(view.build, field)
    values = (value,) if len(names) == 1 else value
    numbers = {each: _amount(number, unit, language) for each, number in zip(names, values, strict=True)}
    return language.text(name, build=view.build.name, **numbers)


def _amount(value: float, unit: str, language: Language) -> str:
    return language.decimals(f"{value:.2f}".rstrip("0").rstrip(".")) + f" {unit}"
