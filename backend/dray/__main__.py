"""`python -m dray`: the same as the `dray` command."""

from dray.cli import main

main()
