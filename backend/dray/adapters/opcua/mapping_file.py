"""The file that says where a machine's controller is, and which of its nodes are which signals (docs/machines.md)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from dray.adapters.signals.signal import SignalMapping
from dray.errors import SettingsError

LARGEST_BYTES = 100_000
"""Above it, it is another file."""

OPTION = "--mapping"


class OpcUaMapping(SignalMapping, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """A machine's controller.

    Raises:
        ValueError: a certificate is missing that its security needs, or a signal cannot be what is said of it.
    """

    url: Annotated[str, Meta(pattern=r"^opc\.tcp://[^\s@]+$")]
    """As `opc.tcp://press-1.plant:4840`; no name and no password in it."""
    user: str = ""
    """Its password is DRAY_OPCUA_PASSWORD."""
    security: Literal["none", "Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss"] = "none"
    """Anything but `none` signs and encrypts."""
    certificate: str = ""
    """The agent's own, PEM or DER; beside the mapping file, as `key` and `server`."""
    key: str = ""
    server: str = ""
    """The controller's certificate, so that nobody else is believed to be it."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.security != "none":
            for name in ("certificate", "key", "server"):
                if not getattr(self, name):
                    raise ValueError(f"{name} is missing: security {self.security} needs it")
        elif self.user:
            raise ValueError(
                "user: without security its password would be read by anybody; choose a security"
            )


def load_mapping(path: Path) -> OpcUaMapping:
    """Read a mapping file.

    Raises:
        SettingsError: there is none, or it cannot be used; it says where.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SettingsError(OPTION, f"{path} cannot be read: {error.strerror}") from None
    if len(data) > LARGEST_BYTES:
        raise SettingsError(OPTION, f"{path} has more than {LARGEST_BYTES} bytes: that is another file")
    return parse_mapping(data, str(path))


def parse_mapping(data: bytes, name: str) -> OpcUaMapping:
    """A mapping from YAML; see `load_mapping`.

    Raises:
        SettingsError: it cannot be used.
    """
    try:
        return msgspec.convert(msgspec.yaml.decode(data) or {}, OpcUaMapping)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        raise SettingsError(OPTION, f"{name}: {error}") from None
