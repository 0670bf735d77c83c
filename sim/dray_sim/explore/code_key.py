"""The key of code: its last commit, and a digest of the files as they are.

A result that took long is kept with the key of its code. It stands as long as the code has that digest.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import dray_sim
from dray.errors import SettingsError

ROOT = Path(dray_sim.__file__).parents[2]
"""The folder of the repository, where Dray runs from one."""

PLAYED = (
    "backend/dray",
    "sim/dray_sim",
    "requirements.txt",
    ":(exclude)backend/dray/cli",
    ":(exclude)backend/dray/gateway",
    ":(exclude)backend/dray/store",
    ":(exclude)sim/dray_sim/bench",
)
"""The code that the outcome of a played seed depends on, as pathspecs of git."""

DIGEST_LENGTH = 16
"""Hexadecimal digits: 64 bits tell all codes apart that one repository ever has."""


NO_COMMIT = "Dray must run from its git repository, whose commit each seed is kept with"


class CodeKey(NamedTuple):
    """The code of a result."""

    commit: str
    """The last commit that changed it, with `+` where it has changes that were not committed."""
    digest: str
    """Of the names and contents of all its files, committed or not."""


def code_key(root: Path, paths: Sequence[str]) -> CodeKey:
    """The key of the code below these paths.

    Args:
        root: a folder in a git repository; paths begin there.
        paths: pathspecs of git; those that match nothing are left out.

    Raises:
        OSError: there is no git, or a file cannot be read.
        CalledProcessError: `root` is in no repository.
    """
    commit = _git(root, "log", "-1", "--format=%h", "--", *paths).decode().strip()
    is_changed = bool(_git(root, "status", "--porcelain", "--", *paths))
    listed = _git(root, "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", *paths)
    digest = hashlib.sha256()
    for name in sorted({name for name in listed.split(b"\0") if name}):
        path = root / os.fsdecode(name)
        content = path.read_bytes() if path.is_file() else b""
        digest.update(b"%d %s\0%d\0" % (path.is_file(), name, len(content)) + content)
    return CodeKey(commit + ("+" if is_changed else ""), digest.hexdigest()[:DIGEST_LENGTH])


def played_code() -> CodeKey:
    """The key of the code that plays seeds in this process.

    Raises:
        SettingsError: the code is in no git repository, or has no commit there.
    """
    try:
        key = code_key(ROOT, PLAYED)
    except subprocess.CalledProcessError as error:
        raise SettingsError("--ledger", f"{NO_COMMIT}: {error.stderr.decode().strip()}") from None
    except OSError as error:
        raise SettingsError("--ledger", f"{NO_COMMIT}: {error}") from None
    if not key.commit.rstrip("+"):
        raise SettingsError("--ledger", NO_COMMIT)
    return key


def _git(root: Path, *arguments: str) -> bytes:
    command = ["git", *arguments]
    return subprocess.run(command, cwd=root, capture_output=True, check=True).stdout  # noqa: S603 (git, and paths of ours)
