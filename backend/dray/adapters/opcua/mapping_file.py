"""The file with the address of a machine's controller, and its nodes by signal (docs/machines.md)."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from dray.adapters.signals.signal import SignalMapping, Tag


class OpcUaMapping(SignalMapping, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """A machine's controller.

    Raises:
        ValueError: the security needs a missing certificate, or a signal's mapping is impossible.
    """

    url: Annotated[str, Meta(pattern=r"^opc\.tcp://[^\s@]+$")]
    """The address, as `opc.tcp://press-1.plant:4840`; without name and password."""
    user: str = ""
    """The user name; DRAY_OPCUA_PASSWORD is its password."""
    security: Literal["none", "Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss"] = "none"
    """The security policy; all but `none` sign and encrypt."""
    certificate: str = ""
    """The agent's own certificate, PEM or DER; its path, as `key` and `server`, starts at the mapping file's folder."""
    key: str = ""
    server: str = ""
    """The controller's certificate, which proves its identity."""

    life: str = ""
    """The life of a simulated controller, whose counters begin anew with each. Empty for a real one."""

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

    def address(self, tag: Tag) -> str:
        """See `SignalMapping.address`."""
        life = f", life {self.life}" if self.life else ""
        return f"{tag.node} of {self.url}{life}"
