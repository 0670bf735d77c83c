"""A vehicle's own key, in a file beside its journal: generated at its first start, and never replaced.

Like `dray.adapters.journal.lives` it survives a lost journal: the vehicle still stands on places that are reserved under this key.
"""

from __future__ import annotations

import os
from pathlib import Path

from dray.adapters.security.signing import SigningKey
from dray.errors import UnavailableError

KEY_BYTES = 32


def own_key(file: Path) -> bytes:
    """The 32 bytes of the private key; generated when the file is missing.

    Args:
        file: the key file; only its owner can read and write it.

    Raises:
        UnavailableError: reading or writing failed, or the file is damaged.
    """
    try:
        if not file.exists():
            _write(file, SigningKey.generate())
        private = file.read_bytes()
    except OSError as fault:
        raise UnavailableError(f"the key {file}", str(fault), "see to its folder") from fault
    if len(private) != KEY_BYTES:
        raise UnavailableError(
            f"the key {file}",
            f"has {len(private)} bytes, and not {KEY_BYTES}",
            "move it away, and say on a panel that the vehicle is off the floor: it begins with a new key",
        )
    return private


def _write(file: Path, private: bytes) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    new = file.with_name(f"{file.name}.new")
    new.unlink(missing_ok=True)
    with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as out:
        out.write(private)
        out.flush()
        os.fsync(out.fileno())
    new.replace(file)
