"""Reasons of findings in plants, in English and by a code, so that panels tell them in other languages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import Any, Self

SHOWN = 3
"""Names of a list that are spelt out."""

ITEM_TEXTS: Mapping[str, str] = {
    "plant_unknown": "there is no {name} in `{section}`: {advice}",
    "plant_no_buffer": "{name} is a product without a `buffer`: say there how many pieces a machine holds that uses it",
    "plant_implausible": "{value} is not within {least} to {most}: check the unit",
    "plant_ability": "no vehicle of the fleet can carry {ability}: {item} would never move{needed}",
    "plant_lot": "a lot of {lot} does not fit into a buffer of {buffer}",
    "plant_not_stored": "no storage keeps {item}: add it to the `stocks` of one{needed}",
    "plant_not_made": "no machine makes {item}: add it to the `makes` of one{needed}",
    "plant_bill": "{count} pieces do not fit into the buffer of {buffer} for {item}",
    "plant_bill_and_lot": "a cycle's {count} and a lot of {lot} do not fit into the buffer of {buffer} together",
    "plant_goods": "{count} pieces are less than the lot of {lot} of {item}: raise it",
    "plant_twice": "{name} is in this list already: put both into one line",
    "plant_id_taken": "{name} is the id of {owner} already: choose another",
    "plant_circle": "{item} is made of itself: {chain}: take one of them out of a bill",
    "plant_own_part": "{machine} makes {part}, of which {item} is made: "
    "a machine does not use what it makes; let another one make one of both",
}
"""Texts by code, with placeholders: reasons that also apply to a product outside a plant file."""

PART_TEXTS: Mapping[str, str] = {
    "and": "{one} and {other}",
    "and_more": "{names} and {count} more",
    "from_to": "{start} to {end}",
    "at": "{name} at {place}",
    "from": "{name} from {place}",
    "or": "{one} or {other}",
    "pair_room": "{one} and {other} ({away_m:.2f} m, {needed_m:.2f} m needed)",
    "beside_lane": "{node} (from {start} to {end}, {short_m:.2f} m short)",
    "did_you_mean": "did you mean {name}?",
    "add_or_other": "add it there or name another",
    "needed_for": " (needed for {chain})",
    "reserved_agent": "an agent of every plant",
    "reserved_strategist": "an agent of a plant with several strategists",
    "reserved_certificate": "the name of a certificate of every plant",
    "on_map": " on map {map}",
    "none": "none",
    "also_for": ", also for {types}",
    "remove_some": ", of which you remove what is one with another",
    "stretched": ", times {times:.4g}, so that paths are as long as their `length`",
    "chargers_for": "{chargers} for {vehicles}",
    "chargers_one": "{count} charger",
    "chargers_many": "{count} chargers",
    "vehicles_one": "{count} vehicle",
    "vehicles_many": "{count} vehicles",
    "remedy_chargers": "write {count} chargers at least",
    "remedy_batteries": "batteries {times:.1f} times as large",
    "remedy_charge": "a higher `charge_w`, or fewer vehicles",
    "remedy_make": "let another machine make {product} too",
    "remedy_buffer": "a larger buffer for {item} than {buffer} pieces, or a storage nearer by",
    "remedy_goods": "a larger goods_capacity than {room} pieces, or a delivery nearer by",
    "remedy_dock": "larger lots, quicker handling, or another place that shares the work",
    "remedy_material": "more than {kept} pieces of it in storages, or another storage that keeps it",
    "remedy_vehicles": "{count} more, or larger lots",
    "remedy_more": "{count} more",
    "that_carry": "{count} that carry {abilities}",
    "waits_on_roads": "{count} without work wait on the roads",
    "waits_reserve": "{count} are a reserve, which takes no work that others can do",
    "waits_in_way": "{count} wait in somebody's way",
    "waits_nowhere": "{count} find no place that is not before a dock: the floor bears {most} vehicles at most",
    "add_parking": "add {count} parking place",
    "add_parkings": "add {count} parking places",
    "or_away": ", or take {count} vehicle away",
    "or_away_many": ", or take {count} vehicles away",
    "others_one": "{count} other",
    "others_many": "{count} others",
    "too_large": "; with {length_m:g} m x {width_m:g} m it is larger than `max_vehicle` of {nodes} allows",
    "hint": "write a value",
    "hint_areas": "the parts of the floor that operators are responsible for, or [] for none",
    "hint_battery_wh": "watt-hours of a full battery, from the data sheet",
    "hint_box": "where it stands on the floor: its middle, its width and its depth",
    "hint_chargers": "where vehicles charge: id, node and box of each",
    "hint_charge_w": "watts while it charges, from the data sheet",
    "hint_doors": "the doors that open by themselves, or [] for none",
    "hint_fleet": "the vehicles: id, type and the node where each stands at the beginning",
    "hint_kind": "source or delivery",
    "hint_length_m": "of the vehicle with its load",
    "hint_load_s": "seconds that loading takes",
    "hint_machines": "what makes products: id, name, station, node, box and makes of each",
    "hint_makes": "the products that it makes, and the cycle of each",
    "hint_materials": "what machines consume: id, name, lot and buffer of each",
    "hint_max_speed_mps": "metres in a second, from the data sheet",
    "hint_node": "where vehicles stand: a node of this file",
    "hint_opening_s": "seconds from shut to open",
    "hint_products": "what machines make: id, name, lot and bill of each",
    "hint_stations": "groups of machines: id and name of each",
    "hint_stocks": "the materials that it keeps, and the capacity of each",
    "hint_storages": "where material waits near the machines: id, name, node, box and stocks of each",
    "hint_unload_s": "seconds that unloading takes",
    "hint_vehicle_types": "the makes of vehicles: id and name of each, and what differs from the defaults",
    "hint_warehouses": "where material comes from and goods go to: id, name, kind, node and box of each",
    "hint_width_m": "of the vehicle with its load",
}
"""Parts of other reasons."""

SHAPE_TEXTS: Mapping[str, str] = {
    "open": "is open: {hint}",
    "unassigned": "nobody has said what {name} at {node} is: move it to machines, storages, warehouses, chargers or parkings, or remove it",
    "missing": "`{name}` is missing: add it",
    "unknown_field": "`{name}` is no field of this: check its spelling",
    "no_such_section": "there is no such section: check its spelling",
    "no_such_field": "there is no such field here: check its spelling",
    "is_empty": "is empty: write at least one entry",
    "unseen": "holds a character that cannot be seen or turns text round, as U+202E does: write it anew",
    "other_kind": "expected `{wanted}`, got `{got}`",
    "bounds": "expected `{wanted}` {bound}",
    "pattern": "expected `str` matching regex {regex}",
    "none_of_these": "invalid enum value {value}",
    "misfit": "{words}",
}
"""Faults of an entry's shape, and open values."""

