"""What a machine does not allow, and nobody can install: such a test ends here, in a line that nobody overlooks."""

from __future__ import annotations

from typing import NoReturn

import pytest


class Forbidden(pytest.skip.Exception):
    """This machine forbids what the test is about."""


def forbidden(reason: str) -> NoReturn:
    """End a test that this machine forbids; it is no skip, and no failure under CI either.

    Only for what the machine's owner decides: a kernel's namespaces, a network's multicast. What is merely not
    installed is skipped, and fails under CI.
    """
    raise Forbidden(reason)
