"""Reading a plant file: what is wrong is named by file, line and field."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.errors import PlantError, PlantErrors
from dray.plant import default_plant, load_plant, parse_plant, plant_yaml, sum_up
from dray.plant.file.file import MAX_BYTES, MAX_FAULTS

Break = Callable[..., list[tuple[str, str]]]


def error_of(text: str) -> PlantError:
    with pytest.raises(PlantError) as raised:
        parse_plant(text, "plant.yaml")
    return raised.value


# --- golden messages: what a person reads ------------------------------------------------------------


def test_a_wrong_shape_is_named_by_line_and_field(small_text: str) -> None:
    text = small_text.replace("cycle_s: 30", "cycle_s: fast")
    assert str(error_of(text)) == "plant.yaml:41: machines[0].makes[0].cycle_s: expected `float`, got `str`"


@pytest.mark.parametrize("turns", ["\u202e", "\u2066", "\x07"])
def test_a_name_that_reads_as_another_one_is_refused(small_text: str, turns: str) -> None:
    line = next(each for each in small_text.splitlines() if each.strip().startswith(("name:", "- name:")))
    name = line.partition("name: ")[2]
    escaped = turns.encode("unicode_escape").decode()
    error = error_of(small_text.replace(f"name: {name}", f'name: "Hall{escaped}A"', 1))
    assert error.field.endswith("name")
    assert "holds a character that cannot be seen or turns text round" in error.reason


def test_a_missing_field_is_named_by_the_line_of_its_entry(small_text: str) -> None:
    text = small_text.replace("    station: WS1\n", "")
    assert str(error_of(text)) == "plant.yaml:36: machines[0]: `station` is missing: add it"


def test_a_misspelt_field_is_named(small_text: str) -> None:
    text = small_text.replace("both_ways: true}\nmaterials", "both_way: true}\nmaterials")
    assert (
        str(error_of(text)) == "plant.yaml:15: lanes[3]: `both_way` is no field of this: check its spelling"
    )


def test_an_unknown_name_is_named_with_advice(small_text: str) -> None:
    text = small_text.replace("node: north", "node: nort")
    assert (
        str(error_of(text))
        == "plant.yaml:39: machines[0].node: there is no nort in `nodes`: did you mean north?"
    )


def test_several_faults_are_one_line_each(small_text: str) -> None:
    text = small_text.replace("node: north", "node: nort").replace("type: light", "type: lihgt")
    assert str(error_of(text)) == (
        "plant.yaml:39: machines[0].node: there is no nort in `nodes`: did you mean north?\n"
        "plant.yaml:49: fleet[0].type: there is no lihgt in `vehicle_types`: did you mean light?"
    )


def test_broken_yaml_is_named_by_line(small_text: str) -> None:
    error = error_of(
        small_text.replace("stocks: [{material: shaft, capacity: 100}]", "stocks: [{material: shaft")
    )
    assert str(error).startswith("plant.yaml:29: not YAML: while parsing a flow")


# --- shapes ------------------------------------------------------------------------------------------


def test_wrong_shapes_in_several_entries_are_all_reported(small_text: str) -> None:
    text = small_text.replace("x_m: 35,", "x_m: far,").replace("cycle_s: 30", "cycle_s: -1")
    error = error_of(text)
    assert isinstance(error, PlantErrors)
    assert [single.field for single in error.errors] == ["nodes[2].x_m", "machines[0].makes[0].cycle_s"]


def test_a_missing_section_is_reported_beside_wrong_shapes(small_text: str) -> None:
    text = small_text.replace("fleet:\n  - {id: ATV1, type: light, node: middle}\n", "").replace(
        "x_m: 35,", "x_m: far,"
    )
    error = error_of(text)
    assert isinstance(error, PlantErrors)
    assert {single.field for single in error.errors} == {"", "nodes[2].x_m"}
    assert "`fleet` is missing: add it" in str(error)


def test_an_unknown_section_is_reported(small_text: str) -> None:
    error = error_of(small_text + "robots: []\n")
    assert str(error) == "plant.yaml:50: robots: there is no such section: check its spelling"


def test_a_section_that_is_no_list_is_reported(small_text: str) -> None:
    text = small_text.replace("fleet:\n  - {id: ATV1, type: light, node: middle}\n", "fleet: none\n")
    assert error_of(text).field == "fleet"


def test_an_empty_section_is_reported(small_text: str) -> None:
    text = small_text.replace("fleet:\n  - {id: ATV1, type: light, node: middle}\n", "fleet: []\n")
    assert error_of(text).field == "fleet"


@pytest.mark.parametrize("name", ["1st", "a/b", "a b", "*", "", "x" * 33, "é"])
def test_an_id_that_is_no_chunk_of_a_bus_key_is_refused(small_text: str, name: str) -> None:
    error = error_of(small_text.replace("plant: small", f"plant: '{name}'"))
    assert error.field == "plant"


@pytest.mark.parametrize("value", [".nan", ".inf", "-.inf", "1.0e+999"])
def test_a_number_that_is_no_measure_is_refused(small_text: str, value: str) -> None:
    error = error_of(small_text.replace("x_m: 35,", f"x_m: {value},"))
    assert (error.field, error.line) == ("nodes[2].x_m", 8)


@pytest.mark.parametrize("digits", [20, 400, 5000])
def test_a_whole_number_beyond_all_bounds_is_refused(small_text: str, digits: int) -> None:
    error = error_of(small_text.replace("x_m: 35,", f"x_m: {'9' * digits},"))
    assert error.field.startswith("nodes[2]")


def test_very_many_faults_are_cut_off(small_text: str) -> None:
    entries = "".join(f"  - {{id: n{k}, x_m: -1, y_m: 1}}\n" for k in range(MAX_FAULTS + 1))
    error = error_of(small_text.replace("lanes:\n", f"{entries}lanes:\n"))
    assert isinstance(error, PlantErrors)
    assert len(error.errors) == MAX_FAULTS + 1
    assert error.errors[-1].reason == "and more faults: correct these first"


# --- documents ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["", "\n\n", "# nothing\n", "---\n"])
def test_an_empty_file_is_refused(text: str) -> None:
    assert error_of(text).reason.startswith("is empty")


@pytest.mark.parametrize("text", ["- a\n- b\n", "plant", "42"])
def test_a_file_that_is_no_mapping_is_refused(text: str) -> None:
    assert error_of(text).reason.startswith("is no mapping")


def test_a_key_given_twice_is_refused(small_text: str) -> None:
    error = error_of(small_text.replace("width_m: 40\n", "width_m: 40\nwidth_m: 50\n"))
    assert str(error) == "plant.yaml:4: width_m: given twice, first in line 3: keep one"


def test_aliases_are_refused(small_text: str) -> None:
    error = error_of(
        small_text.replace("name: Small plant", "name: &name Small plant").replace(
            "name: Shaft", "name: *name"
        )
    )
    assert (error.field, error.line) == ("materials[0].name", 17)
    assert "aliases" in error.reason


def test_a_few_lines_of_aliases_do_not_become_gigabytes() -> None:
    bomb = "a0: &a0 [x, x]\n" + "".join(f"a{k}: &a{k} [*a{k - 1}, *a{k - 1}]\n" for k in range(1, 40))
    assert "aliases" in error_of(bomb).reason


def test_a_list_inside_of_itself_is_refused() -> None:
    assert "aliases" in error_of("plant: &all [*all]").reason


@pytest.mark.parametrize("nest", ["[" * 100_000, "{a: " * 100_000, "- " * 5_000 + "x"])
def test_bottomless_nesting_is_refused(nest: str) -> None:
    assert "nested more than" in error_of(f"plant:\n  {nest}").reason


@pytest.mark.parametrize(
    "tagged", ["!!python/object:os.system x", "!!binary aGk=", "!mine x", "!!set {a, b}"]
)
def test_tags_are_refused(tagged: str) -> None:
    error = error_of(f"plant: {tagged}\n")
    assert error.field == "plant"
    assert "tag" in error.reason


def test_a_second_document_is_refused(small_text: str) -> None:
    assert "second document" in error_of(f"{small_text}---\n{small_text}").reason


def test_a_key_that_is_a_list_is_refused() -> None:
    assert "key must be plain text" in error_of("[a, b]: c\n").reason


def test_a_control_character_is_refused() -> None:
    assert error_of("plant: a\x07b\n").reason.startswith("not YAML")


def test_a_name_that_looks_like_a_date_stays_text(small_text: str) -> None:
    plant = parse_plant(small_text.replace("name: Small plant", "name: 2026-01-31"), "plant.yaml")
    assert plant.name == "2026-01-31"


@settings(deadline=None)
@given(st.text(max_size=60))
def test_any_text_is_a_plant_or_a_plant_error(text: str) -> None:
    with pytest.raises(PlantError):
        parse_plant(text, "plant.yaml")


@pytest.mark.slow
@settings(deadline=None, max_examples=40)
@given(st.data())
def test_a_plant_with_a_piece_torn_out_is_a_plant_or_a_plant_error(data: st.DataObject) -> None:
    text = plant_yaml(default_plant())
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 200)))
    torn = text[:start] + text[end:]
    with contextlib.suppress(PlantError):
        parse_plant(torn, "plant.yaml")


# --- files -------------------------------------------------------------------------------------------


def test_a_file_is_read(tmp_path: Path, small_text: str) -> None:
    path = tmp_path / "plant.yaml"
    path.write_text(small_text, encoding="utf-8")
    assert load_plant(path) == load_plant(str(path))


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path: Path, small_text: str) -> None:
    path = tmp_path / "plant.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + small_text.replace("\n", "\r\n").encode())
    assert load_plant(path).id == "small"


def refusal(path: Path) -> str:
    with pytest.raises(PlantError) as raised:
        load_plant(path)
    assert raised.value.file == str(path)
    return raised.value.reason


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    assert refusal(tmp_path / "none.yaml").startswith("there is no such file: check the path")


def test_a_directory_is_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path) == "is a directory: name a file in it"


def test_a_path_through_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    assert refusal(tmp_path / "file" / "plant.yaml").startswith("cannot be read")


def test_a_path_with_a_zero_byte_is_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path / "a\0b").startswith("cannot be read")


def test_bytes_that_are_not_utf8_are_refused_with_their_line(tmp_path: Path, small_text: str) -> None:
    path = tmp_path / "plant.yaml"
    path.write_bytes(small_text.encode().replace(b"Small plant", b"Gro\xdfes Werk"))
    with pytest.raises(PlantError) as raised:
        load_plant(path)
    assert (raised.value.line, raised.value.reason) == (2, "is not UTF-8: save it as UTF-8")


def test_a_file_of_many_megabytes_is_refused_without_being_parsed(tmp_path: Path) -> None:
    path = tmp_path / "huge.yaml"
    with path.open("wb") as stream:
        stream.truncate(MAX_BYTES + 1)
    assert refusal(path) == "has more than 8 MiB: this is no plant file"


def test_a_good_file_is_summed_up_in_one_line(tmp_path: Path, small_text: str) -> None:
    path = tmp_path / "plant.yaml"
    path.write_text(small_text, encoding="utf-8")
    assert sum_up(load_plant(path)) == (
        "small (Small plant): 1 machine in 1 station, 1 vehicle of 1 type, 1 product of 1 material, "
        "1 storage, 1 charger, 1 parking place, 5 nodes, 8 lanes of 106 m on 40 m x 30 m"
    )