FAULT_TEXTS: Mapping[str, str] = {
    "id_reserved": "{name} is {taken}: choose another",
    "type_twice": "{type} is named twice: keep one of the two",
    "threshold": "{high:g} is not {least:g} above `{field}`, which is {low:g}: raise this one or lower that one",
    "quiet_hours": "begin and end at {hour:g}: write 0 and 24 for the whole day",
    "no_source": "there is none of kind source: material comes from nowhere",
    "no_delivery": "there is none of kind delivery: products go nowhere",
    "door_no_lane": "no lane joins {start} and {end}: draw it, or name another",
    "door_named": "the lane from {start} to {end} is named already: keep one of the two",
    "door_named_both": "the lane from {start} to {end} is named already: both directions are shut together: keep one of the two",
    "door_owned": "{owner} stands on the lane from {start} to {end} already: keep one of the two",
    "door_bent": "a door stands on a straight lane: divide this one at a node",
    "door_short_road": "the road from {start} to {end} is too short for a vehicle to stop before and after a door: "
    "make it longer, or say `two_lanes: false` of it",
    "door_at_crossing": "nobody can wait at {node}, which is a crossing: put a node between it and the door",
    "door_no_room": "{start} and {end} are {away_m:.2f} m apart: whoever turns there needs {needed_m:.2f} m, with the door between them",
    "door_in_way": "{door} is in the way from {start} to {end}, too: name that lane here, or move it away",
    "floor_side": "{side_m:g} m are more than {most_m:g} m: write metres",
    "floor_cells": "makes {count} grid cells, more than {most}: take larger ones",
    "outside": "({x_m:g}, {y_m:g}) is outside of the floor of {width_m:g} m x {height_m:g} m",
    "box_outside": "reaches beyond the floor of {width_m:g} m x {height_m:g} m: x and y are its middle",
    "lane_to_itself": "the lane joins {node} with itself: name another node",
    "nodes_on_one_spot": "{start} and {end} are {away_m:g} m apart: make them one node",
    "lane_twice": "{first} leads from {start} to {end} already: remove one of them",
    "two_lanes_shape": "a lane with a shape is single track: leave this out, or draw two one-way lanes",
    "two_lanes_one_way": "the lane runs one way: add `both_ways: true`, or leave this out",
    "two_lanes_dock": "vehicles dock at {node}: give the dock a spur off this road, or leave this out",
    "name_of_stop": "{node} is the name of a stop point: choose another",
    "corners_near": "two corners are less than {least_m:g} m apart: leave one out",
    "name_of_corner": "{node} is the name of a corner of a lane: choose another",
    "starts_in_crossing": "{node} is a crossing, where nobody stands: name a parking place or a stop point, as {example}",
    "stands_there": "{vehicle} stands at {node} already",
    "not_reached": "{name} cannot be reached: no lanes lead from {start} to {end}",
    "not_left": "{name} cannot be left: no lanes lead from {start} to {end}",
    "type_cut_off": "{type} cannot get to {names} and back on lanes that are for it: "
    "name it in the `types` of lanes that lead there{large}",
    "too_many_corners": "{count} corners are more than {most}: draw it more simply",
    "corner_twice": "the corner before it is the same: remove one, the polygon closes itself",
    "edges_cross": "the edges from corner {one} and from corner {other} cross: order the corners",
    "encloses_nothing": "it encloses nothing: give at least three corners that are not in one line",
    "stock_small": "{count} pieces are less than a lot of {lot}",
    "delivery_stocks": "nothing is fetched from a warehouse that products go to: leave it out",
    "direct_nothing": "{warehouse} has no `stocks`: say what machines fetch there",
    "part_in_warehouse": "{item} is made here and comes from nowhere else: keep it in a storage",
    "no_source_of": "no source warehouse has {item}: add it to the `stocks` of one, for vehicles to fetch it",
    "lot_large": "{lot} pieces are more than a vehicle brings at once: a container holds {most}",
    "reorder_high": "above {point} there is no room for {lot} more, of {capacity}: lower it to {most} at most",
    "stock_unused": "it means something for materials of a storage with `refill: vehicles` only",
    "time_zone": "{zone} is no time zone that is known: write its IANA name, as Europe/Berlin",
    "no_day": "{day} is no day of any year: write one as 2026-12-25",
    "breaks": "they leave nothing of its shifts: make them shorter",
    "original_twice": "vehicles call {node} {name}, too{map}: write what they call this one",
    "original_back": "nobody drives back on a lane without `both_ways`: leave it out, or add that",
    "map_empty": "is empty, and there are several maps: write the vehicles' `mapId`",
    "map_twice": "{map} is there twice: a map has one place in the plant",
    "no_map": "there is no map {map} in `maps` ({known}): add it there",
    "idle_energy": "{chargers}: without any work they use {times:.1f} times what can be charged, and run flat: "
    "write {count} chargers at least, a lower `idle_w`, or fewer vehicles",
    "charger_wait": "{chargers}: {type} may wait {wait_s:.0f} s while others charge, and its battery does not last for that, "
    "the way and some work: {remedy}",
}
"""Contradictions in a plant file."""

