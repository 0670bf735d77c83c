"""`--traffic/--no-traffic`: the same option wherever something is run, and it wins over the setting."""

from __future__ import annotations

from typing import Any

import pytest
import typer

from dray.cli.commands import agent, fleet
from dray.cli.commands.simulation import sim
from dray.cli.commands.simulation.bench import bench
from dray.cli.commands.simulation.floor import floor
from dray.cli.commands.simulation.up import up
from dray.cli.runtime.options import right_of_way
from dray_sim.run.site import Site
from dray_sim.scenarios import SCENARIOS


def command_of(function: Any) -> Any:
    app = typer.Typer()
    app.command()(function)
    return typer.main.get_command(app)


def commands() -> dict[str, Any]:
    """Everything that lets vehicles drive."""
    found = {"up": up, "floor": floor, "bench": bench}
    alone = {name: command_of(function) for name, function in found.items()}
    for name, app, own in (
        ("agent", agent.app, ("atv", "machine", "station")),
        ("fleet", fleet.app, ("up",)),
        ("sim", sim.app, ("run", "report", "explore", "plants")),
    ):
        group: Any = typer.main.get_command(app)
        alone |= {f"{name} {each}": group.commands[each] for each in own}
    return alone


@pytest.mark.parametrize("command", commands().values(), ids=commands())
def test_whatever_runs_vehicles_has_the_same_option(command: Any) -> None:
    (option,) = [each for each in command.params if each.name == "traffic"]
    assert (option.opts, option.secondary_opts) == (["--traffic"], ["--no-traffic"])
    assert option.default is None


@pytest.mark.parametrize(
    ("option", "setting", "on"),
    [
        (None, "true", True),
        (None, "false", False),
        (True, "false", True),
        (False, "true", False),
    ],
)
def test_the_option_wins_over_the_setting(
    monkeypatch: pytest.MonkeyPatch, option: bool | None, setting: str, on: bool
) -> None:
    monkeypatch.setenv("DRAY_TRAFFIC", setting)
    assert right_of_way(option) is on


class Refuted:
    """A scenario that never holds, and remembers where it was played."""

    name, shows, source, moves = "refuted", "Nothing.", "ours", True

    def __init__(self) -> None:
        self.site = Site()

    def run(self, seed: int, site: Site) -> Any:
        self.site = site
        return type("Found", (), {"failure": "no", "describe": lambda _: "no"})()


@pytest.mark.parametrize("option", ["--traffic", "--no-traffic"])
def test_a_scenario_is_played_as_the_option_says_and_the_replay_says_it_too(
    call: Any, monkeypatch: pytest.MonkeyPatch, option: str
) -> None:
    refuted = Refuted()
    monkeypatch.setattr("dray_sim.scenarios.SCENARIOS", {**SCENARIOS, "refuted": refuted})
    code, _, err = call("sim", "run", "refuted", "--seed", "7", option)
    assert code == 1
    assert refuted.site.traffic is (option == "--traffic")
    assert f"replay: dray sim run refuted --seed 7 {option}\n" in err


def test_a_scenario_is_played_with_as_many_strategists_as_the_option_says(
    call: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    refuted = Refuted()
    monkeypatch.setattr("dray_sim.scenarios.SCENARIOS", {**SCENARIOS, "refuted": refuted})
    _, _, err = call("sim", "run", "refuted", "--strategists", "2")
    assert refuted.site.strategists == 2
    assert "refuted --seed 1 --strategists 2" in err
