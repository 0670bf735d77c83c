"""Settings that an operator of the software may choose, read from ``DRAY_...`` variables.

Every field has a unit and a reason for its default. Command line options override variables. Both are checked here;
no other module reads the environment.
"""

from __future__ import annotations

import os
import re
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Literal, Self
from urllib.parse import quote, unquote, urlsplit

from pydantic import AfterValidator, BeforeValidator, Field, IPvAnyNetwork, SecretStr, ValidationError
from pydantic_core import ErrorDetails
from pydantic_settings import NoDecode, SettingsConfigDict

from dray.errors import SettingsError
from dray.keeping import Keeping
from dray.shift_times import checked_shifts

PREFIX = "DRAY_"

SECRETS = Path("/run/secrets")
"""The folder in which containers find secrets: one file each, named as the variable in small letters."""

ALIKE = 0.86
"""The least similarity (`difflib`) at which two names count as alike: missing, wrong or exchanged letters, not another word."""

FORMER = {f"{PREFIX}{kind}_KEPT": f"{PREFIX}{kind}_DAYS" for kind in ("EVENTS", "SAMPLES", "AUDIT")}
"""Former variables, and the ones that replaced them."""

BY_OPTION = {f"{PREFIX}DB": f"{PREFIX}DATABASE_URL", f"{PREFIX}PLANT": f"{PREFIX}PLANT_FILE"}
"""Variables named as command line options, and the settings of these options."""

SHOWN_CHARS = 60
"""Maximum characters of a refused value in its message."""

_BOUNDS = (("ge", "of at least {}"), ("gt", "above {}"), ("le", "of at most {}"), ("lt", "below {}"))
"""Attributes of a field's bounds, and each in words."""

_LINE = re.compile(r"\s*(#.*|(export\s+)?\w+\s*=.*)?")
"""A line of a settings file: a variable, a comment, or nothing."""

_NAMED = re.compile(rf"^\s*(?:export\s+)?({PREFIX}\w+)\s*=", re.MULTILINE)
"""A variable that a line of a settings file names."""

_DRIVERS = {
    "sqlite": "sqlite+aiosqlite",
    "sqlite+aiosqlite": "sqlite+aiosqlite",
    "postgres": "postgresql+asyncpg",
    "postgresql": "postgresql+asyncpg",
    "postgresql+asyncpg": "postgresql+asyncpg",
}
"""The supported databases as people write them, and the asynchronous driver of each."""


def _database_url(url: str) -> str:
    scheme, mark, rest = url.partition("://")
    driver = _DRIVERS.get(scheme)
    if not mark or driver is None:
        raise ValueError("write it as sqlite:///dray.db or postgresql://user@host/name")
    if driver == "sqlite+aiosqlite":
        path = rest.removeprefix("/")
        if path in {"", ":memory:"} or "mode=memory" in path:
            raise ValueError("a database in memory forgets its orders; name a file, as sqlite:///dray.db")
    return f"{driver}://{rest}"


def host_and_port(address: str) -> tuple[str, int]:
    """The parts of HOST:PORT; an IPv6 address as host stands in brackets, as [::1]:9101.

    Raises:
        ValueError: it has another form.
    """
    host, _, port = address.rpartition(":")
    if host.startswith("[") and host.endswith("]"):
        host = host[1:-1]
    elif ":" in host:
        raise ValueError("put an IPv6 address into brackets, as [::1]:9101")
    if not host or not port.isdecimal() or int(port) >= 2**16:
        raise ValueError("write it as HOST:PORT, as 127.0.0.1:9101")
    return host, int(port)


def _address(text: str) -> str:
    if text:
        host_and_port(text)
    return text


def _addresses(several: tuple[str, ...]) -> tuple[str, ...]:
    for address in several:
        try:
            host_and_port(address)
        except ValueError as error:
            raise ValueError(f"{address!r}: {error}") from None
    return several


def _agent_name(text: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_.-]{0,26}", text):
        raise ValueError("write letters, digits, _ . and -, a letter first, at most 27")
    return text


def _has_port(url: str) -> bool:
    """Whether the port of a URL is one, if it has any."""
    try:
        return urlsplit(url).port != 0
    except ValueError:
        return False