ADVICE_TEXTS: Mapping[str, str] = {
    "asked_load": "{text}; orders of {load_pct:.1f}% cannot be served",
    "dwell_points": "{places} dwell points ({chargers} chargers, {parkings} parking places) for {vehicles} "
    "vehicles: {waits}; {add}{away}",
    "uncounted": "{count} of {machines} machines do not count what vehicles bring and take "
    "({names}): their word is believed there; give the docks a counter",
    "large": "{type} is {length_m:g} m x {width_m:g} m with its load, and does not come to "
    "{nodes}, where `max_vehicle` is smaller: its ways lead round them",
    "range": "one transport of {item} from {source} to {destination} takes "
    "{takes_pct:.0f}% of a battery of which {usable_pct:.0f}% can be used: a larger battery, or shorter ways",
    "range_never": "no vehicle ever carries {item} from {source} to {destination}: with the way from a charger, and what must be "
    "left for the way back and the queue there, it takes {takes_pct:.0f}% of a full battery: a larger battery, or shorter ways",
    "charger_queue": "{chargers} for {vehicles} vehicles: {type} stops working with {left_pct:.0f}% "
    "left, for it may wait {wait_s:.0f} s while {ahead} charge; more chargers, or a larger battery",
    "limit_no_energy": "{name}: they use more than can be charged, without any work; {remedy}",
    "limit_machine": "{name} is full at {load_pct:.1f}% of the machines' time if all products are ordered equally often: {remedy}",
    "limit_buffer": "{name} lasts less than a transport takes, full at {load_pct:.1f}% of the machines' time: {remedy}",
    "limit_dock": "vehicles at {name} need {asks:.1f} times the time that there is, full at {load_pct:.1f}% of the machines' time: {remedy}",
    "limit_material": "{name} is used {asks:.1f} times as fast as storages are refilled, full at {load_pct:.1f}% of the machines' time: {remedy}",
    "limit_vehicles": "{name}: {asks:.1f} times as much to carry as they can, full at {load_pct:.1f}% of the machines' time; {remedy}",
    "limit_charger": "{name}: {asks:.1f} times as much energy is used as they give, full at {load_pct:.1f}% of the machines' time; {remedy}",
    "alone": "{vehicle} alone of {vehicles} carries {ability} ({items}): nobody "
    "watches it or takes over when it fails; add another {type}",
    "trapped": "{nodes} can be entered and not left: add a lane that leads back",
    "lost": "{nodes} cannot be reached: add a lane that leads there, or remove it",
    "one_dock": "{places} have one dock, {node}: whoever stands at one keeps others from the rest; give each its own",
    "merged": "there is no room for a stop point between {places}: each is one crossing for one vehicle at a time; "
    "move them apart, or make them one node",
    "dock_in_way": "vehicles dock at {nodes} in the only way to others, who wait for them: give each dock a spur",
    "no_turning": "no lane leads back from before {doors}: who stands there when the door does not open waits for "
    "people; on a single track with another lane at its node it turns by itself",
    "near": "{pairs} are nearer to one another than vehicles of {length_m:g} m x "
    "{width_m:g} m can stand and turn on the spot: move them apart, or make them one node",
    "narrow": "who stands at {places} is in the way of whoever drives past: move the place or the lane away, "
    "so far that a vehicle passes and the other one can turn on the spot",
    "touch": "lanes cross or touch without a common node: {pairs}; vehicles on them are not kept apart: "
    "give them a node where they meet, or move them apart",
}
"""Shortages and narrow places of a plant that can be run."""

