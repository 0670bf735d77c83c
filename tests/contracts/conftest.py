"""Contract tests are coroutines: each runs inside the world that it is given. Some worlds are in `tests/adapters`."""

from __future__ import annotations

import inspect
import sys
from pathlib import Path
from typing import Any

import pytest

sys.path[:0] = (str(Path(__file__).parent / "kits"), str(Path(__file__).parents[1] / "adapters"))


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Let the fixture `world` run the test; it knows on which loop."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    arguments = {name: pyfuncitem.funcargs[name] for name in inspect.signature(pyfuncitem.obj).parameters}
    world: Any = arguments["world"]
    world.run(pyfuncitem.obj(**arguments))
    return True
