"""The file that says where a machine's controller is, and which of its nodes are which signals (docs/machines.md)."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from dray.adapters.signals.signal import SignalMapping


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
        for name, tag in self.tags.items():
            if tag.topic or tag.path or not tag.node:
                raise ValueError(f"{name}: by OPC UA it needs a `node`, and has no `topic` and no `path`")
        if self.security != "none":
            for name in ("certificate", "key", "server"):
                if not getattr(self, name):
                    raise ValueError(f"{name} is missing: security {self.security} needs it")
        elif self.user:
            raise ValueError(
                "user: without security its password would be read by anybody; choose a security"
            )
