"""Ways: as short as networkx finds them, as long as the simulated vehicle drives them."""

from __future__ import annotations

from itertools import pairwise
from math import cos, inf, sin

import networkx as nx
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.errors import NoWay
from dray.plant import (
    Lane,
    Node,
    Plant,
    Roads,
    Routes,
    VehicleType,
    bends,
    default_plant,
    load_plant,
    parse_plant,
)
from dray.plant import routes as routes_module
from dray.plant.lane_times import LaneTimes
from dray_sim.bodies.vehicle.motion import Stretch, plan

FAST = VehicleType(id="fast", name="Fast", max_speed_mps=1.5, acceleration_mps2=0.6, turn_speed_mps=0.5)


def grid(columns: int, rows: int, pitch_m: float = 10.0) -> Roads:
    """Crossings `c0_0` to the right and up, joined both ways."""
    nodes = [Node(f"c{x}_{y}", x * pitch_m, y * pitch_m) for y in range(rows) for x in range(columns)]
    lanes = [
        Lane(f"c{x}_{y}", f"c{x + 1}_{y}", both_ways=True) for y in range(rows) for x in range(columns - 1)
    ]
    lanes += [
        Lane(f"c{x}_{y}", f"c{x}_{y + 1}", both_ways=True) for y in range(rows - 1) for x in range(columns)
    ]
    return Roads(nodes, lanes)


@st.composite
def random_roads(draw: st.DrawFn) -> Roads:
    """A handful of nodes with lanes anywhere, some of them slow, not all of them joined."""
    spots = draw(
        st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)), min_size=2, max_size=9, unique=True)
    )
    nodes = [Node(f"n{index}", float(x_m), float(y_m)) for index, (x_m, y_m) in enumerate(spots)]
    ends = st.tuples(*[st.integers(0, len(nodes) - 1)] * 2).filter(lambda pair: pair[0] != pair[1])
    joined = draw(st.lists(ends, max_size=24, unique=True))
    limits = st.sampled_from([0.5, 0.8, 1.5, 3.0])
    return Roads(nodes, [Lane(f"n{start}", f"n{end}", draw(limits)) for start, end in joined])


def lane_s(roads: Roads, nodes: tuple[str, ...], vehicle: VehicleType) -> float:
    """The time that a way would take at full speed, lane by lane."""
    times = []
    for start, end in pairwise(nodes):
        lane = roads.lane(start, end)
        assert lane is not None, f"no lane leads from {start} to {end}"
        times.append(lane.length_m / min(lane.speed_limit_mps, vehicle.max_speed_mps))
    return sum(times)


@settings(deadline=None, max_examples=examples(300))
@given(random_roads())
def test_every_way_is_as_short_as_networkx_finds_it(roads: Roads) -> None:
    graph = nx.DiGraph()
    graph.add_nodes_from(roads.leaving)
    for lane in roads.lanes:
        graph.add_edge(
            lane.start, lane.end, time=lane.length_m / min(lane.speed_limit_mps, FAST.max_speed_mps)
        )
    routes = Routes(roads, FAST, {})
    for start, reached in nx.all_pairs_dijkstra_path_length(graph, weight="time"):
        for goal in roads.leaving:
            if goal in reached:
                way = routes.way(start, goal)
                assert (way.nodes[0], way.nodes[-1]) == (start, goal)
                assert lane_s(roads, way.nodes, FAST) == pytest.approx(reached[goal])
            else:
                with pytest.raises(NoWay):
                    routes.way(start, goal)


@settings(deadline=None, max_examples=examples(300))
@given(random_roads())
def test_every_way_takes_as_long_as_the_simulated_vehicle_needs(roads: Roads) -> None:
    routes = Routes(roads, FAST, {})
    for start in roads.leaving:
        for goal in roads.reached_from(start):
            way = routes.way(start, goal)
            lanes = [lane for a, b in pairwise(way.nodes) if (lane := roads.lane(a, b))]
            caps = [FAST.turn_speed_mps if bends(a, b) else float("inf") for a, b in pairwise(lanes)]
            limits = [min(lane.speed_limit_mps, FAST.max_speed_mps) for lane in lanes]
            if not lanes:
                continue
            stretch = Stretch([lane.length_m for lane in lanes], limits, [*caps, 0.0])
            driven = plan(stretch, 0.0, FAST.acceleration_mps2)
            assert way.duration_s == pytest.approx(driven.duration_s, abs=1e-6)
            assert way.length_m == pytest.approx(driven.length_m)


