# SPDX-License-Identifier: Apache-2.0
"""How Fast DDS carries what a node reports, where the user brings no profile of their own.

Rule: anyone who brings a profile of their own for Fast DDS keeps it whole, and no process that is started meanwhile or
later inherits ours.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ("PICTURES", "PROMPT", "carried")

PROMPT = Path(__file__).with_name("fastdds.xml")
"""What was lost is sent again at once."""
PICTURES = Path(__file__).with_name("fastdds_pictures.xml")
"""The same, with room for pictures."""
VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
DEFAULT_FILE = "DEFAULT_FASTRTPS_PROFILES.xml"
"""Fast DDS takes a file of this name from the folder that it is started in."""
TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
_ONE_BY_ONE = threading.Lock()


@contextmanager
def carried(*, pictures: bool) -> Iterator[None]:
    """While this lasts the first node of the process is opened with our profile; Fast DDS reads one once a process.

    Args:
        pictures: The process publishes pictures, and needs shared memory for them.
    """
    with _ONE_BY_ONE:
        if os.environ.get(VARIABLE) or Path(DEFAULT_FILE).exists():
            yield
            return
        has_transports = bool(os.environ.get(TRANSPORTS))  # the user's, which our larger one would replace
        os.environ[VARIABLE] = str(PICTURES if pictures and not has_transports else PROMPT)
        try:
            yield
        finally:
            os.environ.pop(VARIABLE, None)
