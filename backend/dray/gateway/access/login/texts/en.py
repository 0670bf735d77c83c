"""English."""

from __future__ import annotations

from dray.gateway.access.login.texts.catalogue import Catalogue

EN = Catalogue(
    languages="Language",
    skip="Skip to the login",
    title="Log in",
    manager_heading="Management panel",
    operator_heading="Operator panel",
    id="Name",
    id_hint="as it was given to you",
    known="Who are you?",
    somebody_else="Somebody else",
    password="Password",  # noqa: S106 - a label
    pin="PIN",
    pin_hint="six digits or more",
    pin_delete="Delete the last digit",
    badge="Badge",
    badge_hint="Hold your badge to the reader",
    submit="Log in",
    to_operator="I work at a station",
    to_manager="I manage the plant",
    wrong_pin="That did not open: name or PIN is wrong. Look at both and try again.",
    wrong_password="That did not open: name or password is wrong. Look at both and try again.",  # noqa: S106 - a sentence
    wrong_badge="That badge does not open. Try again, or log in with name and PIN.",
    too_many="Too many tries. Try again in {wait}.",
    seconds="{n} s",
    minutes="{n} min",
    busy="Too many log in at this moment. Try again in some seconds.",
    away="The database does not answer at this moment. Try again in some seconds.",
    link_heading="Hello, {name}",
    link_note="This link logs you in once, on this device.",
    link_submit="Log in",
    gone_heading="This link does not log in any more",
    gone_note="It was used already, or is too old. Ask for a new one.",
    unknown_heading="There is no page here",
    unknown_note="The address is misspelt, or the page is not there any more.",
    unknown_back="To the start page",
    unknown_skip="Skip to the content",
    station_heading="Where do you work now?",
    station_note="You can be logged in at one station only. Your login at any other station has ended.",
    no_station="There is no machine in your areas.",
    without_station="Go on without a station",
    help="No access? Whoever looks after Dray can give you a link.",
)