NOTE_TEXTS: Mapping[str, str] = {
    "note_edge_none_its_types_may": "edge {edge}: none of its types ({named}) may be at both of its nodes: taken for these types all the same",
    "note_edge_may_not_its_nodes": "edge {edge}: {gone} may not be at one of its nodes, and so does not drive there",
    "note_station_served_from_nodes_place": "station {station} is served from {count} nodes ({named}): a place at each{also}",
    "note_level_laid_beside_others_moved": "level {level} is laid beside the others: moved by {x_m:.2f} m, {y_m:.2f} m",
    "note_no_speed_told_taken": "no speed is told: {speed_mps:g} m/s is taken",
    "note_edge_leads_another_level_its": "edge {edge} leads to another level: its length here is not its true one",
    "note_edge_leads_back_its_own": "edge {edge} leads back to its own node: it is left out",
    "note_edge_second_from_first_taken": "edge {edge} is a second one from {start} to {end}: the first one is taken{also}",
    "note_moved_by_so_floor_begins": "moved by {x_m:.2f} m, {y_m:.2f} m, so that the floor begins at 0, 0",
    "note_lif_version_none_read_as": "lifVersion {version} is none of {known}: read as far as it is alike",
    "note_does_not_say_its_lifversion": "it does not say its lifVersion",
    "note_not_understood_kept_mapping": "`{key}` is not understood: it is kept in the mapping",
    "note_node_stands_several_other_layouts": "node {name} stands in several other layouts: the first one is taken",
    "note_trajectory_no_object_lane_taken": "the trajectory is no object: the lane is taken as straight",
    "note_trajectory_off_its_node_lane": "the trajectory is {gap_m:.1f} m off its node: the lane is taken as straight",
    "note_trajectory_little_off_its_nodes": "the trajectory is a little off its nodes: its ends are moved there",
    "note_layout_no_stations": "the layout has no `stations`",
    "note_not_said_type_vehicle_taken": "it is not said for which type of vehicle this is: taken for all",
    "note_node_without_left_out": "a node without `{key}` is left out",
    "note_node_whose_no_x_y": "a node whose `{key}` has no x and y is left out",
    "note_node_further_than_km_away": "a node further than {far_km:g} km away is left out",
    "note_there_no_layout": "there is no layout {name}",
    "note_node_there_already_left_out": "node {name} is there already: this one is left out",
    "note_node_stands_two_layouts_spot": "node {name} stands in two layouts at one spot: it is one node",
    "note_node_stands_another_layout_too": "node {name} stands in another layout, too, elsewhere: these are two nodes",
    "note_edge_left_out_there_no": "edge {name} is left out: there is no node {node}",
    "note_control_point_no_place_lane": "a control point has no place: the lane is taken as straight",
    "note_trajectory_no_curve_lane_taken": "the trajectory is no curve ({error}): the lane is taken as straight",
    "note_station_left_out_no_node": "station {name} is left out: it has no node",
    "note_layout_left_out_as_asked": "layout {name} is left out, as asked for",
    "note_theta_more_than_turn_radians": "theta is more than a turn in radians: degrees, it seems",
    "note_speed_none_no_limit_taken": "a speed of {limit:g} is none: no limit is taken",
    "note_lane_trajectory_or_guide_line": "a lane has a trajectory or a guide line, not both: the trajectory is taken",
    "note_station_there_no_node": "station {name}: there is no node {one}",
    "note_speed_cannot_no_limit_taken": "a speed of {limit_mps:g} m/s cannot be: no limit is taken",
    "note_types_vehicles_have_trajectories_their": "types of vehicles have trajectories of their own: the first one is taken",
    "note_edge_long_read_as_although": "an edge is {length:g} long: read as {unit_name}, although LIF has metres",
    "note_speeds_cannot_they_read_as": "speeds of {speed:g} cannot be m/s: they are read as {unit}/s",
    "note_edge_long_median_say_unit": "an edge is {length:g} m long at the median: say --unit cm or mm if these are no metres",
    "note_missing_or_no_object": "`{key}` is missing or is no object",
    "note_missing_types_vehicles_may_use": "`{old}` is missing: which types of vehicles may use it is not said; taken for all",
    "note_empty_types_vehicles_may_use": "`{key}` is empty: which types of vehicles may use it is not said; taken for all",
    "note_missing": "`{key}` is missing",
    "note_no_number": "`{key}` is no number: {value}",
    "note_blank_its_name_not_read": "`{key}` of {of} has a blank in its name: it is not read",
    "note_missing_or_no_list": "`{key}` is missing or is no list",
    "note_number_where_text_belongs": "`{key}` is a number where a text belongs",
    "note_number_written_as_text": "`{key}` is a number written as text",
    "note_not_understood_kept_mapping_2": "`{key}` of {of} is not understood: it is kept in the mapping",
    "note_no_field_plant_kept_mapping": "`{key}` of {of} ({about}) has no field in a plant: it is kept in the mapping",
    "note_entry_no_object_left_out": "an entry of `{key}` is no object: it is left out",
    "note_nodes_lie_on_spot_they": "nodes {one} and {other} lie on one spot: they are one, at which vehicles turn",
    "note_no_point_coordinates_its_own": "no point has coordinates of its own: where they are drawn is taken{times}",
    "note_model_version_none_read_as": "model version {version} is none of {known}: read as far as it is alike",
    "note_block_no_place_plant_vehicles": "a block has no place in a plant: vehicles keep right of way by nodes and lanes",
    "note_point_without_name_or_position": "a point without a name or a position within 1,000 km is left out",
    "note_point_there_already_left_out": "point {name} is there already: this one is left out",
    "note_vehicles_only_pass_report_position": "vehicles only pass a REPORT_POSITION; in a plant they may stop there",
    "note_heights_have_no_field_plant": "heights have no field in a plant: positionZ is kept in the mapping",
    "note_how_vehicle_stands_point_no": "how a vehicle stands at a point has no field in a plant: it is kept in the mapping",
    "note_maxvehicleboundingbox_without_length_width_all": "<maxVehicleBoundingBox> without a length and a width is for all vehicles",
    "note_maxvehicleboundingbox_taken_about_middle_vehicles": "<maxVehicleBoundingBox> is taken about the middle of vehicles: its offset is kept in the mapping",
    "note_path_left_out_there_no": "path {name} is left out: there is no point {node}",
    "note_locked_path_left_out_lanes": "a locked path is left out of the lanes: it is kept in the mapping",
    "note_path_long_by_its_length": "path {name} is {told_m:.2f} m long by its length and {drawn_m:.2f} m as it is drawn: as drawn is taken",
    "note_path_left_out_nobody_may": "path {name} is left out: nobody may drive on it, both speeds are 0",
    "note_path_driven_backwards_lane_other": "a path that is driven backwards is a lane the other way",
    "note_energy_levels_too_near_another": "the energy levels are too near to one another for a plant: the usual ones are taken",
    "note_not_understood_kept_mapping_3": "`{key}` of a {of} is not understood: it is kept in the mapping",
    "note_type_not_understood_taken_as": "type {kind} is not understood: taken as a node",
    "note_control_point_without_place_path": "a control point without a place: the path is taken as straight",
    "note_path_no_curve_taken_as": "the path is no curve ({error}): it is taken as straight",
    "note_location_locked_taken_all_same": "location {name} is locked: it is taken all the same",
    "note_location_left_out_no_link": "location {name} is left out: no link leads to it",
    "note_vehicle_without_name_left_out": "a vehicle without a name is left out",
    "note_vehicle_begins_there_no_such": "vehicle {name} begins at {node}, and there is no such point",
    "note_not_understood_left_out": "<{child}> in a {of} is not understood: it is left out",
    "note_no_place_plant_kept_mapping": "<{name}> has no place in a plant: it is kept in the mapping",
    "note_path_drawn_as_taken_as": "a path drawn as {kind}{about} is taken as straight",
    "note_location_there_no_point": "location {name}: there is no point {point}",
    "note_map_several_levels_poses_on": "map {map} is one of several levels: poses on it are taken for level {level}",
    "note_not_utf_read_as_look": "it is not UTF-8: read as {encoding}; look at its letters, or save it as UTF-8",
    "note_letters_were_lost_before_came": "letters were lost before it came here ({lost}): read the file from where it was made",
    "note_encoding_not_what_read_as": "encoding {declared} is not what it is in: read as {encoding}; look at its letters",
    "note_does_not_say_its_encoding": "it does not say its encoding: read as {encoding}; look at its letters",
    "note_more": "and {count} more",
    "note_plan_left_out": "left out: {kind}, {count} times",
    "note_plan_hidden_left_out": "left out: what is on hidden layers, {count} times",
    "note_plan_shapeless_left_out": "left out: {kind} without a shape, {count} times",
    "note_plan_in_millimetres": "it does not say its unit: millimetres are assumed, since it is {length:.0f} long",
    "note_plan_in_metres": "it does not say its unit: metres are assumed, since it is {length:.0f} long",
}
"""Oddities of a layout or a floor plan, and rejected data."""