@settings(deadline=None)
@given(random_roads(), st.randoms(use_true_random=False))
def test_the_order_of_the_questions_changes_no_answer(roads: Roads, rng: st.Random) -> None:
    pairs = [(start, goal) for start in roads.leaving for goal in sorted(roads.reached_from(start))]
    first = Routes(roads, FAST, {})
    answers = {pair: first.way(*pair) for pair in pairs}
    rng.shuffle(pairs)
    second = Routes(roads, FAST, {})
    assert all(second.way(*pair) == answers[pair] for pair in pairs)


def test_a_way_to_where_it_begins_costs_nothing() -> None:
    way = Routes(grid(2, 2), FAST, {}).way("c0_0", "c0_0")
    assert (way.nodes, way.length_m, way.duration_s) == (("c0_0",), 0.0, 0.0)


def test_a_straight_run_is_a_trapezoid() -> None:
    # 1.5 m/s is reached in 2.5 s on 1.875 m, at either end; 6.25 m remain at full speed.
    way = Routes(grid(2, 1), FAST, {}).way("c0_0", "c1_0")
    assert way.duration_s == pytest.approx(2.5 + 6.25 / 1.5 + 2.5)


def test_a_short_run_is_a_triangle() -> None:
    # On 1.5 m there is room to speed up for 0.75 m, which takes the root of 2 * 0.75 / 0.6 seconds.
    way = Routes(grid(2, 1, pitch_m=1.5), FAST, {}).way("c0_0", "c1_0")
    assert way.duration_s == pytest.approx(2 * (2 * 0.75 / 0.6) ** 0.5)


def test_a_bend_costs_the_time_to_brake_and_to_speed_up_again() -> None:
    routes = Routes(grid(3, 3), FAST, {})
    straight, bent = routes.way("c0_0", "c2_0"), routes.way("c0_0", "c1_1")
    assert straight.length_m == pytest.approx(bent.length_m)
    # Between 1.5 and 0.5 m/s, 1.667 s at 1 m/s instead of 1.5 m/s: on either side of the bend.
    assert bent.duration_s - straight.duration_s == pytest.approx(2 * (1.0 / 0.6 - (2.25 - 0.25) / 1.2 / 1.5))


def test_a_node_on_a_straight_road_costs_nothing() -> None:
    whole = Roads([Node("a", 0, 0), Node("b", 20, 0)], [Lane("a", "b")])
    halves = Roads([Node("a", 0, 0), Node("m", 7, 0), Node("b", 20, 0)], [Lane("a", "m"), Lane("m", "b")])
    expected_s = Routes(whole, FAST, {}).duration_s("a", "b")
    assert Routes(halves, FAST, {}).duration_s("a", "b") == pytest.approx(expected_s)


def test_a_slow_lane_is_avoided_where_the_way_round_is_faster() -> None:
    nodes = [Node("a", 0, 0), Node("b", 10, 0), Node("c", 5, 5)]
    slow = Routes(Roads(nodes, [Lane("a", "b", 0.5), Lane("a", "c"), Lane("c", "b")]), FAST, {})
    assert slow.way("a", "b").nodes == ("a", "c", "b")


def test_a_slow_vehicle_need_not_avoid_a_slow_lane() -> None:
    nodes = [Node("a", 0, 0), Node("b", 10, 0), Node("c", 5, 5)]
    roads = Roads(nodes, [Lane("a", "b", 0.5), Lane("a", "c"), Lane("c", "b")])
    crawler = VehicleType(id="crawler", name="Crawler", max_speed_mps=0.5)
    assert Routes(roads, crawler, {}).way("a", "b").nodes == ("a", "b")


def test_of_equally_short_ways_the_one_with_few_bends_is_taken() -> None:
    way = Routes(grid(4, 4), FAST, {}).way("c0_0", "c3_3")
    assert way.nodes == ("c0_0", "c1_0", "c2_0", "c3_0", "c3_1", "c3_2", "c3_3")


