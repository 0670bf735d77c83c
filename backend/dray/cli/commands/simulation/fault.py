"""`dray fault`: inject faults into a running `dray up`, and end them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from dray.cli.runtime.options import PanelUrl

if TYPE_CHECKING:
    from dray.cli.simulation.gateway_client import Fault, Kind

app = typer.Typer(no_args_is_help=True, help="Let something go wrong in a running `dray up`.")

Token = Annotated[
    str | None,
    typer.Option(help="The token that `dray up` prints, or a key with faults:write; else DRAY_ADMIN_TOKEN."),
]

SUBJECTS = ("agent", "atv", "machine")
"""Fields that name a fault's subject; AGENT on the command line stands for the one of its kind."""


@app.callback()
def fault() -> None:
    """Inject faults into a running `dray up`."""


@app.command("list")
def list_faults(url: PanelUrl = None, token: Token = None) -> None:
    """List the injected faults, and the possible kinds."""
    from dray.cli.runtime.output import table
    from dray.cli.simulation.gateway_client import Gateway

    faults = Gateway(url, token).faults()
    if faults.items:
        rows = [
            (fault.id, fault.kind, ", ".join(fault.agents), _fields(fault.fault)) for fault in faults.items
        ]
        table(("id", "fault", "whom", "details"), rows)
    else:
        typer.echo("nothing is wrong by hand\n")
    kinds = [
        (kind.kind, " ".join((*kind.fields, *(f"({name})" for name in kind.optional))), kind.what)
        for kind in faults.kinds
    ]
    table(("kind", "fields", "what happens"), kinds)


@app.command()
def begin(
    kind: Annotated[
        str, typer.Argument(help="Its kind, as `dray fault list` names it; wlan-cut is read as wlan_cut.")
    ],
    agent: Annotated[str, typer.Argument(help="The vehicle, machine or other agent.")] = "",
    given: Annotated[
        list[str] | None, typer.Option("--set", help="Another field, as latency_s=2; may be repeated.")
    ] = None,
    url: PanelUrl = None,
    token: Token = None,
) -> None:
    """Inject a fault, until it is ended; prints its id, and on stderr whom it hits, with what, until when."""
    from dray.cli.simulation.gateway_client import Gateway

    gateway = Gateway(url, token)
    known = _kind(kind, gateway.faults().kinds)
    fault = {"kind": known.kind, **_subject(known, agent), **dict(map(_pair, given or ()))}
    begun = gateway.begin_fault(fault)
    typer.echo(begun.id)
    typer.echo(f"{_told(begun)} has begun, {_until(begun)}", err=True)


@app.command()
def end(
    fault: Annotated[str, typer.Argument(help="The id that `dray fault begin` has printed.")],
    url: PanelUrl = None,
    token: Token = None,
) -> None:
    """End a fault; says which one it was, whom it hit, and since when."""
    from datetime import UTC, datetime

    from dray.cli.simulation.gateway_client import Gateway

    ended = Gateway(url, token).end_fault(fault)
    typer.echo(
        f"{_told(ended)} has ended; it began at {datetime.fromtimestamp(ended.began_at_s, UTC):%H:%M:%S} UTC"
    )


def _told(fault: Fault) -> str:
    """A fault in one line: what, whom, and the details."""
    whom = f" of {', '.join(fault.agents)}" if fault.agents else ""
    details = _fields(fault.fault)
    return f"{fault.kind}{whom}" + (f" ({details})" if details else "")


def _until(fault: Fault) -> str:
    """How a fault ends."""
    from dray_sim.faults import Thing
    from dray_sim.faults.active import PERSON_STAYS_S

    by_hand = f"until `dray fault end {fault.id}`"
    if fault.fault.get("thing") == Thing.PERSON:
        return f"until the person goes on after {PERSON_STAYS_S:g} s of factory time, or {by_hand}"
    return by_hand


def _kind(name: str, kinds: tuple[Kind, ...]) -> Kind:
    """The kind of this name, in any spelling."""
    from dray.cli.runtime.output import one_of

    spelt = {_plain(kind.kind): kind for kind in kinds}
    return spelt.get(_plain(name)) or one_of({kind.kind: kind for kind in kinds}, name, "KIND")


def _plain(name: str) -> str:
    return name.replace("-", "").replace("_", "").lower()


def _subject(kind: Kind, agent: str) -> dict[str, str]:
    from dray.errors import SettingsError

    field = next((name for name in kind.fields if name in SUBJECTS), None)
    if field is None and agent:
        reason = f"{kind.kind} is about no single agent; give its fields with --set"
        raise SettingsError("AGENT", reason)
    if field is not None and not agent:
        raise SettingsError("AGENT", f"{kind.kind} needs one, as `dray fault begin {kind.kind} ATV3`")
    return {} if field is None else {field: agent}


def _pair(given: str) -> tuple[str, Any]:
    """A field and its value: JSON if it parses, otherwise text."""
    import msgspec

    from dray.errors import SettingsError

    name, equals, text = given.partition("=")
    if not (name and equals):
        raise SettingsError("--set", f"{given!r} is not of the form field=value")
    try:
        return name, msgspec.json.decode(text)
    except msgspec.DecodeError:
        return name, text


def _fields(fault: dict[str, Any]) -> str:
    return " ".join(
        f"{name}={value}" for name, value in fault.items() if name not in {"kind", *SUBJECTS} and value != ""
    )
