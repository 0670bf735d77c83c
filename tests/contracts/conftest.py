"""Contract tests are coroutines: each runs inside the world that it is given."""

from __future__ import annotations

import inspect
from typing import Any

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Let the fixture `world` run the test; it knows on which loop."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    arguments = {name: pyfuncitem.funcargs[name] for name in inspect.signature(pyfuncitem.obj).parameters}
    world: Any = arguments["world"]
    world.run(pyfuncitem.obj(**arguments))
    return True