def test_one_way_lanes_are_not_driven_backwards() -> None:
    roads = Roads([Node("a", 0, 0), Node("b", 10, 0)], [Lane("a", "b")])
    with pytest.raises(NoWay, match="no way leads from b to a"):
        Routes(roads, FAST, {}).way("b", "a")


@pytest.mark.parametrize("pair", [("c0_0", "nowhere"), ("nowhere", "c0_0"), ("nowhere", "nowhere")])
def test_an_unknown_node_has_no_way(pair: tuple[str, str]) -> None:
    routes = Routes(grid(2, 2), FAST, {})
    for ask in (routes.way, routes.duration_s, routes.length_m):
        with pytest.raises(NoWay):
            ask(*pair)


def test_length_and_duration_are_those_of_the_way() -> None:
    routes = Routes(grid(4, 4), FAST, {})
    length_m, duration_s = routes.length_m("c0_1", "c3_2"), routes.duration_s("c0_1", "c3_2")
    way = routes.way("c0_1", "c3_2")
    assert (way.length_m, way.duration_s) == (length_m, duration_s)


def test_the_nearest_place_is_the_one_reached_first() -> None:
    places = {"FAR": "c3_3", "NEAR": "c1_0", "ALSO": "c0_1"}
    nearest, way = Routes(grid(4, 4), FAST, places).nearest("c0_0", places)
    assert (nearest, way.nodes[-1]) == ("NEAR", "c1_0")


@settings(deadline=None)
@given(random_roads())
def test_the_farthest_node_is_the_one_with_the_most_lane_time_of_those_that_can_reach_it(
    roads: Roads,
) -> None:
    routes = Routes(roads, FAST, {})
    for goal in roads.leaving:
        ways = [routes.way(start, goal) for start in roads.leaving if goal in roads.reached_from(start)]
        farthest = max(ways, key=lambda way: lane_s(roads, way.nodes, FAST))
        most_s = lane_s(roads, farthest.nodes, FAST)
        equal = [w.duration_s for w in ways if lane_s(roads, w.nodes, FAST) >= most_s - 1e-9]
        assert routes.farthest_s(goal) in equal


def test_places_that_cannot_be_reached_are_not_the_nearest() -> None:
    roads = Roads([Node("a", 0, 0), Node("b", 5, 0), Node("c", 9, 0)], [Lane("b", "a"), Lane("a", "c")])
    routes = Routes(roads, FAST, {"B": "b", "C": "c"})
    assert routes.nearest("a", ["B", "C"])[0] == "C"
    with pytest.raises(NoWay):
        routes.nearest("a", ["B"])
    with pytest.raises(NoWay):
        routes.nearest("a", [])


def test_a_full_memory_is_dropped_and_answers_stay_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    roads = grid(4, 4)
    pairs = [(start, goal) for start in roads.leaving for goal in roads.leaving]
    unbounded = Routes(roads, FAST, {})
    monkeypatch.setattr(routes_module, "MAX_WAYS", 10)
    bounded = Routes(roads, FAST, {})
    assert [bounded.way(*pair) for pair in pairs] == [unbounded.way(*pair) for pair in pairs]
    assert sum(len(ways) for ways in bounded._found.values()) <= 10


def test_lanes_too_short_to_tell_apart_make_no_circle() -> None:
    # The check of a plant file refuses these; a plant built in code must not hang on them.
    nodes = [Node("a", 0, 0), Node("b", 0, 0), Node("c", 0, 0), Node("d", 10, 0)]
    lanes = [Lane("a", "b", both_ways=True), Lane("b", "c", both_ways=True), Lane("c", "d", both_ways=True)]
    with pytest.raises(NoWay):
        Routes(Roads(nodes, lanes), FAST, {}).way("a", "d")


@pytest.mark.slow
def test_every_way_of_the_default_plant_joins_its_ends_by_lanes() -> None:
    plant = default_plant()
    routes = plant.routes("heavy")
    for start in plant.nodes:
        for goal in plant.nodes:
            way = routes.way(start, goal)
            lane_s(plant.roads, way.nodes, plant.vehicle_types["heavy"])
            assert len(set(way.nodes)) == len(way.nodes)


