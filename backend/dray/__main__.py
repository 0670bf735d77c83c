"""The `dray` command, and `python -m dray`."""

import sys

INTERRUPTED = 130
"""A shell's exit code for what Ctrl-C has ended."""


def main() -> None:
    """Run the command line; Ctrl-C while it is still loaded ends it without a word."""
    try:
        from dray.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()
