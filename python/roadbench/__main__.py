"""``python -m roadbench`` and the script ``roadbench``: the command line."""

import sys

from roadbench._roadbench import main as _main


def main() -> int:
    """Runs the command that ``sys.argv`` says; gives back its exit code."""
    return _main(["roadbench", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
