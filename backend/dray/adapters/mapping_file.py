"""The file that maps a controller's values to signals (docs/machines.md)."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import msgspec

from dray.errors import SettingsError

LARGEST_BYTES = 100_000
"""Maximum size; a larger file is something else."""

OPTION = "--mapping"

Mapping = TypeVar("Mapping", bound=msgspec.Struct)


def load_mapping(path: Path, kind: type[Mapping]) -> Mapping:
    """Read a mapping file.

    Args:
        path: the file's path.
        kind: the type of the mapping.

    Raises:
        SettingsError: it is missing or cannot be used; names the place.
    """
    return parse_mapping(_read(path), str(path), kind)


def parse_mapping(data: bytes, name: str, kind: type[Mapping]) -> Mapping:
    """A mapping from YAML; see `load_mapping`.

    Raises:
        SettingsError: it cannot be used.
    """
    try:
        return msgspec.convert(msgspec.yaml.decode(data) or {}, kind)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        raise SettingsError(OPTION, f"{name}: {error}") from None


def has_address(path: Path) -> bool:
    """Whether a mapping file contains its controller's address; its reader reports invalid YAML.

    Raises:
        SettingsError: it cannot be read.
    """
    try:
        said = msgspec.yaml.decode(_read(path))
    except (msgspec.DecodeError, UnicodeDecodeError):
        return True
    return isinstance(said, dict) and "url" in said


def _read(path: Path) -> bytes:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SettingsError(OPTION, f"{path} cannot be read: {error.strerror}") from None
    if len(data) > LARGEST_BYTES:
        raise SettingsError(OPTION, f"{path} has more than {LARGEST_BYTES} bytes: that is another file")
    return data
