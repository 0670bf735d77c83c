/** The operator panel in Spanish. */
import type { Catalogue } from "../catalogue";
import { es as shared } from "../shared/es";
import type { en } from "./en";

export const es: Catalogue<typeof en> = {
  ...shared,

  "app.title": "Dray – puesto",
  "skip.toVehicles": "Saltar a los vehículos",

  "top.plant": "Toda la planta",
  "top.station": "{id} · {name}",
  "settings.title": "Ajustes",
  "settings.logOut": "Cerrar sesión",

  "area.title": "Zona",
  "area.label": "Plano de {name}. Las flechas lo mueven, más y menos acercan y alejan, 0 muestra toda la zona. Todos los vehículos están también en la lista.",

  "banner.ended": "Su sesión ha terminado. Parar sigue funcionando; lo demás espera hasta que vuelva a entrar.",
  "banner.logIn": "Entrar",
  "banner.offline": "Sin conexión con la planta. Lo que ve tiene {age}; ahora no se puede enviar ninguna orden.",
  "banner.offlineEmpty": "Sin conexión con la planta, y aún no se ha oído nada de ella. Mire los vehículos mismos.",
  "banner.stale": "No se ha oído nada desde hace {age}. Los vehículos pueden estar ya en otro sitio.",
  "banner.inDanger": "En caso de peligro, use el botón del vehículo.",
  "loading": "Buscando su zona",
  "failed": "No se pudo cargar su zona: {reason}",

  "cards.needing": "Vehículos que necesitan a alguien",
  "cards.well": "Vehículos en {name}",
  "cards.none": "No hay ningún vehículo en su zona.",
  "card.away": "{metres} m",
  "card.battery": "batería {percent}",
  "card.mesh": "por radio",
  "card.in": "en {area}",
  "card.going": "{quantity} {item} a {destination}",
  "card.fetching": "recoge {quantity} {item} para {destination}",
  "card.bringing": "devuelve {quantity} {item}",
  "card.there": "llega a las {at}",
  "card.noTask": "sin tarea",
  "card.loaded": "{quantity} {item} a bordo",
  "card.lost": "Oído por última vez hace {age}. Puede haber seguido. Solo se intenta Parar.",

  "phase.approaching": "recogiendo",
  "phase.returning": "devolviendo",
  "need.help": "pide ayuda",
  "need.coming": "la ayuda viene",
  "need.problem": "tiene un problema",
  "need.lost": "mudo",
  "need.stopped": "parado",

  "help.what": "Comunica: {problem}.",
  "help.waits": "hasta que la asuma otro vehículo",
  "help.over": "Ha esperado bastante: su tarea pasa a otro vehículo.",
  "help.coming": "espera su tarea; {by} está de camino",
  "help.noTask": "Ninguna tarea le espera.",
  "help.onMyWay": "Voy de camino",
  "help.later": "Tardo más",
  "help.in": "{minutes} min",
  "help.there": "Voy de camino a {atv}, llego en",

  "stop.label": "Parar vehículo",
  "stop.not": "No es una parada de emergencia: en caso de peligro, use el botón del vehículo.",
  "stop.dock": "Parar, para cada vehículo cercano",

  "release.title": "Para que {atv} siga",
  "release.acknowledge": "Fallo resuelto",
  "release.acknowledged": "Confirmado",
  "release.resume": "Seguir",
  "release.hold": "mantener pulsado",
  "release.stopFirst": "Párelo antes de meter las manos: resuelto el fallo, sigue por sí solo.",
  "release.first": "Nada se mueve hasta que diga que el fallo está resuelto y luego pulse Seguir.",
  "release.next": "Apártese: con Seguir arranca por sí solo.",
  "release.fault": "Aún comunica: {problem}. Resuélvalo y dígalo aquí.",

  "steps.title": "Límite de velocidad de {atv}",
  "steps.stepLabel": "Como máximo el {percent} de su propia velocidad máxima",

  "command.stop": "Parar",
  "command.acknowledge": "Confirmar",
  "command.resume": "Seguir",
  "command.set_speed": "Velocidad {percent}",
  "command.promise": "De camino",
  "stage.sent": "enviado",
  "stage.accepted": "aceptado",
  "stage.confirmed": "confirmado por el vehículo",
  "stage.refused": "rechazado",
  "stage.not_confirmed": "sin confirmar",
  "command.by": "por {by}",
  "command.said": "{atv}: {what} {stage}",
  "command.unreachable": "la planta no responde. Mire el vehículo.",
  "command.silent": "el vehículo no responde: puede haberlo oído o no. Mírelo.",
  "command.ended": "su sesión ha terminado.",

  "refusal.acknowledge the stop first": "el fallo aún no está confirmado",
  "refusal.faulty": "sus sensores aún comunican: {problem}",
  "refusal.it is not stopped": "no está parado",
  "refusal.it has no task that waits for help": "ninguna tarea suya espera ayuda",

  "station.title": "Material",
  "station.none": "Elija una máquina en el plano para ver su material.",
  "station.coming": "+{quantity} con {atv}, {at}",
  "station.comingBy": "+{quantity} con {atv}",
  "station.ordered": "+{quantity} pedidos, aún no los lleva nadie",
  "station.unheard": "Aún no se ha oído nada de esta máquina.",

};