def _host(text: str) -> str:
    if re.search(r"[\s/@?#\[\]]", text):
        raise ValueError("write a name or an address alone, as 127.0.0.1, ::1 or 0.0.0.0 for all")
    return text


def _host_names(several: tuple[str, ...]) -> tuple[str, ...]:
    for name in several:
        if name != "*" and not re.fullmatch(r"[\w.-]+|\[?[0-9a-fA-F:.]+\]?", name):
            raise ValueError(f"{name!r}: write a name alone, as dray.example.com, or * for any")
    return several


def _token(secret: SecretStr | None) -> SecretStr | None:
    if secret is not None and not secret.get_secret_value().strip():
        raise ValueError("it is only blanks: write a secret, or leave it out")
    return secret


def _web_address(text: str) -> str:
    if not re.fullmatch(r"(https?://[^\s/]\S*)?", text) or not _has_port(text):
        raise ValueError("write it as http://127.0.0.1:4318/v1/traces")
    return text


def _public_url(text: str) -> str:
    if not re.fullmatch(r"(https?://[^\s/?#@]+)?/?", text) or not _has_port(text):
        raise ValueError("write it as https://dray.example.com, with no path")
    return text.rstrip("/")


def _broker(text: str) -> str:
    if re.fullmatch(r"(mqtts?://[^\s/@?#:\[\]]+(:\d{1,5})?)?", text) is None or not _has_port(text):
        raise ValueError(
            "write it as mqtt://HOST:1883, or mqtts://HOST:8883 for TLS; no name and password in it"
        )
    return text


def _topic(text: str) -> str:
    if re.search(r"[\s/+#$]", text):
        raise ValueError("it is one level of an MQTT topic: no blanks, no / + # or $")
    return text


def _several(text: object) -> object:
    return tuple(part.strip() for part in text.split(",") if part.strip()) if isinstance(text, str) else text


Several = Annotated[tuple[str, ...], NoDecode, BeforeValidator(_several)]
"""Several in one variable, with commas between."""

Addresses = Annotated[Several, AfterValidator(_addresses)]
"""Several of HOST:PORT, with commas between."""

Networks = Annotated[tuple[IPvAnyNetwork, ...], NoDecode, BeforeValidator(_several)]
"""Several networks as 10.8.0.0/16, with commas between."""


