"""What the tests share: the bundled archive, and the command line from the same wheel."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ARCHIVE = ROOT / "fixtures" / "archive"


def roadbench(*arguments, timeout=600, code=0):
    """The command line; fails the test where the exit code is another one."""
    command = [sys.executable, "-m", "roadbench", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)
    assert done.returncode == code, done.stderr
    return done.stdout


def files(out):
    """Every table of an output folder, but for those over the whole fleet: path below it, and bytes."""
    return {
        str(path.relative_to(out)): path.read_bytes()
        for path in sorted(out.rglob("*.parquet"))
        if not path.relative_to(out).parts[0].startswith("fleet")
    }


@pytest.fixture(scope="session")
def log():
    """A session of the archive that is in the repository."""
    return sorted((ARCHIVE / "sessions" / "bike=archive_01").rglob("*.parquet"))[0]


@pytest.fixture(scope="session")
def bike():
    """Its bike."""
    return ARCHIVE / "bikes" / "archive_01.toml"


@pytest.fixture(scope="session")
def written(log, tmp_path_factory):
    """What the command line writes for that session."""
    out = tmp_path_factory.mktemp("written")
    roadbench("run", log, "--bikes", ARCHIVE / "bikes", "--out", out, "--signals")
    return out
