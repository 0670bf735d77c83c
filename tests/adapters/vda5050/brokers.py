"""A broker for tests, as a process of its own that can be killed and come back: rumqttd, in the wheel of iotcore."""

from __future__ import annotations

import socket
from pathlib import Path

from iotcore import Broker


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class TestBroker:
    """On 127.0.0.1; with TLS and a login where a folder with their files is given."""

    __test__ = False

    def __init__(self, folder: Path, *, user: str = "", password: str = "", tls: bool = False) -> None:
        self.port = free_port()
        self._config = folder / "broker.toml"
        self._config.write_text(_config(self.port, folder, user, password, tls), encoding="utf-8")
        self._broker: Broker | None = None

    @property
    def url(self) -> str:
        return f"mqtt://127.0.0.1:{self.port}"

    def start(self) -> None:
        self._broker = Broker(config_path=str(self._config)).start(timeout=60.0)

    def stop(self) -> None:
        if self._broker is not None:
            self._broker.stop()
            self._broker = None


def _config(port: int, folder: Path, user: str, password: str, tls: bool) -> str:
    lines = [
        "id = 0",
        "[router]",
        "id = 0",
        "max_connections = 100",
        "max_outgoing_packet_count = 1000",
        "max_segment_size = 10485760",
        "max_segment_count = 10",
        "[v4.1]",
        'name = "v4-1"',
        f'listen = "127.0.0.1:{port}"',
        "next_connection_delay_ms = 1",
        "[v4.1.connections]",
        "connection_timeout_ms = 30000",
        "max_payload_size = 1048576",
        "max_inflight_count = 500",
        "dynamic_filters = true",
    ]
    if user:
        lines += ["[v4.1.connections.auth]", f'{user} = "{password}"']
    if tls:
        lines += [
            "[v4.1.tls]",
            f'certpath = "{folder / "broker.pem"}"',
            f'keypath = "{folder / "broker.key"}"',
        ]
    return "\n".join(lines) + "\n"
