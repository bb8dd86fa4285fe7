# SPDX-License-Identifier: Apache-2.0
"""Whether a journal is being written: its writer's lock says so, and dies with the writer.

Rule: a lock that is free is held here for no longer than it takes to see that it is free.
"""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path

from rai_missions.journal.sqlite import Lock

__all__ = ("is_written",)


def is_written(path: Path) -> bool:
    """Whether some process writes a journal now.

    Where the file system knows no locks, the process counts that the run file beside the journal names; without a run
    file there is nobody.
    """
    try:
        about = path.stat()
        if (about.st_dev, about.st_ino) in Lock.held:
            return True  # to open it again here would drop this process's own locks
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return _is_named(path)
    finally:
        os.close(descriptor)
    return False


def _is_named(path: Path) -> bool:
    try:
        pid = json.loads(Path(f"{path}.watch").read_text(encoding="utf-8"))["pid"]
        os.kill(pid, 0)
    except PermissionError:
        return True
    except (OSError, ValueError, KeyError, TypeError, OverflowError):
        return False
    return True
