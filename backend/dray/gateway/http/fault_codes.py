"""Codes of faults in people's input: panels show each in the reader's language, REST in English.

Pydantic's own faults have codes here; our validators raise theirs as `PydanticCustomError` with the code as
its type.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from dray.plant.file.reasons import ITEM_TEXTS, Reason

TEXTS: Mapping[str, str] = {
    "file_needed": "give the file: its text in csv, or the file itself in base64; one of the two",
    "no_base64": "this is no base64",
    "csv_encoding": "its letters are in an encoding that is not read here; save it as CSV UTF-8",
    "csv_workbook": "this is a workbook of a spreadsheet program, not CSV; save it as CSV UTF-8",
    "csv_read_as": "it does not say its encoding and is not UTF-8: read as {encoding}; look at its letters, and save it as CSV UTF-8 where one is wrong",
    "csv_cell_too_long": "a cell has more than {most} characters; a quotation mark is missing, or this is no CSV",
    "csv_row_too_wide": "it has {count} cells, and there are {columns} columns; put a cell in which the separator stands into quotation marks",
    "csv_lost_character": "a character was lost before the file came here (it is \ufffd now); save the spreadsheet as CSV UTF-8 again",
    "csv_control_character": "there is a character in it that nobody can see; write it anew",
    "csv_cell_of_lines": "it goes over {count} lines; write it in one, or add the quotation mark that is missing",
    "csv_empty": "there is nothing in it; begin with {columns}",
    "csv_too_wide": "it has {count} columns; there are {columns}",
    "csv_too_many_rows": "a file has {most} rows at most; cut it in two",
    "placed_already": "{customer} has order {order} with this reference, placed {minutes} min ago; it would be a second one",
    "placed_twice": "{customer} has order {order} with this reference, too, placed {minutes} min ago; cancel one of both if it was sent twice",
    "in_file_already": "the order in row {row} has this customer and reference, too; it would be a second one: write its rows one after another to make them one",
    "csv_no_rows": "there is no row below the names of the columns",
    "column_missing": "this column is missing",
    "column_unnamed": "column {number} has cells and no name; name it, or remove it",
    "column_unknown": "there is no such column; there are {columns}",
    "column_twice": "this column is there more than once",
    "differs_in_order": "it is of the same order as row {row}; write the same",
    "too_many_items": "an order has {most} items at most",
    "not_made": "this plant does not make '{product}'; it makes {products}",
    "past": "it is past: here it is {now}; give a later time",
    "not_after_due": "it is to be there by {due}: name a time before that",
    "differs_in_product": "it is of the same product as row {row}; write the same",
    "bad_id": "letters, digits, _ . -, a letter first, at most 32",
    "begins_already": "{product} begins in row {row} already; write its rows one after another",
    "stands_already": "{name} stands in row {row} already",
    "machine_unknown": "there is no machine {machine}; there are {machines}",
    "machine_own_time": "{machine} says itself that a piece takes {seconds} s: leave it out, or write that",
    "no_machine": "no machine makes it: name one at least, with its seconds for a piece",
    "password_length": "a password has {least} to {most} characters; several words are good",
    "password_easy": "this password is too easy to guess: it repeats itself, or holds the name",
    "pin_digits": "a PIN has {least} to {most} digits and nothing else",
    "pin_easy": "this PIN is too easy to guess: its digits follow one another",
    "badge_length": "a badge's code has {least} to {most} characters, with no space around it",
    "badge_taken": "somebody else has this badge already",
    "name_taken": "there is a {name} already; nobody ever gets the name of another one",
    "login_name": "small letters, digits, . _ and -, a letter or digit first, at most 64",
    "area_needed": "an operator needs an area; there are {areas}",
    "area_unknown": "there is no area {area}; there are {areas}",
    "area_none": "a manager works everywhere; leave it out",
    "secret_of_other_role": "a manager logs in with a password, an operator with a PIN or a badge",
    "scope_needed": "name at least one thing that it may do",
    "calls_only": "only a key that may call for transports has this",
    "bound_above_all": "it is more than of all places together, {most}; give that or less",
    "place_unknown": "there is no machine or storage {place} in this plant",
    "place_needed": "name a place: to for what is brought, from for what is taken away",
    "place_not_keeping": "{place} does not keep {item}; it is kept at {places}",
    "no_other_storage": "no other storage keeps {item}; name a place",
    "same_place": "it is {place} already; name another place",
    "item_is_product": "{item} is a product: finished goods leave their machine by themselves",
    "material_unknown": "there is no material '{item}'; GET /api/materials lists them",
    "load_too_large": "one load of {item} is {most} at most; ask for several transports: {loads}",
    "thing_place": "name both places: nothing tells where a thing is",
    "thing_alone": "name an item or a thing, not both",
    "thing_is_one": "a thing is one: call for each",
    "thing_ability": "say what it is carried as: {abilities}",
    "not_your_area": "neither place is in your areas; one of them must be",
    "only_for": "this key calls for {place} only: it must be one of both places",
    "only_items": "this key calls for {items} only",
    "only_priority": "this key calls with {most} at the highest",
    "only_later": "this key calls with {most} at the highest: name no time before {soonest}",
    "key_full": "open calls of this key: {most}, and it may have no more; cancel one, or wait until one has ended",
    "key_full_at": "open calls of this key for {place}: {most}, and it may have no more; cancel one, or wait until one has ended",
    "share_used": "one caller may have {most}",
    "ability_unknown": "no vehicle that carries {carried} has {wanted}; they have {abilities}",
    "ability_nobody": "no vehicle of this plant carries {carried}",
    "vehicle_unknown": "there is no vehicle '{vehicle}'; GET /api/atvs lists them",
    "vehicle_lacks": "{vehicle} cannot carry this: it lacks {abilities}",
    "not_in_queue": "only orders that are in work stand in the queue; name one of those",
    "made_already": "{fewest} are made already; at least {fewest} are still possible",
    "zone_unknown": "there is no time zone '{zone}'; give its IANA name, as Europe/Berlin",
    "country_unknown": "there are no public holidays of '{country}'; give a country by two letters, as DE, or with its region, as DE-BW",
    "region_unknown": "there are no public holidays of a region '{region}' of {country}; give one of {regions}; or {country} alone",
    "region_none": "{country} has the same public holidays everywhere: give {country} alone",
    "cron_fields": "give five fields: minute, hour, day of the month, month, day of the week, as 0 6 * * MON-FRI",
    "cron_unreadable": "{why}; give cron's fields, as 0 6 * * MON-FRI",
    "no_run": "it is no coming moment of this calendar; the next one is {next}",
    "never": "no day is like that; give one that comes",
    "passed": "this time has passed: name a later one, or leave it out",
    "more_than_a_year": "that is more than a year from now: leave it out, and open it then",
    "more_than_a_week": "it is not within the next seven days; say when to ask again",
    "off_the_floor": "the floor ends at {width} m, {depth} m",
    "edges_cross": "its edges cross or lie on one another; name the corners in order around it",
    "closes_nothing": "no lane runs through it, so it would close nothing; draw it larger",
    "slow_speed": "say how fast vehicles may drive where it is slow",
    "one_way_lane": "only a lane can be one-way: name it",
    "one_way_already": "this lane is one-way already",
    "lane_runs": "the lane runs from {start} to {end} only",
    "node_unknown": "there is no node or place {place}; GET /api/plant has them",
    "in_crossing": "{node} lies in a crossing, where no vehicle stops; name another",
    "part_of_one": "give a part of 1, as 0.95",
    "needed_by_order": "orders that have not ended and need it: {count} ({names}); cancel them, or wait until they have ended",
    "needed_by_transport": "plain transports that have not ended and bring it: {count} ({names}); cancel them, or wait until they have ended",
    "needed_by_schedule": "recurring work that needs it: {count} ({names}); change or remove it",
    "needed_by_machine": "machines that have a goal for it, or make it by themselves: {count} ({names}); wait until it is made",
    "needed_by_product": "products of which it is a part: {count} ({names}); change or remove them, too",
    "definition_too_large": "with its bill, machines and documents it has {size} bytes, and goals carry {most}: name fewer, or shorter addresses",
}
"""Texts of our own faults, with values; other faults bring their own words."""

OF_PYDANTIC: Mapping[str, str] = {
    "missing": "missing",
    "string_too_short": "missing",
    "too_short": "missing",
    "string_too_long": "too_long",
    "too_long": "too_many",
    "string_pattern_mismatch": "pattern",
    "int_type": "whole_number",
    "int_parsing": "whole_number",
    "int_from_float": "whole_number",
    "float_type": "number",
    "float_parsing": "number",
    "finite_number": "number",
    "greater_than_equal": "at_least",
    "less_than_equal": "at_most",
    "enum": "one_of",
    "literal_error": "one_of",
    "bool_type": "yes_or_no",
}

WORDS: Mapping[str, str] = {
    "missing": "it is missing",
    "too_long": "it is longer than {most} characters",
    "too_many": "there are more than {most}",
    "whole_number": "it is no whole number; write digits only, as 12",
    "number": "it is no number",
    "at_least": "it is too small: {least} at least",
    "at_most": "it is too large: {most} at most",
    "one_of": "it is none of {choices}",
    "yes_or_no": "it is neither yes (true) nor no (false)",
}
"""English texts of pydantic's faults: the library's own sentences speak of types and patterns."""

NAME_RULE = "letters, digits, _ . -, a letter first, at most 32"

PATTERN_WORDS = (
    ("^https?://", "write an address that begins with http:// or https://, without spaces"),
    ("^[A-Za-z][A-Za-z0-9_.-]", NAME_RULE),
    ("^[A-Za-z0-9]", "write a kind of file, as application/pdf"),
    ("^[0-9a-f]", "write the SHA-256: 64 digits and small letters from a to f"),
    (r"^[^\x00-\x1f", "write one line of text, without control characters"),
)
"""Begin of a pattern, and its rule in words."""

OURS = frozenset(
    {
        "day_unreadable",
        "moment_text",
        "moment_unreadable",
        "moment_no_zone",
        "moment_off_calendar",
        "document_twice",
    }
)
"""Codes raised by our validators."""

CODES = frozenset(TEXTS) | frozenset(ITEM_TEXTS) | frozenset(OF_PYDANTIC.values()) | OURS


def text_of(code: str, values: Mapping[str, str]) -> str:
    """The English text of our own fault."""
    return TEXTS[code].format_map(values)


def coded(reason: str) -> tuple[str, str, dict[str, str]]:
    """A reason, its code and its values; code and values are empty for reasons that no product can have."""
    if not isinstance(reason, Reason) or reason.code not in ITEM_TEXTS:
        return str(reason), "", {}
    return str(reason), reason.code, {name: str(value) for name, value in reason.values.items()}


def words_of(fault: Mapping[str, Any]) -> str | None:
    """The English text of a pydantic fault; None if its kind has none here."""
    code, values = code_of(fault)
    if code == "pattern":
        pattern = str(fault.get("ctx", {}).get("pattern", ""))
        of_pattern = (words for begins, words in PATTERN_WORDS if pattern.startswith(begins))
        return next(of_pattern, "there are characters in it that may not stand here")
    return WORDS[code].format_map(values) if code in WORDS else None


def code_of(fault: Mapping[str, Any]) -> tuple[str, dict[str, str]]:
    """The code and values of a pydantic fault; empty if it has none."""
    kind = str(fault["type"])
    context = fault.get("ctx", {})
    code = kind if kind in OURS else OF_PYDANTIC.get(kind, "")
    match code:
        case "too_long" | "too_many":
            return code, {"most": str(context["max_length"])}
        case "at_least":
            return code, {"least": f"{context['ge']:g}"}
        case "at_most":
            return code, {"most": f"{context['le']:g}"}
        case "one_of":
            return code, {
                "choices": ", ".join(filter(None, re.findall(r"'([^']*)'", str(context["expected"]))))
            }
        case _:
            return code, {}
