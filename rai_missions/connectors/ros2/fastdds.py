# SPDX-License-Identifier: Apache-2.0
"""How Fast DDS carries what a node reports, where the user brings no profile of their own.

Rule: anyone who brings a profile of their own for Fast DDS keeps it whole, and no process that is started meanwhile or
later inherits ours.
"""

from __future__ import annotations

import importlib.util
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

__all__ = ("FAST_DDS_2", "FAST_DDS_3", "Edition", "carried", "edition")

HERE = Path(__file__).parent


class Edition(NamedTuple):
    """How one generation of Fast DDS is set: the words of its profiles and the names of its variables differ."""

    variable: str
    """Names a profile."""
    default_file: str
    """Fast DDS takes a file of this name from the folder that it is started in."""
    prompt: Path
    """What was lost is sent again at once."""
    pictures: Path
    """The profile with prompt repeats and with room for pictures."""


FAST_DDS_2 = Edition(
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "DEFAULT_FASTRTPS_PROFILES.xml",
    HERE / "fastdds.xml",
    HERE / "fastdds_pictures.xml",
)
"""The edition of Jazzy."""
FAST_DDS_3 = Edition(
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "DEFAULT_FASTDDS_PROFILES.xml",
    HERE / "fastdds3.xml",
    HERE / "fastdds3_pictures.xml",
)
"""The edition of Kilted and later, which still reads the older variable."""
TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
_ONE_BY_ONE = threading.Lock()


@contextmanager
def carried(*, pictures: bool) -> Iterator[None]:
    """While this lasts the first node of the process is opened with our profile; Fast DDS reads one once a process.

    Args:
        pictures: The process publishes pictures, and needs shared memory for them.
    """
    with _ONE_BY_ONE:
        chosen, all_ = edition(), (FAST_DDS_2, FAST_DDS_3)
        if any(os.environ.get(each.variable) or Path(each.default_file).exists() for each in all_):
            yield
            return
        has_transports = bool(os.environ.get(TRANSPORTS))  # the user's, which our larger one would replace
        os.environ[chosen.variable] = str(chosen.pictures if pictures and not has_transports else chosen.prompt)
        try:
            yield
        finally:
            os.environ.pop(chosen.variable, None)


def edition() -> Edition:
    """The generation that this ROS has: the package `fastdds` came with the third, in the place of `fastrtps`."""
    spec = importlib.util.find_spec("rclpy")
    around = Path(spec.origin).parents if spec is not None and spec.origin is not None else ()
    prefixes = [*around, *map(Path, filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)))]
    return FAST_DDS_3 if any((each / "share" / "fastdds").is_dir() for each in prefixes) else FAST_DDS_2
