"""Do the tests notice mistakes? Puts each sin of the list into a copy of the tree and runs tests there.

python -m tests.mutants [NAME ...]: of all sins, or of those whose names hold one of these. First every test that the
list names has to pass without a sin. A sin is caught when a test fails by its own assertion (see verdict.py); where
none of those named does, all of the renderer's fast tests are asked. Exit status 1 if a sin survives.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

from tests.mutants.sin import ROOT, Sin
from tests.mutants.sins import SINS

TREE = ("kernels", "server", "client", "tests", "pyproject.toml")
#: Asked last. Texts of programs change with every mistake: tests of the text itself do not count.
OTHERS = ("tests/kernels", "tests/analytic")
OF_THE_TEXT = (
    "tests/kernels/test_program.py::test_golden_text",
    "tests/kernels/test_program_full.py::test_everything_builds_without_a_warning",
)
SECONDS, OTHERS_SECONDS = 600, 2400


def copy(root: Path, folder: Path) -> None:
    for name in TREE:
        if (root / name).is_dir():
            shutil.copytree(root / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(root / name, folder)


def run(tree: Path, tests: Sequence[str], kernels: Path, seconds: float) -> dict[str, Any]:
    """The verdict of pytest on tests of a tree; kernels: where compiled ones are kept."""
    verdict = tree / "verdict.json"
    verdict.unlink(missing_ok=True)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "tests.mutants.verdict"]
    command += ["--verdict", str(verdict), *(f"--deselect={test}" for test in OF_THE_TEXT), *tests]
    path = os.pathsep.join(str(tree / folder) for folder in ("kernels", "server", "client"))
    environment = {**os.environ, "PYTHONPATH": path, "POCL_CACHE_DIR": str(kernels)}
    log = tree / "log.txt"
    with log.open("wb") as out:
        process = subprocess.Popen(
            command, cwd=tree, env=environment, stdout=out, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return {"passed": 0, "caught": None, "says": "", "broken": [f"no end within {seconds} s"]}
    if not verdict.exists():
        return {"passed": 0, "caught": None, "says": "", "broken": [log.read_text(errors="replace")[-2000:]]}
    found: dict[str, Any] = json.loads(verdict.read_text())
    if process.returncode not in (0, 1, 2):  # 2: stopped at the first that noticed
        found["broken"].append(log.read_text(errors="replace")[-2000:])
    return found


def innocent(root: Path, kernels: Path, tests: Sequence[str]) -> list[str]:
    """What is wrong with the tests before anybody has sinned."""
    with tempfile.TemporaryDirectory() as folder:
        copy(root, Path(folder))
        found = run(Path(folder), tests, kernels, OTHERS_SECONDS)
    faults = [*found["broken"], *([f"{found['caught']}: {found['says']}"] if found["caught"] else [])]
    return faults or ([] if found["passed"] >= len(tests) else ["some were not run"])


def judge(root: Path, kernels: Path, sin: Sin) -> tuple[Sin, dict[str, Any], float]:
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder)
        copy(root, tree)
        sin.commit(tree)
        found = run(tree, sin.tests, kernels, SECONDS)
        if not found["caught"]:
            others = run(tree, OTHERS, kernels, OTHERS_SECONDS)
            found = others | {"broken": [*found["broken"], *others["broken"]]}
    return sin, found, time.monotonic() - start


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("names", nargs="*", help="parts of names of sins; by default all")
    parser.add_argument("--jobs", type=int, default=2, help="how many at a time; 2 by default")
    arguments = parser.parse_args()
    sins = [sin for sin in SINS if not arguments.names or any(name in sin.name for name in arguments.names)]
    if not sins:
        parser.error(f"no sin has such a name; there are: {', '.join(sin.name for sin in SINS)}")
    named = list(dict.fromkeys(test for sin in sins for test in sin.tests))

    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(arguments.jobs) as pool:
        # The tree as it is now, whatever becomes of it meanwhile.
        root, kernels = Path(folder) / "tree", Path(folder) / "kernels"
        root.mkdir()
        kernels.mkdir()
        copy(ROOT, root)
        if faults := [fault for sin in sins if (fault := sin.fault(root))]:
            print("the list needs mending:", *faults, sep="\n")
            return 1
        print(f"{len(named)} tests without a sin", flush=True)
        parts = [part for first in range(arguments.jobs) if (part := named[first :: arguments.jobs])]
        if faults := [fault for part in pool.map(partial(innocent, root, kernels), parts) for fault in part]:
            print("these must pass before anything else:", *faults, sep="\n")
            return 1
        survived = 0
        for sin, found, seconds in pool.map(partial(judge, root, kernels), sins):
            survived += found["caught"] is None
            print(f"{sin.name:58} {sin.file:58} {found['caught'] or 'SURVIVED'}  {seconds:.0f} s", flush=True)
            if found["caught"] is None:
                print(*(f"    {line}" for line in found["broken"]), sep="\n", flush=True)
    print(f"{len(sins) - survived} of {len(sins)} caught")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
