"""The page after the login: one of ours, never another site's."""

from __future__ import annotations

import re

from dray.gateway.access.principal import Role

HOMES = {Role.MANAGER: "/", Role.OPERATOR: "/operator"}

_OURS = re.compile(r"/(?![/\\])[^\\\x00-\x20\x7f]*", re.ASCII)
"""A path on this host: browsers read two slashes, or a backslash, as the start of another host's name."""


def redirect_target(wanted: str, role: Role) -> str:
    """The page to go on to.

    Args:
        wanted: the page named in the login page's address, by any author.
        role: role of the person.
    """
    inside = _OURS.fullmatch(wanted) and wanted.isascii() and not wanted.startswith(("/login", "/api/"))
    return wanted if inside else HOMES[role]
