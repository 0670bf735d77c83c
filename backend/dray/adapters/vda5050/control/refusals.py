"""Errors about orders, not about the vehicle: finding the one that refuses a given order.

VDA 5050 3.0 (6.6.5.4) names their types, and each stays until the next order is accepted. Vehicles of 2.x report the same at any
level, FATAL too, and often without naming the order.
"""

from __future__ import annotations

from dray.adapters.vda5050.control.vehicle_order import VehicleOrder
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import State, VehicleError

ABOUT_ORDERS = frozenset(
    {
        *("validationerror", "ordererror", "orderupdateerror", "norouteerror", "noordertocancel"),
        *("validationfailure", "unsupportedparameter", "invalidorderaction", "invalidinstantaction"),
        *("outdatedorderupdate", "sameorderupdateid", "orderupdatefollowingcancel", "otherorderactive"),
        *("startnodeoutofrange", "noroutetotarget", "mobilerobotnotavailable", "unknownmapid"),
        *("insufficientmemory", "duplicatemap", "duplicatezoneset"),
    }
)
"""Types of 2.x, then of 3.0, without capitals and underscores."""

UNSUPPORTED = "unsupportedparameter"

CRITICAL, FATAL = "CRITICAL", "FATAL"


def plain(error_type: str | None) -> str:
    """A normalised error type: vehicles write it in capitals, in camel case, with and without underscores."""
    return (error_type or "").replace("_", "").lower()


def is_about_order(error: VehicleError) -> bool:
    """Whether the type concerns an order or an instant action: such an error does not block the vehicle."""
    return plain(error.error_type) in ABOUT_ORDERS


def refusal(order: VehicleOrder, state: State) -> VehicleError | None:
    """The error that refuses an order: one that names it, else a new one about orders without another order's name.

    Lingering warnings name other orders, or existed before the order or its update was sent.
    """
    errors = [error for error in state.errors or () if error.key not in order.old_errors]
    named = next((error for error in errors if error.names(order.id)), None)
    if named is not None:
        return named
    return next((error for error in errors if is_about_order(error) and not error.order_named), None)


def kept_refusal(state: State) -> VehicleError | None:
    """A shown error about orders that names none: vehicles keep it until they take an order, and do not report it again."""
    return next((each for each in state.errors or () if is_about_order(each) and not each.order_named), None)


def unsupported(error: VehicleError) -> frozenset[str]:
    """The names of parameters that an error reports as unsupported; empty for other errors."""
    if plain(error.error_type) != UNSUPPORTED:
        return frozenset()
    said = ((pair.reference_key, pair.reference_value) for pair in error.error_references or ())
    return frozenset(word.rpartition(".")[2] for pair in said for word in pair if word)


def is_critical(error: VehicleError, profile: Profile) -> bool:
    """Whether the error ends the vehicle's order, though it takes others (3.0, 6.6.5.1)."""
    if is_about_order(error):
        return False
    kept = error.error_level == FATAL and error.error_type in profile.kept_until_order
    return kept or error.error_level == CRITICAL


def critical(state: State, profile: Profile) -> VehicleError | None:
    """The first such error."""
    return next((error for error in state.errors or () if is_critical(error, profile)), None)
