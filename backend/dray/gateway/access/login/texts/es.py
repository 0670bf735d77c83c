"""Spanish."""

from __future__ import annotations

from dray.gateway.access.login.texts.catalogue import Catalogue

ES = Catalogue(
    languages="Idioma",
    skip="Ir al inicio de sesión",
    title="Iniciar sesión",
    manager_heading="Panel de gestión",
    operator_heading="Panel de operario",
    id="Nombre",
    id_hint="tal como se lo dieron",
    known="¿Quién es usted?",
    somebody_else="Otra persona",
    password="Contraseña",  # noqa: S106 - a label
    pin="PIN",
    pin_hint="seis cifras o más",
    pin_delete="Borrar la última cifra",
    badge="Tarjeta",
    badge_hint="Acerque la tarjeta al lector",
    submit="Entrar",
    to_operator="Trabajo en un puesto",
    to_manager="Dirijo la planta",
    wrong_pin="No coincide: el nombre o el PIN es incorrecto. Revise ambos e inténtelo de nuevo.",
    wrong_password="No coincide: el nombre o la contraseña es incorrecta. Revise ambos e inténtelo de nuevo.",  # noqa: S106 - a sentence
    wrong_badge="Esta tarjeta no da acceso. Inténtelo de nuevo, o entre con nombre y PIN.",
    too_many="Demasiados intentos. Inténtelo de nuevo en {wait}.",
    seconds="{n} s",
    minutes="{n} min",
    busy="Demasiadas personas entran en este momento. Inténtelo dentro de unos segundos.",
    away="La base de datos no responde en este momento. Inténtelo dentro de unos segundos.",
    link_heading="Hola, {name}",
    link_note="Este enlace le da acceso una sola vez, en este dispositivo.",
    link_submit="Entrar",
    gone_heading="Este enlace ya no da acceso",
    gone_note="Ya se usó o es demasiado antiguo. Pida uno nuevo.",
    unknown_heading="Aquí no hay ninguna página",
    unknown_note="La dirección está mal escrita o la página ya no existe.",
    unknown_back="Ir a la página de inicio",
    unknown_skip="Saltar al contenido",
    station_heading="¿Dónde trabaja ahora?",
    station_note="Solo puede estar en un puesto a la vez; en los demás se ha cerrado su sesión.",
    no_station="No hay ninguna máquina en sus áreas.",
    without_station="Seguir sin puesto",
    help="¿Sin acceso? Quien se ocupa de Dray puede darle un enlace.",
)
