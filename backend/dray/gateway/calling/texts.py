"""Texts of a call key's page, by language."""

from __future__ import annotations

from collections.abc import Mapping

_KEYS = (
    "languages",
    "skip",
    "title",
    "above",
    "what",
    "nothing_kept",
    "here",
    "chosen",
    "choose",
    "bring",
    "take",
    "called",
    "none",
    "brought",
    "taken",
    "call_off",
    "again",
    "minutes",
    "soon",
    "until",
    "stop",
    "gone",
    "gone_note",
    "refused",
    "sign_code",
    "sign_scan",
    "sign_print",
    "thing",
    "thing_what",
    "thing_place",
    "thing_choose",
    "thing_carried",
    "thing_bring",
    "thing_take",
    "left",
    "left_nowhere",
    "handed",
)

_STATES = ("waiting", "assigned", "on_board", "delivered", "cancelled", "being_cancelled")
_WAITS = ("no_room", "short", "no_bid", "undecided", "not_before")


def _catalogue(texts: str, states: str, waits: str) -> Mapping[str, str]:
    """A catalogue from lines in the order of the names above."""
    names = (*_KEYS, *(f"state_{each}" for each in _STATES), *(f"wait_{each}" for each in _WAITS))
    lines = [line.strip() for part in (texts, states, waits) for line in part.strip().splitlines()]
    return dict(zip(names, lines, strict=True))


TEXTS: Mapping[str, Mapping[str, str]] = {
    "en": _catalogue(
        """Language
        Skip to what can be called
        Call
        Call a vehicle
        What?
        This place keeps no material.
        {level} here
        {item}: how much?
        Choose first what; nothing is sent by that.
        Bring {quantity}
        Take {quantity} away
        Called with this key
        Nothing yet.
        {quantity} {item} from {place}
        {quantity} {item} to {place}
        Call off
        Look again
        there in {n} min
        there in less than a minute
        This key works until {day}.
        No stop is here. In danger: the red button on the vehicle.
        This key calls nothing any more
        It was taken back, has run out, or is no key of one place. Ask whoever looks after Dray.
        Not called: {reason}
        QR code of the page on which to call
        Scan this with a phone to have something brought here or taken away.
        Print this page and hang it up here. A phone must reach the address above; whoever has it can call.
        Something else, as an empty container
        What
        To or from
        Choose…
        Carried as
        Bring it here
        Take it away from here
        on board of {vehicle}, which has failed at {node}
        on board of {vehicle}, which has failed
        it is handed over at {node}""",
        """called
        taken by a vehicle
        on board
        here
        called off
        being called off""",
        """{place} has no room for it yet; it comes by itself as soon as there is room
        there is not enough of it yet
        no vehicle can take it yet
        it is being offered
        it is not to begin yet""",
    ),
    "de": _catalogue(
        """Sprache
        Weiter zu dem, was man rufen kann
        Rufen
        Ein Fahrzeug rufen
        Was?
        An diesem Platz liegt kein Material.
        {level} hier
        {item}: wie viel?
        Erst wählen, was; damit ist noch nichts gesendet.
        {quantity} bringen
        {quantity} abholen
        Mit diesem Schlüssel gerufen
        Noch nichts.
        {quantity} {item} von {place}
        {quantity} {item} nach {place}
        Abbestellen
        Noch einmal nachsehen
        da in {n} min
        da in weniger als einer Minute
        Dieser Schlüssel gilt bis {day}.
        Hier ist kein Stopp. Bei Gefahr: der rote Knopf am Fahrzeug.
        Mit diesem Schlüssel lässt sich nichts mehr rufen
        Er wurde zurückgenommen, ist abgelaufen oder gehört zu keinem Platz. Fragen Sie, wer Dray betreut.
        Nicht gerufen: {reason}
        QR-Code der Seite, auf der man ruft
        Mit dem Handy einlesen, um hierher etwas bringen oder von hier etwas abholen zu lassen.
        Diese Seite ausdrucken und hier aufhängen. Das Handy muss die Adresse oben erreichen; wer sie hat, kann rufen.
        Etwas anderes, zum Beispiel ein leerer Behälter
        Was
        Wohin oder woher
        Wählen…
        Getragen als
        Hierher bringen
        Von hier wegbringen
        an Bord von {vehicle}, das bei {node} ausgefallen ist
        an Bord von {vehicle}, das ausgefallen ist
        es wird bei {node} übergeben""",
        """gerufen
        von einem Fahrzeug übernommen
        an Bord
        da
        abbestellt
        wird abbestellt""",
        """{place} hat noch keinen Platz dafür; es kommt von selbst, sobald Platz ist
        es ist noch nicht genug davon da
        noch kann kein Fahrzeug
        es wird angeboten
        es soll noch nicht beginnen""",
    ),
    "es": _catalogue(
        """Idioma
        Ir a lo que se puede pedir
        Llamar
        Llamar a un vehículo
        ¿Qué?
        En este puesto no hay material.
        {level} aquí
        {item}: ¿cuánto?
        Primero elija qué; con eso no se envía nada.
        Traer {quantity}
        Llevarse {quantity}
        Pedido con esta clave
        Nada todavía.
        {quantity} {item} de {place}
        {quantity} {item} a {place}
        Anular
        Mirar otra vez
        llega en {n} min
        llega en menos de un minuto
        Esta clave vale hasta {day}.
        Aquí no hay parada. En peligro: el botón rojo del vehículo.
        Esta clave ya no llama a nada
        Fue retirada, caducó o no es de un puesto. Pregunte a quien cuida de Dray.
        No pedido: {reason}
        Código QR de la página en la que se llama
        Escanéelo con un móvil para que traigan algo aquí o se lo lleven.
        Imprima esta página y cuélguela aquí. El móvil debe llegar a la dirección de arriba; quien la tiene puede llamar.
        Otra cosa, por ejemplo un contenedor vacío
        Qué
        Adónde o de dónde
        Elegir…
        Se lleva como
        Traer aquí
        Retirar de aquí
        a bordo de {vehicle}, que ha fallado en {node}
        a bordo de {vehicle}, que ha fallado
        se entrega en {node}""",
        """pedido
        lo tomó un vehículo
        a bordo
        aquí
        anulado
        anulándose""",
        """{place} todavía no tiene sitio; llega por sí solo en cuanto haya
        todavía no hay bastante
        todavía no puede ningún vehículo
        se está ofreciendo
        aún no debe empezar""",
    ),
}

