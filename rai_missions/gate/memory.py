# SPDX-License-Identifier: Apache-2.0
"""What a gate finds again when it is started again: who held control last.

Rule: where that is not known, though there was a gate before, the operator may have held it: no one begins.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from rai_missions.errors import irregular, make_folder_of
from rai_missions.redaction import logger
from rai_missions.states.control import HOLDERS

__all__ = ("Memory", "usual_path")

log = logger(__name__)


class Memory:
    """The small file in which a gate keeps who holds control.

    Args:
        path: The file; its folder is made when it is first written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def first(self, safe: str) -> str:
        """Who holds control as the gate begins: the safe one, unless the operator or no one may have had it last."""
        try:
            if sort := irregular(self.path):  # a pipe would never end
                raise OSError(f"that is {sort}")
            stored = json.loads(self.path.read_text(encoding="utf-8"))
            last = stored["holder"]
        except FileNotFoundError:
            return safe
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            log.warning("who held control last is not known, so no one has it: %s: %s", self.path, error)
            return "nobody"
        return safe if last in HOLDERS and last not in ("operator", "nobody") else "nobody"

    def note(self, holder: str) -> None:
        """Control is with another holder from now on; a file that cannot be written is logged, and emptied."""
        temporary = self.path.with_name(f"{self.path.name}.{os.getpid()}")
        try:
            make_folder_of(self.path)
            temporary.write_text(json.dumps({"holder": holder}), encoding="utf-8")
            temporary.replace(self.path)
        except OSError:
            log.exception("a gate that is started again will not know that %s holds control", holder)
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            with suppress(OSError):  # an empty file needs no room, and no pipe is waited for
                os.close(os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NONBLOCK, 0o644))


def usual_path(name: str, domain: int | None, environment: Mapping[str, str] = os.environ) -> Path:
    """Where a gate of a name on a ROS domain keeps it: in the user's folder for states (XDG).

    Args:
        name: The gate's, such as `/gate`.
        domain: The ROS domain; the environment's by default.
        environment: Variables.
    """
    folder = environment.get("XDG_STATE_HOME") or os.path.join(os.path.expanduser("~"), ".local", "state")
    number = domain if domain is not None else environment.get("ROS_DOMAIN_ID", "") or "0"
    word = name.strip("/").replace("/", ".")
    return Path(folder) / "rai_missions" / f"gate-{word}-{number}.json"
