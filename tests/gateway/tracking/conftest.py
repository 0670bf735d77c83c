"""A gateway whose customer's page needs no built panels."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import msgspec
import pytest
from gateway_kit import House, gateway

from dray.gateway.http.assets import Panels

MANIFEST = {
    "src/theme/init.ts": {"file": "assets/init-1.js"},
    "src/customer/main.ts": {"file": "assets/customer-1.js", "css": ["assets/customer-1.css"]},
}
"""What Vite writes: these tests need no built panels."""


@pytest.fixture
async def house(url: str, tmp_path: Path) -> AsyncIterator[House]:
    """A running gateway, with nobody else on the bus."""
    (tmp_path / ".vite").mkdir()
    (tmp_path / ".vite" / "manifest.json").write_bytes(msgspec.json.encode(MANIFEST))
    async with gateway(url, panels=Panels(tmp_path)) as house:
        yield house
