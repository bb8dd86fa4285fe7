# SPDX-License-Identifier: Apache-2.0
"""Coverage-guided fuzzing (atheris): `python -m tests.fuzz.drive TARGET --seconds 600`; the extra `fuzz` brings it.

Rule: what is found is written down as bytes, to become a file of the corpus that every test run feeds again; the search
continues until its time is over, and ends with 1 where anything was found.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import NoReturn

__all__ = ("main",)

PATIENCE_S = 20
"""An input that takes longer is a crash."""
MOST_MIB = 1536


def main() -> int:
    """Fuzz one target for so many seconds; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target")
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--found", type=Path, default=Path("out/fuzz"), help="where crashes and new inputs go")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    began, ends, seed = time.time(), time.monotonic() + given.seconds, given.seed
    while (left := round(ends - time.monotonic())) > 0:
        if (child := os.fork()) == 0:  # what hangs or fills the memory ends the process that searches
            search(given.target, left, given.found, seed)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if status in (2, -signal.SIGINT):  # no such target; interrupted
            return 2
        seed += 1
    news = [path for path in given.found.glob(f"{given.target}-*") if path.stat().st_mtime >= began]
    for path in news:
        print(f"found: {path}")  # noqa: T201
    return int(bool(news))


def search(target: str, seconds: int, found: Path, seed: int) -> NoReturn:
    """Search in this process, which ends with it."""
    import atheris  # type: ignore[import-untyped,unused-ignore]

    with atheris.instrument_imports(include=["rai_missions", "visualize"]):
        from tests.fuzz.mutator import mutated
        from tests.fuzz.seeds import seeds
        from tests.fuzz.targets import TARGETS, fed

    if target not in TARGETS:
        print(f"no target {target!r}; there are: {', '.join(TARGETS)}", file=sys.stderr)  # noqa: T201
        os._exit(2)
    corpus = found / target
    corpus.mkdir(parents=True, exist_ok=True)
    for number, good in enumerate(seeds(target)):
        (corpus / f"seed-{number}").write_bytes(good)
    is_json = target in ("mission", "profile", "rows")
    folder = Path(tempfile.mkdtemp(prefix="fuzz-", dir="/dev/shm" if os.path.isdir("/dev/shm") else None))
    crashes: set[str] = set()

    def one(data: bytes) -> None:
        try:
            fed(target, data, folder)
        except Exception as crash:  # noqa: BLE001 - whatever it is, it is what is looked for
            frame = traceback.extract_tb(crash.__traceback__)[-1]
            name = f"{type(crash).__name__}-{Path(frame.filename).stem}-{frame.lineno}"
            if name not in crashes:  # one of a kind is enough, and the search continues
                crashes.add(name)
                (found / f"{target}-{name}").write_bytes(data)
                print(f"CRASH {name}: {crash!r:.300}", flush=True)  # noqa: T201

    def change(data: bytes, most: int, number: int) -> bytes:
        source = random.Random(number)
        if is_json and source.random() < 0.9:
            try:
                return json.dumps(mutated(json.loads(data), source)).encode("utf-8", "surrogatepass")[:most]
            except (ValueError, RecursionError, OverflowError):
                pass
        return bytes(atheris.Mutate(data, most))

    words = [
        sys.argv[0], str(corpus), f"-max_total_time={seconds}", f"-timeout={PATIENCE_S}", f"-seed={seed}",
        f"-rss_limit_mb={MOST_MIB}", f"-artifact_prefix={corpus}-", "-max_len=60000", "-print_final_stats=1",
        "-len_control=0", "-verbosity=0",
    ]  # fmt: skip
    atheris.Setup(words, one, custom_mutator=change)
    atheris.Fuzz()
    os._exit(0)


if __name__ == "__main__":
    sys.exit(main())