PLAYED_TEXTS: Mapping[str, str] = {
    "played_late": "{on_time}% of {due} orders on time, and no one resource is short: the orders come together or are due too early for the ways and cycles",
    "played_nothing_short": "nothing is short: {delivered} of {placed} orders delivered; the busiest is {where}, {busy}%",
    "played_all_chargers": "all chargers",
    "played_machine": "machine {name}",
    "played_vehicles": "vehicles {name}",
    "played_overloaded": "{verdict}; overloaded {time:.1f}% of the time: up to {waiting} transports had waited for a vehicle for more than {limit_min:.0f} min",
    "played_cost": "transports waited {waited}% of their time for it, machines lost {lost}% of theirs",
    "played_few_vehicles": "too few vehicles that carry {ability}: {count} worked {busy}% of the time, and {queue:.1f} transports waited for one at any time; {cost}",
    "played_few_chargers": "too few chargers: {chargers} for {vehicles} vehicles, in use {busy}% of the time, and {hungry:.1f} vehicles stood with a low battery at any time; {cost}",
    "played_little_material": "too little {item}: no storage had a container of it {busy}% of the time (capacity {kept}); {cost}",
    "played_few_machines": "too few machines for {products}: {machine} made pieces {busy}% of the time, and {left_h:.1f} h of its work were left at the end",
    "played_few_docks": "one dock of {place} is too few: vehicles stood there for {busy}% of the time; {cost}; larger lots, quicker handling, or another place that shares the work",
    "played_small_buffer": "too small a buffer for {item}: the next load came too late, though nothing kept it waiting; machines lost {lost}% of their time",
    "played_narrow_lane": "the lane {lane} is too narrow: {cost}",
    "played_too_long": "it took longer than {most_s:g} s: play fewer hours",
    "played_no_report": "the simulator gave no report",
    "played_broken_off": "it was broken off",
}
"""Results of a shift that was played: the bottleneck, or why there is none."""

