"""German."""

from __future__ import annotations

from dray.gateway.access.login.texts.catalogue import Catalogue

DE = Catalogue(
    languages="Sprache",
    skip="Zur Anmeldung",
    title="Anmelden",
    manager_heading="Leitstand",
    operator_heading="Bedienpult",
    id="Name",
    id_hint="wie er Ihnen gegeben wurde",
    known="Wer sind Sie?",
    somebody_else="Jemand anders",
    password="Passwort",  # noqa: S106 - a label
    pin="PIN",
    pin_hint="sechs Ziffern oder mehr",
    pin_delete="Letzte Ziffer löschen",
    badge="Ausweis",
    badge_hint="Ausweis an den Leser halten",
    submit="Anmelden",
    to_operator="Ich arbeite an einer Station",
    to_manager="Ich leite das Werk",
    wrong_pin="Das passt nicht: Name oder PIN ist falsch. Prüfen Sie beides und versuchen Sie es noch einmal.",
    wrong_password="Das passt nicht: Name oder Passwort ist falsch. Prüfen Sie beides und versuchen Sie es noch einmal.",  # noqa: S106 - a sentence
    wrong_badge="Dieser Ausweis passt nicht. Versuchen Sie es noch einmal, oder melden Sie sich mit Name und PIN an.",
    too_many="Zu viele Versuche. Versuchen Sie es in {wait} wieder.",
    seconds="{n} s",
    minutes="{n} min",
    busy="Gerade melden sich zu viele an. Versuchen Sie es in einigen Sekunden wieder.",
    away="Die Datenbank antwortet gerade nicht. Versuchen Sie es in einigen Sekunden wieder.",
    link_heading="Guten Tag, {name}",
    link_note="Dieser Link meldet Sie einmal an, auf diesem Gerät.",
    link_submit="Anmelden",
    gone_heading="Dieser Link meldet niemanden mehr an",
    gone_note="Er wurde schon benutzt oder ist zu alt. Bitten Sie um einen neuen.",
    unknown_heading="Hier gibt es keine Seite",
    unknown_note="Die Adresse ist falsch geschrieben, oder die Seite gibt es nicht mehr.",
    unknown_back="Zur Startseite",
    unknown_skip="Zum Inhalt springen",
    station_heading="Wo arbeiten Sie jetzt?",
    station_note="Sie können nur an einer Station angemeldet sein. Ihre Anmeldung an anderen Stationen ist beendet.",
    no_station="In Ihren Bereichen steht keine Maschine.",
    without_station="Ohne Station weiter",
    help="Kein Zugang? Wer Dray betreut, kann Ihnen einen Link geben.",
)
