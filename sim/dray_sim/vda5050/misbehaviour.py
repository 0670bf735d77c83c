"""Misbehaviour of vehicles in the field, as values: each was seen with a real implementation (docs/vehicles.md)."""

from __future__ import annotations

import msgspec


class Misbehaviour(msgspec.Struct, frozen=True):
    """One vehicle's deviations from the text; none by default."""

    silent_until_asked: bool = False
    """It sends no state by itself before the first stateRequest."""
    says_offline: bool = False
    """Its connection message is OFFLINE, and stays so."""
    doubles_states: bool = False
    """Every state is said twice."""
    clock_off_s: float = 0.0
    """Error of its clock (s)."""
    no_zone: bool = False
    """Its times have no Z."""
    ignores_first_orders: int = 0
    """Number of first orders that never reach it."""
    refuses_every_second: bool = False
    """Every second orderId is refused in silence."""
    lingering_warnings: bool = False
    """Warnings about orders of old stay in `errors`."""
    busy_after_s: float = 0.0
    """After an order it refuses others for so long, though it looks idle."""
    keeps_node_states: bool = False
    """`nodeStates` is never empty once an order has come."""
    tells_ends_only: bool = False
    """It sends no state at the nodes between: several are skipped at once."""
    cancel_s: float = 0.5
    """A cancelOrder takes so long; an order that comes meanwhile is killed by it."""
    idle_cancel_kills_next: bool = False
    """A cancelOrder while idle ends the next order at once."""
    ignores_pause: bool = False
    """startPause is FINISHED, and it drives on."""
    no_action_at_last_node: bool = False
    """An action never runs where node and sequence equal the last ones."""
    actions_twice: bool = False
    """Every action is listed twice, the second time WAITING for ever."""
    no_last_node: bool = False
    """`lastNodeId` is empty until it has driven."""
    no_loads: bool = False
    """`loads` is absent."""
    no_pose_in_state: bool = False
    """Poses come in `visualization` alone."""
    loses_updates: bool = False
    """Updates of an order are shown and not driven."""
    battery_of_1: bool = False
    """Its battery counts to 1, not to 100."""
    numbers_as_text: bool = False
    """`orderUpdateId` and the battery's charge are texts, and there are nulls."""
    forgets_finished_order: bool = False
    """orderId is empty as soon as an order is done."""
    ignores_instant_actions: int = 0
    """Number of instant actions that never reach it."""