class Settings(Keeping):
    """One process's settings; immutable."""

    model_config = SettingsConfigDict(
        env_prefix=PREFIX, frozen=True, extra="ignore", env_ignore_empty=True, allow_inf_nan=False
    )

    database_url: Annotated[str, AfterValidator(_database_url)] = "sqlite+aiosqlite:///dray.db"
    """The default file lies in the working folder, so that an embedded start needs no server."""

    database_password: SecretStr | None = None
    """Inserted into the URL, so that the URL itself is no secret; best given as a file (see `SECRETS`)."""

    host: Annotated[str, Field(min_length=1), AfterValidator(_host)] = "127.0.0.1"
    """The default is this machine only, until somebody decides who else may reach the panels."""

    port: Annotated[int, Field(ge=0, le=65_535)] = 8000
    """TCP port; 0 lets the system choose one."""

    stop_port: Annotated[int | None, Field(ge=0, le=65_535)] = None
    """TCP port for stops alone, so that no other traffic fills it; by default the one after `port`, or any if that is taken."""

    stop_url: Annotated[str, AfterValidator(_public_url)] = ""
    """The address of that port for browsers, as https://dray.example.com:8444, behind a proxy. By default it is on the
    panel's own host, for pages that come by http."""

    public_url: Annotated[str, AfterValidator(_public_url)] = ""
    """The address of this gateway for people and customers, as https://dray.example.com: links to tracking pages begin
    with it. By default they begin with the address of the request."""

    allowed_hosts: Annotated[Several, AfterValidator(_host_names)] = ()
    """Accepted host names of requests, with commas, beside those of this machine, of `host` and of `public_url`; * for any.
    Numeric addresses are always allowed."""

    connections: Annotated[int, Field(ge=16, le=60_000)] = 512
    """Open connections at once, except for stops: more than twice the browsers of a large plant."""

    connections_each: Annotated[int, Field(ge=4, le=60_000)] = 128
    """Open connections per address, except for trusted proxies: twenty browser tabs. A tablet has two or three."""

    log_level: Literal["debug", "info", "warning", "error"] = "info"
    """The default suits a person who starts it by hand."""

    log_format: Literal["text", "json"] = "text"
    """`json`: one object in a line, with agents' facts by task and epoch; for programs, not for people."""

    trace_url: Annotated[str, AfterValidator(_web_address)] = ""
    """The receiver of traces (OTLP over HTTP), as http://127.0.0.1:4318/v1/traces; empty: no tracing."""

    trace_share_frac: Annotated[float, Field(ge=0, le=1)] = 1.0
    """The fraction of tasks that is traced, each of them wholly; a plant of hundreds of vehicles wants less."""

    metrics_listen: Annotated[str, AfterValidator(_address)] = ""
    """HOST:PORT of this process's Prometheus metrics, without login; empty: none. Port 0 takes any; the log names it."""

    admin_token: Annotated[SecretStr | None, AfterValidator(_token)] = None
    """The administrator's bearer token, which allows everything; `dray up` makes one when it is absent."""

    trusted_proxies: Networks = ()
    """Addresses or networks of proxies, with commas, whose X-Forwarded-For and X-Forwarded-Proto are believed. The default is none, because
    anybody could write these headers."""

    key_rate_hz: Annotated[float, Field(gt=0, le=10_000)] = 20.0
    """Requests per second that one API key may make for long: more than an ERP system places orders."""

    key_burst: Annotated[int, Field(ge=1, le=100_000)] = 200
    """Requests that one API key may make at once: a day's orders in one go."""

    body_limit_bytes: Annotated[int, Field(ge=1024, le=64 * 2**20)] = 2**20
    """1 MiB: the longest legitimate body, an order of 50 items, has some 10 kB."""

    command_timeout_s: Annotated[float, Field(gt=0, le=60)] = 3.0
    """Wall seconds to wait for a vehicle's answer: as long as a panel waits before it turns amber."""

    stream_rate_hz: Annotated[float, Field(gt=0, le=60)] = 10.0
    """Frames per wall second to browsers: motion is interpolated, so more frames would add only cost."""

    stream_queue_frames: Annotated[int, Field(ge=1, le=1024)] = 32
    """Frames queued for one slow browser: some three seconds; beyond that a fresh snapshot is cheaper."""

    stream_clients: Annotated[int, Field(ge=1, le=10_000)] = 200
    """Browsers at once: each one costs a queue, and a plant has some tens of panels."""

    stream_clients_each: Annotated[int, Field(ge=1, le=10_000)] = 16
    """Browsers at once per person, key or administrator: screens and tabs, without starving others."""

    historian_linger_s: Annotated[float, Field(ge=0, le=10)] = 0.2
    """Wall seconds for which events are gathered before one write: at most five syncs to disk per second."""
    shifts: Annotated[str, AfterValidator(checked_shifts)] = "early 06:00, late 14:00, night 22:00"
    """Names and start times of shifts, in the viewer's local time; each ends where the next one begins."""
    operator_names: Literal["code", "name"] = "code"
    """What the bus and colleagues are told of a person on duty: a code of the day, or the name."""

    gateway_name: Annotated[str, AfterValidator(_agent_name)] = "gateway"
    """The agent name on the bus; several gateways of one plant need a name each, and a certificate for it."""

    plant_file: Path | None = None
    """The plant file; None for the default plant of 12 machines and 8 vehicles."""

    strategists: Annotated[int, Field(ge=1, le=9)] = 1
    """Number of strategists that share the orders, each its own process: strategist, strategist2 and so on. Two survive the failure of
    one; each notes all orders, so more cost more. The same for all processes of a plant."""

    bus_listen: Addresses = ()
    """HOST:PORT, several with commas: where other agents reach this one. Without any, this agent only calls."""

    bus_peers: Addresses = ()
    """HOST:PORT, several with commas: the agents that this one calls. One reachable peer is enough: others relay."""

    bus_multicast: bool = False
    """Find other agents on the same network by multicast, which many factory networks block."""

    bus_certificates: Path | None = None
    """The folder with authority.pem and this agent's certificate and key (`dray certs`)."""

    bus_plain: bool = False
    """TCP without certificates: for an isolated network, and for experiments."""

    bus_lease_s: Annotated[float, Field(ge=0.2, le=60)] = 2.0
    """Seconds of silence after which traffic avoids a link: sooner than a silent vehicle is suspected (3.5 s)."""

    bus_apart: bool = False
    """Wired processes never reach one another over vehicles: ignore their messages on links with vehicles."""

    bus_radio: Networks = ()
    """Networks of the vehicles' own radio, as 10.8.0.0/16, several with commas. A vehicle whose links are all on these
    is without WLAN. By default every link counts as WLAN."""

    journal_folder: Path = Path("journals")
    """The folder of the agents' journals; in service it must outlive an update."""

    starts_again: bool = False
    """Whether a service manager restarts an agent that has left; then people may restart a machine's agent from a tablet."""

    leave_s: Annotated[float, Field(ge=0, le=3600)] = 330.0
    """Real seconds for an agent's graceful shutdown (SIGTERM); then it ends at once. A loaded vehicle needs up to 300 at
    real time. The service manager's timeout must be longer."""

    trusted_keys: Several = ()
    """Public keys of gateways in hex, several with commas: vehicles believe the grants that these keys signed."""

    traffic: bool = True
    """Vehicles occupy space, and drive with right of way. The same for all agents of a plant."""

    traffic_log: Path | None = None
    """The folder of the agents' right-of-way message logs, for later analysis."""

    body: Literal["floor", "vda5050", "controller", "opcua", "mqtt", "people"] = "floor"
    """Simulated, on a floor; a real vehicle by VDA 5050 (docs/vehicles.md); a station's or the gate's controller (docs/stations.md);
    the controller of a machine, a storage or the gate by OPC UA, by single values on topics, or people with a tablet (docs/machines.md)."""

    mapping: Path | None = None
    """The file that maps a controller's nodes or topics to signals, for a machine, a storage or the gate."""

    opcua_password: SecretStr | None = None
    """The password of the mapping's user; best given as a file (see `SECRETS`)."""

    foreign: Several = ()
    """Vehicles with their own bodies (`vda5050`) that work at places of a simulated floor, with commas. The floor counts
    the picks and drops that they report. The same for the floor and for their agents."""

    broker: Annotated[str, AfterValidator(_broker)] = ""
    """The broker of a real body: mqtt://HOST:1883, or mqtts://HOST:8883 for TLS."""

    broker_user: str = ""
    """The agent's user name at the broker; empty for none."""

    broker_password: SecretStr | None = None
    """Best given as a file (see `SECRETS`)."""

    broker_authority: Path | None = None
    """The authority of the broker's certificate, as PEM; by default those that the computer trusts."""

    broker_certificate: Path | None = None
    """The agent's own certificate, as PEM, where the broker asks for one."""

    broker_key: Path | None = None
    """The key of that certificate; it may be in the same file."""

    manufacturer: Annotated[str, AfterValidator(_topic)] = ""
    """A real vehicle's manufacturer, as its topics name it."""

    serial: Annotated[str, AfterValidator(_topic)] = ""
    """A real vehicle's serial number, as its topics name it."""

    profile: str = "default"
    """A real vehicle's profile: a file, or the name of one that is shipped."""

    vehicle_log: Path | None = None
    """The folder of a real vehicle's dialogue logs, for `dray vehicle replay`."""

    plant_speed: Annotated[float, Field(gt=0, le=50)] = 1.0
    """Factory seconds per real second; above 1 only with simulated bodies. The same for all agents."""

    plant_epoch_s: Annotated[float, Field(ge=0)] = 0.0
    """The unix time at which the plant's clock showed the same; matters when its speed is not 1."""

    @classmethod
    def load(cls, settings_file: Path | None = None, **options: object) -> Self:
        """Read the environment, and the files of `SECRETS`, which the environment overrides.

        Args:
            settings_file: lines like `DRAY_PORT=8000`; the environment overrides them.
            options: command line options that were given; None means not given.

        Raises:
            SettingsError: names the variable or option, and why it cannot be used.
        """
        if settings_file is not None:
            _check_file(settings_file)
        given = {name: value for name, value in options.items() if value is not None}
        # The settings library warns about a missing folder.
        secrets = {"_secrets_dir": SECRETS} if SECRETS.is_dir() else {}
        try:
            settings = cls(_env_file=settings_file, **given, **secrets)  # type: ignore[call-arg, arg-type]
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            field = str(first["loc"][0]) if first["loc"] else "settings"
            name = f"--{field.replace('_', '-')}" if field in given else f"{PREFIX}{field.upper()}"
            raise SettingsError(name, _reason(field, first)) from None
        password = settings.database_password
        if password is None:
            return settings
        url = _with_password(settings.database_url, password.get_secret_value())
        return settings.model_copy(update={"database_url": url})


