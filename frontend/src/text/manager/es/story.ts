/** What the management panel says of what is chosen, in Spanish. */
import type { Catalogue } from "../../catalogue";
import type { story as en } from "../en/story";

export const story: Catalogue<typeof en> = {
  "story.label": "Lo elegido",
  "story.none": "Elija algo en el plano o en una lista: se muestra junto todo lo que le pertenece.",
  "story.unknown": "En esta planta nada se llama {id}.",
  "story.transport": "Transporte",
  "story.production": "Orden de fabricación",
  "story.vehicle": "Vehículo",
  "story.standby": "Secundario",
  "story.machine": "Máquina",
  "story.place": "Lugar",
  "story.called": "Pedido como",
  "story.order": "Pedido",
  "story.follow": "Seguir",
  "story.followTitle": "El plano y las fichas van con lo elegido hasta que alguien mueva el plano",
  "story.copy": "Copiar enlace",
  "story.copied": "Copiado",
  "story.notCopied": "Tómelo de la barra de direcciones",
  "legend.open": "Leyenda",
  "legend.title": "Qué significan los signos del plano",
  "tour.again": "Mostrar el recorrido",
  "orderPage.show": "Mostrar en el plano",
};
