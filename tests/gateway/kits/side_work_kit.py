"""Side work, watched: how many pieces have been done, by any `SideWork`."""

from __future__ import annotations

from typing import Any

import pytest

from dray.gateway.http.side_work import SideWork


def count_pieces(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """The pieces that are begun from now on, as they come."""
    outcome, pieces = SideWork._outcome, list[bytes]()

    async def counted(side: SideWork, piece: bytes) -> Any:
        pieces.append(piece)
        return await outcome(side, piece)

    monkeypatch.setattr(SideWork, "_outcome", counted)
    return pieces