TEXTS: Mapping[str, str] = {
    **ITEM_TEXTS,
    **PART_TEXTS,
    **SHAPE_TEXTS,
    **FAULT_TEXTS,
    **ADVICE_TEXTS,
    **NOTE_TEXTS,
    **PLAYED_TEXTS,
}
"""All texts by code, with placeholders."""

Value = object
"""Value of a placeholder: a text, a number, another reason, or several of them (a tuple), which are joined with
commas."""


class Reason(str):
    """A reason in English that has a code, too.

    Args:
        code: one of `TEXTS`.
        values: of the placeholders.
    """

    __slots__ = ("code", "values")

    code: str
    values: dict[str, Value]

    def __new__(cls, code: str, /, **values: Value) -> Self:
        """Fill it in."""
        english = {
            name: ", ".join(map(str, value)) if isinstance(value, tuple) else value
            for name, value in values.items()
        }
        reason = super().__new__(cls, TEXTS[code].format_map(english))
        reason.code, reason.values = code, values
        return reason

    def __reduce__(self) -> tuple[object, ...]:
        # Pickle it whole, for another process.
        return _again, (self.code, self.values)


def _again(code: str, values: Mapping[str, Value]) -> Reason:
    return Reason(code, **values)


def listed(names: Sequence[str], most: int = SHOWN) -> Value:
    """The first few of some names, or of reasons, and how many more there are."""
    shown = tuple(names[:most])
    return Reason("and_more", names=shown, count=len(names) - most) if len(names) > most else shown


def joined(code: str, names: Sequence[str]) -> str:
    """Names with `and` or `or` between them, each of which counts."""
    told = names[0]
    for name in names[1:]:
        told = Reason(code, one=told, other=name)
    return told


def counted(one: str, many: str, count: int) -> Reason:
    """The reason of one thing, or of several."""
    return Reason(one if count == 1 else many, count=count)


def told(reason: str, named: Callable[[str], str]) -> dict[str, Any]:
    """The values of a reason as JSON; an inner reason has `code`, `values` and `text`.

    Empty for a text without a code.

    Args:
        reason: with or without a code.
        named: formats a text among the values.
    """
    if not isinstance(reason, Reason):
        return {}
    return {name: _told(value, named) for name, value in reason.values.items()}


def _told(value: Value, named: Callable[[str], str]) -> Any:
    if isinstance(value, Reason):
        return {"code": value.code, "values": told(value, named), "text": named(str(value))}
    if isinstance(value, tuple):
        return [_told(each, named) for each in value]
    if isinstance(value, float) and not isfinite(value):
        return "∞"
    return value if isinstance(value, int | float) else named(str(value))