def test_a_plant_keeps_one_set_of_routes_per_type() -> None:
    plant = Plant(default_plant().file)
    assert plant.routes("light") is plant.routes("light")
    assert plant.routes("light") is not plant.routes("heavy")
    with pytest.raises(KeyError):
        plant.routes("unheard")


# --- roads -------------------------------------------------------------------------------------------


def test_a_lane_both_ways_is_two_directed_lanes(small_text: str) -> None:
    plant = parse_plant(small_text, "small.yaml")
    there, back = plant.roads.lane("west", "middle"), plant.roads.lane("middle", "west")
    assert there is not None
    assert back is not None
    assert plant.lanes[:2] == (there, back)
    assert (there.length_m, back.length_m) == (15.0, 15.0)
    assert abs(there.heading_rad - back.heading_rad) == pytest.approx(3.14159, abs=1e-4)
    assert plant.roads.lane("west", "east") is None


@pytest.mark.parametrize(
    ("degrees", "slows"), [(0, False), (29, False), (30, False), (31, True), (90, True), (180, True)]
)
def test_a_vehicle_slows_down_where_its_way_bends_by_more_than_30_degrees(degrees: int, slows: bool) -> None:
    for first in range(0, 360, 15):
        angles = [first * 3.141592653589793 / 180, (first + degrees) * 3.141592653589793 / 180]
        middle = Node("b", 50.0, 50.0)
        nodes = [
            Node("a", 50.0 - 10 * cos(angles[0]), 50.0 - 10 * sin(angles[0])),
            middle,
            Node("c", 50.0 + 10 * cos(angles[1]), 50.0 + 10 * sin(angles[1])),
        ]
        before, after = Roads(nodes, [Lane("a", "b"), Lane("b", "c")]).lanes
        assert bends(before, after) is slows


@settings(deadline=None)
@given(random_roads())
def test_parts_are_the_strongly_connected_components(roads: Roads) -> None:
    graph = nx.DiGraph((lane.start, lane.end) for lane in roads.lanes)
    graph.add_nodes_from(roads.leaving)
    expected = {frozenset(part) for part in nx.strongly_connected_components(graph)}
    assert set(roads.parts()) == expected
    assert len(roads.parts()) == len(expected)


@settings(deadline=None)
@given(random_roads())
def test_reached_and_reaching_are_two_sides_of_one_thing(roads: Roads) -> None:
    for start in roads.leaving:
        assert all(start in roads.reaching(goal) for goal in roads.reached_from(start))


@pytest.mark.parametrize("name", ["single-track", "workshop"])
def test_the_nearest_of_several_is_the_one_with_the_shortest_way_and_of_equals_the_first(name: str) -> None:
    plant = load_plant(name)
    places = tuple(plant.places)
    for kind in plant.vehicle_types:
        nodes = {place: plant.node_of(place) for place in places}
        routes, asked_once = plant.routes(kind), Routes(plant.roads, plant.vehicle_types[kind], nodes)
        for start in sorted(plant.nodes)[::7]:
            ways = {
                place: routes.duration_s(start, plant.node_of(place))
                for place in places
                if routes.leads(start, plant.node_of(place))
            }
            assert asked_once.nearest(start, places)[0] == min(ways, key=ways.__getitem__)
            starts = [node for node in sorted(plant.nodes)[::5] if routes.leads(node, start)]
            shortest_s = min((routes.duration_s(node, start) for node in starts), default=inf)
            assert asked_once.nearest_s(starts, start) == shortest_s


def test_lane_times_are_the_same_in_whatever_order_they_are_asked_for() -> None:
    lanes: dict[str, list[tuple[str, float]]] = {
        "a": [("b", 1.0), ("c", 5.0)],
        "b": [("c", 2.0)],
        "c": [],
        "d": [],
    }
    near_first, far_first = (LaneTimes("a", lanes.__getitem__) for _ in range(2))
    assert [near_first(node) for node in "abcd"] == [0.0, 1.0, 3.0, inf]
    assert [far_first(node) for node in "dcba"] == [inf, 3.0, 1.0, 0.0]
    seen = near_first.nearest_first()
    assert next(seen) == ("a", 0.0)
    assert list(seen) == [("b", 1.0), ("c", 3.0)]
