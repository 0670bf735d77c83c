"""Where somebody goes after the login: on to a page of ours, and never elsewhere."""

from __future__ import annotations

import re

from dray.gateway.access.principal import Role

HOMES = {Role.MANAGER: "/", Role.OPERATOR: "/operator"}

_OURS = re.compile(r"/(?![/\\])[^\\\x00-\x20\x7f]*", re.ASCII)
"""A path of this host: browsers take two slashes, or a backslash, for the beginning of another one's name."""


def redirect_target(wanted: str, role: Role) -> str:
    """The page to go on to.

    Args:
        wanted: what the login page's address asks for, whoever may have written it.
        role: of the one who has logged in.
    """
    inside = _OURS.fullmatch(wanted) and wanted.isascii() and not wanted.startswith(("/login", "/api/"))
    return wanted if inside else HOMES[role]
