"""Certificates of a plant `p`, one for each agent, for tests."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from dray.adapters.security.certificates import Authority
from dray.messages.kinds import Kind


def issued(folder: Path, agents: Mapping[str, Kind]) -> Path:
    """Make an authority and a certificate for each agent in a folder; the folder."""
    authority = Authority.make("p")
    authority.write(folder)
    for agent, kind in agents.items():
        authority.issue(folder, "p", {agent: kind})
    return folder
