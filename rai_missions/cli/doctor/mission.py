# SPDX-License-Identifier: Apache-2.0
"""Whether those of other packages whom a mission asks can be opened here."""

from __future__ import annotations

import os
from collections.abc import Iterator

from rai_missions.cli.doctor.finding import MachineFinding, tried
from rai_missions.mission.mission import Mission
from rai_missions.states.decision import ANSWERERS

__all__ = ("answerers",)


def answerers(mission: Mission) -> Iterator[MachineFinding]:
    """Everyone whom a mission asks apart from the model, the operator and the rules, in the order of the document.

    Args:
        mission: One whose packages are installed, or it could not have been loaded.
    """
    offers = mission.answerers()
    asked = (name for _, _, state in mission.walk() for each in state.decisions().values() for name in each.ask)
    for name in dict.fromkeys(asked):
        if (offer := offers.get(name)) is not None:
            fault = tried("answerer", list(offer), os.environ).fault
            yield (
                MachineFinding("missing", str(offer), fault) if fault else MachineFinding("ok", f"{offer} can be asked")
            )
        elif name not in ANSWERERS:
            remedy = 'list the package that offers it in "uses", or bring it by a program'
            yield MachineFinding("absent", f"the answerer '{name}' of {mission.name}", remedy)
