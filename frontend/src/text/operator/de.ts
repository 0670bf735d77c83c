/** The operator panel in German. */
import type { Catalogue } from "../catalogue";
import { de as shared } from "../shared/de";
import type { en } from "./en";

export const de: Catalogue<typeof en> = {
  ...shared,

  "app.title": "Dray – Station",
  "skip.toVehicles": "Zu den Fahrzeugen springen",

  "top.plant": "Ganzes Werk",
  "top.station": "{id} · {name}",
  "settings.title": "Einstellungen",
  "settings.logOut": "Abmelden",

  "area.title": "Bereich",
  "area.label": "Plan von {name}. Pfeiltasten verschieben, Plus und Minus zoomen, 0 zeigt den ganzen Bereich. Alle Fahrzeuge stehen auch in der Liste.",

  "banner.ended": "Ihre Sitzung ist abgelaufen. Stopp geht weiterhin; alles andere wartet, bis Sie sich wieder anmelden.",
  "banner.logIn": "Anmelden",
  "banner.offline": "Keine Verbindung zum Werk. Was Sie sehen, ist {age} alt; Befehle können jetzt nicht gesendet werden.",
  "banner.offlineEmpty": "Keine Verbindung zum Werk, und noch nichts von ihm gehört. Sehen Sie nach den Fahrzeugen selbst.",
  "banner.stale": "Seit {age} nichts gehört. Die Fahrzeuge können inzwischen woanders stehen.",
  "banner.inDanger": "Bei Gefahr den Knopf am Fahrzeug drücken.",
  "loading": "Ihr Bereich wird gesucht",
  "failed": "Ihr Bereich konnte nicht geladen werden: {reason}",

  "cards.needing": "Fahrzeuge, die jemanden brauchen",
  "cards.well": "Fahrzeuge in {name}",
  "cards.none": "Kein Fahrzeug ist in Ihrem Bereich.",
  "card.away": "{metres} m",
  "card.battery": "Akku {percent}",
  "card.mesh": "über Funk",
  "card.in": "in {area}",
  "card.going": "{quantity} {item} zu {destination}",
  "card.fetching": "holt {quantity} {item} für {destination}",
  "card.bringing": "bringt {quantity} {item} zurück",
  "card.there": "da um {at}",
  "card.noTask": "kein Auftrag",
  "card.loaded": "{quantity} {item} geladen",
  "card.lost": "Zuletzt vor {age} gehört. Es kann weitergefahren sein. Nur Stopp wird noch versucht.",

  "phase.approaching": "holt",
  "phase.returning": "bringt zurück",
  "need.help": "bittet um Hilfe",
  "need.coming": "Hilfe kommt",
  "need.problem": "hat ein Problem",
  "need.lost": "stumm",
  "need.stopped": "gestoppt",

  "help.what": "Es meldet: {problem}.",
  "help.waits": "bis ein anderes Fahrzeug übernimmt",
  "help.over": "Es hat lange genug gewartet: Sein Auftrag geht an ein anderes Fahrzeug.",
  "help.coming": "wartet sein Auftrag; {by} ist unterwegs",
  "help.noTask": "Kein Auftrag wartet auf es.",
  "help.onMyWay": "Ich bin unterwegs",
  "help.later": "Es dauert länger",
  "help.in": "{minutes} min",
  "help.there": "Ich bin unterwegs zu {atv}, da in",

  "stop.label": "Fahrzeug stoppen",
  "stop.not": "Kein Not-Halt: Bei Gefahr den Knopf am Fahrzeug drücken.",
  "stop.dock": "Stopp für jedes Fahrzeug in der Nähe",

  "release.title": "Damit {atv} weiterfährt",
  "release.acknowledge": "Fehler ist behoben",
  "release.acknowledged": "Quittiert",
  "release.resume": "Weiter",
  "release.hold": "gedrückt halten",
  "release.stopFirst": "Stoppen Sie es, bevor Sie hineingreifen: Ist der Fehler weg, fährt es von selbst weiter.",
  "release.first": "Nichts bewegt sich, bis Sie sagen, dass der Fehler behoben ist, und dann Weiter drücken.",
  "release.next": "Halten Sie Abstand: Mit Weiter fährt es von selbst los.",
  "release.fault": "Es meldet noch: {problem}. Beheben Sie das, dann sagen Sie es hier.",

  "steps.title": "Tempolimit von {atv}",
  "steps.stepLabel": "Höchstens {percent} seiner eigenen Höchstgeschwindigkeit",

  "command.stop": "Stopp",
  "command.acknowledge": "Quittieren",
  "command.resume": "Weiter",
  "command.set_speed": "Tempo {percent}",
  "command.promise": "Unterwegs",
  "stage.sent": "gesendet",
  "stage.accepted": "angenommen",
  "stage.confirmed": "vom Fahrzeug bestätigt",
  "stage.refused": "abgelehnt",
  "stage.not_confirmed": "nicht bestätigt",
  "command.by": "von {by}",
  "command.said": "{atv}: {what} {stage}",
  "command.unreachable": "keine Antwort vom Werk. Sehen Sie nach dem Fahrzeug.",
  "command.silent": "keine Antwort vom Fahrzeug: Vielleicht hat es gehört, vielleicht nicht. Sehen Sie nach.",
  "command.ended": "Ihre Sitzung ist abgelaufen.",

  "refusal.acknowledge the stop first": "der Fehler ist noch nicht quittiert",
  "refusal.faulty": "seine Sensoren melden noch: {problem}",
  "refusal.it is not stopped": "es ist nicht gestoppt",
  "refusal.it has no task that waits for help": "keiner seiner Aufträge wartet auf Hilfe",

  "station.title": "Material",
  "station.none": "Wählen Sie im Plan eine Maschine, um ihr Material zu sehen.",
  "station.coming": "+{quantity} mit {atv}, {at}",
  "station.comingBy": "+{quantity} mit {atv}",
  "station.ordered": "+{quantity} bestellt, noch trägt es niemand",
  "station.unheard": "Von dieser Maschine wurde noch nichts gehört.",

};