REFUSALS: Mapping[str, Mapping[str, str]] = {
    "de": {
        "key_full": "offene Rufe dieses Schlüssels: {most}, mehr darf er nicht haben. Einen abbestellen oder warten, bis einer da ist",
        "key_full_at": "offene Rufe dieses Schlüssels für {place}: {most}, mehr darf er nicht haben. Einen abbestellen oder warten, bis einer da ist",
        "share_used": "mehr als {most} offene Rufe darf keiner haben. Warten, bis einer da ist",
        "too-many-transports": "im ganzen Werk sind zu viele Transporte offen. Später noch einmal rufen",
        "place_not_keeping": "{place} hat keinen Platz für {item}",
        "no_other_storage": "kein anderes Lager führt {item}",
        "only_items": "mit diesem Schlüssel ruft man nur {items}",
        "load_too_large": "eine Ladung {item} sind höchstens {most}. Mehrmals rufen: {loads}",
        "item_is_product": "{item} ist ein Produkt: fertige Ware wird von selbst abgeholt",
        "thing_place": "wählen, wohin oder woher",
        "thing_ability": "wählen, als was es getragen wird: {abilities}",
        "same_place": "es ist schon bei {place}. Einen anderen Platz wählen",
        "ability_nobody": "kein Fahrzeug dieses Werks trägt {carried}",
        "at_least": "die Zahl ist zu klein: mindestens {least}",
        "missing": "es fehlt etwas. Alles ausfüllen",
    },
    "es": {
        "key_full": "llamadas abiertas de esta clave: {most}; no puede tener más. Anule una o espere a que llegue una",
        "key_full_at": "llamadas abiertas de esta clave para {place}: {most}; no puede tener más. Anule una o espere a que llegue una",
        "share_used": "nadie puede tener más de {most} llamadas abiertas. Espere a que llegue una",
        "too-many-transports": "hay demasiados transportes abiertos en la planta. Llame más tarde",
        "place_not_keeping": "{place} no tiene sitio para {item}",
        "no_other_storage": "ningún otro almacén guarda {item}",
        "only_items": "esta clave solo pide {items}",
        "load_too_large": "una carga de {item} es de {most} como máximo. Llame varias veces: {loads}",
        "item_is_product": "{item} es un producto: lo terminado se recoge por sí solo",
        "thing_place": "elija adónde o de dónde",
        "thing_ability": "elija como qué se lleva: {abilities}",
        "same_place": "ya está en {place}. Elija otro puesto",
        "ability_nobody": "ningún vehículo de esta planta lleva {carried}",
        "at_least": "el número es demasiado pequeño: {least} como mínimo",
        "missing": "falta algo. Rellénelo todo",
    },
}
"""Why nothing was called, by the code of the reason or the kind of problem; in English, and for all others, the reason itself."""
