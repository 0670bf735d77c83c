"""The `dray` command, and `python -m dray`."""

import sys

INTERRUPTED = 130
"""The exit code of a shell after Ctrl-C."""


def main() -> None:
    """Run the command line; Ctrl-C during loading ends it silently."""
    try:
        from dray.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()
