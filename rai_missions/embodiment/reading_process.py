# SPDX-License-Identifier: Apache-2.0
"""Documents are read in a process of their own, with bounded memory and time; this module is both of its ends.

Text and URDF, whose readers are linear, are read without it.

Rule: a file that hangs, exhausts its memory or crashes its reader costs that file alone.
Rule: the process has no variable with a secret, and cannot write a file.
"""

from __future__ import annotations

import json
import os
import resource
import selectors
import subprocess
import sys
import time
from contextlib import redirect_stdout
from pathlib import Path, PurePosixPath
from types import TracebackType
from typing import IO, Any, Self

from rai_missions.embodiment.document import Section, TextDocument
from rai_missions.embodiment.readers import FORMATS, read_document
from rai_missions.errors import raised_text
from rai_missions.redaction import cut, redacted, variables

__all__ = ("ReadingProcess",)

LONGEST_S = 60.0
"""Wall time for one file."""
MEMORY_BYTES = 2 * 1024**3
"""Address space of the process."""
LARGEST_ANSWER = 64_000_000
CHUNK = 1 << 20


class ReadingProcess:
    """Reads documents, one after the other; started with the first, and again after one that ended it.

    Args:
        longest_s: Wall time for one file.
    """

    def __init__(self, longest_s: float = LONGEST_S) -> None:
        self._longest_s = longest_s
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def read(self, name: str, data: bytes) -> TextDocument:
        """A document.

        Raises:
            ValueError: What is wrong with it; also that it took too long, or ended its reader.
        """
        format_ = FORMATS[PurePosixPath(name).suffix.lower()]
        data = _without_secrets(data) if format_.is_text else data
        if format_.is_linear:
            return read_document(name, data)
        answer = self._ask(name, data)
        if "fault" in answer:
            raise ValueError(str(answer["fault"]))
        return TextDocument(answer["title"], tuple(Section(tuple(heads), text) for heads, text in answer["sections"]))

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    def _ask(self, name: str, data: bytes) -> dict[str, Any]:
        process = self._started()
        assert process.stdin is not None and process.stdout is not None
        try:
            process.stdin.write(json.dumps([name, len(data)]).encode() + b"\n")
            process.stdin.write(data)
            process.stdin.flush()
            line = self._line(process.stdout)
        except (BrokenPipeError, EOFError):
            line = b""
        except TimeoutError:
            self.close()
            raise ValueError(f"took longer than {self._longest_s:g} s to read; split it, or save it again") from None
        if not line:
            self.close()
            raise ValueError("ended the program that read it, or needs more memory than it may have; save it again")
        found: dict[str, Any] = json.loads(line)
        return found

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            command = [sys.executable, "-P", "-m", "rai_missions.embodiment.reading_process"]
            package = str(Path(__file__).parents[2])
            environment = {**variables(secret=False), "PYTHONPATH": package, "PYTHONIOENCODING": "utf-8"}
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=environment,
                start_new_session=True,
            )
        return self._process

    def _line(self, stream: IO[bytes]) -> bytes:
        """A line of the process's output.

        Raises:
            TimeoutError: There is none in time.
            EOFError: The process ended.
        """
        ends, found = time.monotonic() + self._longest_s, bytearray()
        with selectors.DefaultSelector() as selector:
            selector.register(stream, selectors.EVENT_READ)
            while not found.endswith(b"\n"):
                if not selector.select(max(0.0, ends - time.monotonic())):
                    raise TimeoutError
                piece = os.read(stream.fileno(), CHUNK)
                if not piece or len(found) > LARGEST_ANSWER:
                    raise EOFError
                found += piece
        return bytes(found)


def _without_secrets(data: bytes) -> bytes:
    """A text without secrets, as its author wrote it: a reader may leave out marks that are a part of one."""
    try:
        return redacted(data.decode()).encode()
    except UnicodeDecodeError:  # which the reader reports
        return data


def main() -> None:
    """Read the documents that come on standard input, until it ends."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    out = sys.stdout.buffer
    with redirect_stdout(sys.stderr):  # what a reader prints is no answer
        while head := sys.stdin.buffer.readline():
            name, length = json.loads(head)
            out.write(json.dumps(_answer(name, sys.stdin.buffer.read(length))).encode() + b"\n")
            out.flush()


def _answer(name: str, data: bytes) -> dict[str, Any]:
    try:
        document = read_document(name, data)
    except ValueError as error:
        return {"fault": cut(error, 500)}
    except MemoryError:
        return {"fault": "needs more memory than it may have; split it"}
    except Exception as error:  # noqa: BLE001 - whatever a file makes of the code that reads it
        return {"fault": f"cannot be read ({cut(raised_text(error), 200)}); save it again"}
    return {"title": document.title, "sections": document.sections}


if __name__ == "__main__":
    main()
