"""`dray plant` and `dray sim run --plant`: what they print, write and refuse."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from fleet_runs import fleet_run
from msgspec.structs import replace
from typer.testing import CliRunner

from dray.cli import app
from dray.cli.runtime.plant_errors import tell_errors
from dray.errors import PlantError, PlantErrors, SettingsError, UnavailableError
from dray.plant import Door, Lane, LaneEnds, Node, Plant, load_plant, plant_yaml
from dray_sim.plants import fleet_sizes, many
from dray_sim.plants.fleet_sizes import Asked, FleetRun
from dray_sim.plants.play import Judgement, play_seed
from dray_sim.plants.run_file import RunFile

TINY_SHIFT = ("--hours", "0.3", "--load", "0.5")
SHORTEST_SHIFT = ("--hours", "0.1", "--load", "0.5")


def dray(*args: str, typed: str | None = None) -> tuple[int, str]:
    result = CliRunner().invoke(app, list(args), input=typed, catch_exceptions=True)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


# --- check -------------------------------------------------------------------------------------------


@pytest.fixture
def starving(tmp_path: Path) -> Path:
    """The workshop without its parking places, and with one vehicle more."""
    text = (load_text("workshop")).replace("  - {id: PARK1, node: park-1}\n", "")
    file = tmp_path / "starving.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def load_text(name: str) -> str:
    return files("dray.plant").joinpath(f"examples/{name}.yaml").read_text(encoding="utf-8")


def test_a_plant_without_warnings_is_summed_up_in_one_line() -> None:
    code, told = dray("plant", "check", "workshop", "--strict")
    assert (code, len(told.splitlines())) == (0, 1)
    assert told.startswith("workshop (Workshop): 3 machines")


def test_a_load_that_a_plant_cannot_serve_is_an_error_with_its_cause() -> None:
    assert dray("plant", "check", "workshop", "--load", "0.8")[0] == 0
    code, told = dray("plant", "check", "workshop", "--load", "0.95")
    assert code == 2
    assert "machines: error: machine: DRILL is full at 90.7% of the machines' time" in told
    assert "orders of 95.0% cannot be served" in told


def test_a_floor_on_which_vehicles_have_no_room_is_an_error(tmp_path: Path) -> None:
    file = load_plant("single-track").file
    nodes = (*file.nodes, Node("x1", 3, 38), Node("x2", 3.6, 38))
    tight = tmp_path / "tight.yaml"
    tight.write_text(
        plant_yaml(Plant(replace(file, nodes=nodes, lanes=(*file.lanes, Lane("x1", "x2", both_ways=True)))))
    )
    code, told = dray("plant", "check", str(tight))
    assert code == 2
    assert f"{tight}: nodes: error: near: x1 and x2 (0.60 m, 0.83 m needed)" in told


def test_a_plant_with_errors_is_played_all_the_same_and_they_are_named() -> None:
    code, told = dray("sim", "run", "day", "--plant", "workshop", "--load", "0.95", "--hours", "0.1")
    assert code == 0
    assert "dray: workshop is started, although `dray plant check` says that it cannot work as it is:" in told
    assert "  machines: error: machine: DRILL is full at 90.7% of the machines' time" in told
    assert "is started, although" not in dray("sim", "run", "day", "--plant", "workshop", "--hours", "0.1")[1]


def test_places_without_room_are_no_errors_without_right_of_way(capsys: pytest.CaptureFixture[str]) -> None:
    file = load_plant("single-track").file
    nodes = (*file.nodes, Node("x1", 3, 38), Node("x2", 3.6, 38))
    tight = Plant(replace(file, nodes=nodes, lanes=(*file.lanes, Lane("x1", "x2", both_ways=True))))
    tell_errors(tight, traffic=False)
    assert capsys.readouterr().err == ""
    tell_errors(tight, traffic=True)
    assert "nodes: error: near: x1 and x2 (0.60 m, 0.83 m needed)" in capsys.readouterr().err


def test_a_warning_leaves_the_exit_code_unless_strict(starving: Path, tmp_path: Path) -> None:
    starving.write_text(
        starving.read_text().replace("node: park-2}\n\nstations", "node: park-1}\n\nstations")
    )
    text = starving.read_text().replace(
        "  - {id: CART2, type: cart, node: park-2}",
        "  - {id: CART2, type: cart, node: park-2}\n  - {id: CART3, type: cart, node: saw}",
    )
    starving.write_text(text)
    code, told = dray("plant", "check", str(starving), "--json", str(tmp_path / "w.json"))
    assert code == 0
    assert (
        f"{starving}: parkings: warning: dwell_points: 2 dwell points (1 chargers, 1 parking places) for 3"
        in told
    )
    assert json.loads((tmp_path / "w.json").read_text())[0]["kind"] == "dwell_points"
    assert dray("plant", "check", str(starving), "--strict")[0] == 2


# --- draw --------------------------------------------------------------------------------------------


def test_a_picture_is_written_to_a_file_or_told(tmp_path: Path) -> None:
    file = tmp_path / "plant.svg"
    assert dray("plant", "draw", "two-halls", "-o", str(file)) == (0, "")
    ET.fromstring(file.read_text(encoding="utf-8"))
    assert dray("plant", "draw", "two-halls")[1] == file.read_text(encoding="utf-8")


# --- new ---------------------------------------------------------------------------------------------


def test_a_new_plant_by_options(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    code, told = dray("plant", "new", str(file), "--plant", "own", "--machines", "4", "--yes")
    assert code == 0, told
    plant = load_plant(file)
    assert (plant.id, len(plant.machines), len(plant.fleet)) == ("own", 4, 2)
    assert "dray up --plant" in told


def test_a_new_plant_by_questions_with_a_wrong_answer_in_between(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    answers = "my plant\nmine\nMine & <co>\nmany\n2\n3\n\n90\n\n"
    code, told = dray("plant", "new", str(file), typed=answers)
    assert code == 0, told
    plant = load_plant(file)
    assert (plant.id, plant.name) == ("mine", "Mine & <co>")
    assert (len(plant.machines), len(plant.fleet), len(plant.products)) == (2, 3, 2)
    assert plant.cycle_s("M1", "product-1") == 90.0


def test_a_file_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text("mine")
    with pytest.raises(SettingsError, match="is there already"):
        dray("plant", "new", str(file), "--yes")
    assert file.read_text() == "mine"
    assert dray("plant", "new", str(file), "--yes", "--force")[0] == 0


# --- sim run --plant ---------------------------------------------------------------------------------


def test_the_day_is_played_in_another_plant_under_another_load(tmp_path: Path) -> None:
    file = tmp_path / "report.json"
    code, told = dray("sim", "run", "day", "--plant", "workshop", *TINY_SHIFT, "--json", str(file))
    assert code == 0
    assert "verdict" in told
    report = json.loads(file.read_text())
    assert report["duration_s"] == pytest.approx(0.3 * 3600)
    assert report["invariants"] == "held"
    assert report.keys() >= FIELDS
    assert {each["name"] for each in report["verdict"]["resources"]} & {"SAW", "DRILL", "BENCH"}


FIELDS = {
    "on_time_frac",
    "orders_placed",
    "orders_delivered",
    "orders_due",
    "starvation_frac",
    "transport_p50_s",
    "transport_p95_s",
    "invariants",
    "verdict",
}


@pytest.mark.slow
def test_a_claim_is_played_in_another_plant_and_has_the_same_fields(tmp_path: Path) -> None:
    file = tmp_path / "report.json"
    dray("sim", "run", "loss-sweep", "--plant", "workshop", *SHORTEST_SHIFT, "--json", str(file))
    evidence = json.loads(file.read_text())
    assert evidence.keys() >= FIELDS
    assert "Played here with the plant workshop (Workshop), a load of 50%, 0.1 hours." in evidence["story"]


@pytest.mark.parametrize("name", ["case-1", "experiment-wlan", "soak"])
def test_a_scenario_about_certain_machines_says_that_it_stays_where_it_is(name: str) -> None:
    with pytest.raises(SettingsError, match="is played as it stands only"):
        dray("sim", "run", name, "--plant", "workshop")


def test_the_list_says_which_scenarios_take_another_plant() -> None:
    told = dray("sim", "list")[1]
    rows = {line.split()[0]: line for line in told.splitlines() if line.split()}
    assert " any " in rows["day"]
    assert " any " in rows["insider"]
    assert " its own " in rows["case-1"]


def test_a_plant_that_is_not_there_is_named() -> None:
    with pytest.raises(PlantError, match="there is no such file"):
        dray("sim", "run", "day", "--plant", "nowhere.yaml")


# --- sim plants --------------------------------------------------------------------------------------


def test_drawn_plants_are_played_judged_and_kept(tmp_path: Path) -> None:
    kept, judged = tmp_path / "r3.yaml", tmp_path / "judged.json"
    code, told = dray(
        "sim",
        "plants",
        "--seed",
        "3",
        "--small",
        "--hours",
        "0.3",
        "--write",
        str(kept),
        "--json",
        str(judged),
    )
    assert code == 0, told
    assert "1 plants: 1 served" in told
    assert load_plant(kept).id == "r3"
    [each] = json.loads(judged.read_text())
    assert each["replay"] == "dray sim plants --seed 3 --kind raster --small --hours 0.3 --traffic"


SHORT_PLANTS = ("--small", "--hours", "0.1", "--jobs", "1")


def test_a_run_over_many_plants_that_was_ended_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, judged = tmp_path / "kept.jsonl", tmp_path / "judged.json"
    asked = ("sim", "plants", "--first", "3", *SHORT_PLANTS, "--keep", str(kept))
    seeds: list[int] = []

    def play(seed: int, *args: object, **options: object) -> object:
        seeds.append(seed)
        return play_seed(seed, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(many, "play_seed", play)
    dray(*asked, "--count", "1")
    first = kept.read_text()
    assert first.count("\n") == 1
    kept.write_text(first + first[: len(first) // 2])
    _, told = dray(*asked, "--count", "2", "--json", str(judged))
    assert seeds == [3, 4]
    assert kept.read_text().startswith(first)
    torn = kept.read_text().splitlines()
    assert torn.pop(1) == first[: len(first) // 2]
    lines = [json.loads(line) for line in torn]
    assert [each["seed"] for each in lines] == [3, 4]
    assert json.loads(judged.read_text()) == lines
    orders = sum(each["orders"] for each in lines)
    assert told.splitlines()[-2].startswith("2 plants: ")
    assert f"of {orders} orders delivered, 0 plants with a broken invariant" in told
    dray(*asked, "--count", "2")
    assert seeds == [3, 4]


def test_a_kept_file_is_only_ever_appended_to(tmp_path: Path) -> None:
    kept = RunFile(tmp_path / "new/kept.jsonl", Judgement, "judgement of a plant")
    judgement = play_seed(3, "raster", small=True, hours=0.1, traffic=False)
    kept.add(judgement)
    # Another process has appended the same plant, and a third one was killed.
    path = tmp_path / "new/kept.jsonl"
    line = path.read_bytes()
    path.write_bytes(line + line + line[:40])
    assert RunFile(path, Judgement, "judgement of a plant").kept == [judgement, judgement]
    assert path.read_bytes() == line + line + line[:40] + b"\n"
    assert RunFile(path, Judgement, "judgement of a plant").kept == [judgement, judgement]


def test_a_run_that_is_stopped_by_hand_sums_up_and_says_that_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def play(seed: int, *args: object, **options: object) -> object:
        if seed == 4:
            raise KeyboardInterrupt
        return play_seed(seed, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(many, "play_seed", play)
    kept = tmp_path / "kept.jsonl"
    code, told = dray("sim", "plants", "--first", "3", "--count", "3", *SHORT_PLANTS, "--keep", str(kept))
    assert code == 1
    assert "stopped by hand; the same command goes on" in told
    assert "1 plants: " in told
    assert kept.read_text().count("\n") == 1


@pytest.mark.parametrize("text", ['{"seed":1,"mine":"x"}', '{"seed":1,"mine":"x"}\n'])
def test_another_file_with_seeds_is_left_as_it_is(tmp_path: Path, text: str) -> None:
    file = tmp_path / "mine.jsonl"
    file.write_text(text)
    with pytest.raises(SettingsError, match=r"line 1 of .* is no judgement"):
        RunFile(file, Judgement, "judgement of a plant")
    assert file.read_text() == text


def test_files_of_options_are_checked_before_plants_are_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(many, "play_seed", lambda *_, **__: pytest.fail("it was played"))
    (tmp_path / "file").write_text("")
    with pytest.raises(UnavailableError, match="choose another file for --json"):
        dray("sim", "plants", *SHORT_PLANTS, "--json", str(tmp_path / "no/judged.json"))
    with pytest.raises(UnavailableError, match="choose another file for --keep"):
        dray("sim", "plants", *SHORT_PLANTS, "--keep", str(tmp_path / "file/kept.jsonl"))
    with pytest.raises(SettingsError, match="--write: writes the plant of one seed"):
        dray("sim", "plants", *SHORT_PLANTS, "--write", str(tmp_path / "r.yaml"))


def test_a_file_that_holds_something_else_is_left_as_it_is(tmp_path: Path) -> None:
    file = tmp_path / "mine.txt"
    file.write_text("mine\n")
    with pytest.raises(SettingsError, match=r"line 1 of .* is no judgement"):
        dray("sim", "plants", *SHORT_PLANTS, "--keep", str(file))
    assert file.read_text() == "mine\n"
    file.write_text("mine without an end")
    with pytest.raises(SettingsError, match=r"line 1 of .* is no judgement"):
        dray("sim", "plants", *SHORT_PLANTS, "--keep", str(file))
    assert file.read_text() == "mine without an end"
    with pytest.raises(UnavailableError, match="choose another file for --keep"):
        dray("sim", "plants", *SHORT_PLANTS, "--keep", str(tmp_path))
    with pytest.raises(SettingsError, match="for many runs"):
        dray("sim", "plants", "--seed", "3", "--keep", str(file))
    file.write_text('{"seed":3}\n')
    with pytest.raises(SettingsError, match=r"line 1 of .* is no run of a fleet"):
        dray("sim", "plants", "--seed", "3", "--vehicles", "2", "--keep", str(file))


def test_fleets_of_several_sizes_are_compared_on_one_floor_with_the_same_seeds(tmp_path: Path) -> None:
    rows = tmp_path / "sizes.json"
    asked = ("--small", "--hours", "0.25", "--vehicles", "4,1", "--runs", "2", "--jobs", "1")
    code, told = dray("sim", "plants", "--seed", "3", *asked, "--json", str(rows))
    assert code == 0, told
    one, four = json.loads(rows.read_text())
    assert (one["vehicles"], four["vehicles"]) == (1, 4)
    assert [run["seed"] for run in one["runs"]] == [run["seed"] for run in four["runs"]] == [1, 2]
    assert one["transports"] < four["transports"]
    assert one["fall"] is None
    assert four["fall"]["vehicles"] == 1
    assert len(told.splitlines()) == 4
    assert told.splitlines()[-1].startswith("raster 3 small: 0 fleets fall by more than 5 %, ")


def test_a_comparison_of_fleets_that_was_ended_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "fleets.jsonl"
    made: list[tuple[int, int]] = []

    def play(asked: Asked) -> FleetRun:
        made.append((asked.vehicles, asked.seed))
        return fleet_run(asked, transports=10 * asked.vehicles)

    monkeypatch.setattr(fleet_sizes, "play_run", play)
    asked = ("sim", "plants", "--plant", "workshop", "--jobs", "1", "--keep", str(kept), "--vehicles")
    dray(*asked, "1", "--runs", "2")
    first = kept.read_text()
    kept.write_text(first + first[: len(first) // 4])
    _, told = dray(*asked, "1,2", "--runs", "3")
    assert made == [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)]
    assert kept.read_text().startswith(first)
    assert kept.read_text().count("\n") == 7, "six runs, and the torn line"
    assert "plant workshop: 0 fleets fall by more than 5 %, 1 hold, 0 open" in told
    dray(*asked, "1,2", "--runs", "3")
    assert len(made) == 6
    dray(*asked, "1", "--runs", "1", "--hours", "0.5")
    assert len(made) == 7


def test_the_floor_of_a_fleet_is_a_plant_or_a_seed() -> None:
    with pytest.raises(SettingsError, match="the floor of --vehicles"):
        dray("sim", "plants", "--plant", "workshop")
    with pytest.raises(SettingsError, match="without --seed"):
        dray("sim", "plants", "--plant", "workshop", "--seed", "3", "--vehicles", "2")


@pytest.mark.parametrize("sizes", ["0,4", "2,,4", "many"])
def test_sizes_of_fleets_that_are_none_are_refused(sizes: str) -> None:
    with pytest.raises(SettingsError, match="no list of numbers"):
        dray("sim", "plants", "--seed", "3", "--vehicles", sizes)


# --- layouts of other systems -------------------------------------------------------------------------


def test_an_export_says_which_doors_are_left_out(tmp_path: Path) -> None:
    file = tmp_path / "doors.yaml"
    door = Door("GATE", "Gate", (LaneEnds("c2", "c3"),), 8.0)
    file.write_text(plant_yaml(Plant(replace(load_plant("default").file, doors=(door,)))), encoding="utf-8")
    code, told = dray("plant", "export", str(file), "--lif", "-o", str(tmp_path / "doors.json"))
    assert code == 0
    assert "left out: GATE: LIF knows no doors" in told


def test_a_layout_is_exported_imported_checked_and_drawn(tmp_path: Path) -> None:
    exported, plant, picture = (tmp_path / name for name in ("hall.json", "hall.yaml", "hall.svg"))
    assert dray("plant", "export", "workshop", "--lif", "-o", str(exported))[0] == 0
    told = dray("plant", "import", str(exported))[1]
    points = [line.strip() for line in told.partition("open points")[2].splitlines()[1:]]
    mapping = json.loads((tmp_path / "hall.mapping.json").read_text(encoding="utf-8"))
    assert mapping["format"] == "LIF 1.0.0"
    newer = str(tmp_path / "newer.json")
    assert dray("plant", "export", "workshop", "--lif", "--lif-version", "2.0.0", "-o", newer)[0] == 0
    assert json.loads((tmp_path / "newer.json").read_text(encoding="utf-8"))["origins"]
    with pytest.raises(SettingsError, match=r"3 is none of 1\.0\.0, 2\.0\.0"):
        dray("plant", "export", "workshop", "--lif", "--lif-version", "3")
    with pytest.raises(PlantErrors) as raised:
        dray("plant", "check", str(plant))
    assert sorted(f"{error.field}: {error.reason}" for error in raised.value.errors) == sorted(points)
    assert dray("plant", "draw", str(plant), "-o", str(picture))[0] == 0
    assert ET.parse(picture).getroot().tag.endswith("svg")
    assert dray("plant", "import", str(exported), "--onto", "workshop", "--force")[0] == 0
    assert load_plant(plant).file == load_plant("workshop").file


def test_a_plant_file_is_not_imported_but_said_to_be_one(tmp_path: Path) -> None:
    file = tmp_path / "plant.yaml"
    file.write_text(load_text("workshop"), encoding="utf-8")
    with pytest.raises(
        SettingsError, match=r"^FILE: .*plant.yaml is a plant file already: `dray plant check"
    ) as raised:
        dray("plant", "import", str(file))
    assert f"`dray up --plant {file}`" in str(raised.value)


def test_an_import_writes_over_nothing_and_says_what_is_wrong(tmp_path: Path) -> None:
    file, plant = tmp_path / "hall.json", tmp_path / "hall.yaml"
    file.write_text("{}", encoding="utf-8")
    with pytest.raises(PlantError, match="no LIF file"):
        dray("plant", "import", str(file))
    plant.write_text("mine", encoding="utf-8")
    with pytest.raises(SettingsError, match="is there already"):
        dray("plant", "import", str(file))
    assert plant.read_text(encoding="utf-8") == "mine"
    for args, why in ((("--unit", "yard"), "yard is none of"), (("--plant", "1"), "a letter first")):
        with pytest.raises(SettingsError, match=why):
            dray("plant", "import", str(file), *args)
    with pytest.raises(SettingsError, match="cannot be read"):
        dray("plant", "import", str(tmp_path / "none.json"))