def misspelt(settings_file: Path | None = None) -> dict[str, str]:
    """Variables that resemble settings or are former ones, each with the likely intended one.

    Other unknown variables may belong to another program or version.

    Args:
        settings_file: a file to check, too, which `Settings.load` has read.
    """
    names = set(os.environ)
    if settings_file is not None:
        names |= set(_NAMED.findall(settings_file.read_text(encoding="utf-8")))
    known = [f"{PREFIX}{field.upper()}" for field in Settings.model_fields]
    strangers = sorted(name for name in names if name.startswith(PREFIX) and name not in known)
    meant = {name: get_close_matches(name, known, 1, ALIKE) for name in strangers if name not in FORMER}
    former = {name: FORMER[name] for name in strangers if name in FORMER}
    by_option = {name: BY_OPTION[name] for name in strangers if name in BY_OPTION}
    return {name: matches[0] for name, matches in meant.items() if matches} | former | by_option


def _check_file(file: Path) -> None:
    if not file.is_file():
        raise SettingsError("--settings", f"there is no file {file}")
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise SettingsError("--settings", f"{file} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SettingsError("--settings", f"{file} is not UTF-8: save it as UTF-8") from None
    for number, line in enumerate(lines, 1):
        if not _LINE.fullmatch(line):
            raise SettingsError(
                "--settings", f"{file}:{number}: write a line as DRAY_PORT=8000, or # before it"
            )


def _with_password(url: str, password: str) -> str:
    scheme, _, rest = url.partition("://")
    account, at, place = rest.partition("@")
    user, mark, known = account.partition(":")
    # The process that started this one may have inserted the password already.
    if not at or (mark and unquote(known) != password):
        reason = "DRAY_DATABASE_URL must name a user and no password, as postgresql://user@host/name"
        raise SettingsError("DRAY_DATABASE_PASSWORD", reason)
    return f"{scheme}://{user}:{quote(password, safe='')}@{place}"


def _reason(field: str, error: ErrorDetails) -> str:
    """What was written and what is allowed; secrets are not shown."""
    said = _allowed(field, error)
    value = error.get("input")
    secret = field not in Settings.model_fields or "SecretStr" in str(Settings.model_fields[field].annotation)
    # A URL's name and password stand before an @.
    if secret or not isinstance(value, str | int | float) or "@" in str(value) or said.startswith("'"):
        return said
    shown = str(value)
    if len(shown) > SHOWN_CHARS:
        shown = f"{shown[:SHOWN_CHARS]}..."
    return f"{shown!r}: {said}"


def _allowed(field: str, error: ErrorDetails) -> str:
    kind = error["type"]
    if kind.startswith("bool"):
        return "write true or false"
    if kind == "literal_error":
        return f"write {error.get('ctx', {}).get('expected', 'another word')}"
    if kind == "ip_any_network":
        return "write an address or a network, as 10.8.0.1 or 10.8.0.0/16"
    if kind.startswith(("int", "float", "finite", "greater", "less")):
        metadata = Settings.model_fields[field].metadata
        limits = [
            text.format(f"{limit:.15g}")
            for name, text in _BOUNDS
            if (limit := next((getattr(each, name) for each in metadata if hasattr(each, name)), None))
            is not None
        ]
        whole = "whole " if "int" in str(Settings.model_fields[field].annotation) else ""
        return " ".join((f"write a {whole}number", " and ".join(limits))).rstrip()
    text = error["msg"].removeprefix("Value error, ")
    return text[:1].lower() + text[1:]
