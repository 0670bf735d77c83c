/** Why a transport that was called for waits, and why the vehicle that is to carry it does not come, in Spanish. */
import type { Catalogue } from "../../catalogue";
import type { waits as en } from "./en";

export const waits: Catalogue<typeof en> = {
  "calling.wait.no_room": "todavía no hay sitio",
  "calling.wait.short": "todavía no hay bastante",
  "calling.wait.no_bid": "todavía no puede ningún vehículo",
  "calling.wait.not_before": "aún no debe empezar",
  "calling.wait.undecided": "se está ofreciendo",
  "calling.shortage.free": "Libre en {place}: {free}.",
  "calling.shortage.coming": "Pedido para allí: {quantity}.",
  "calling.shortage.elsewhere": "Hay bastante en {places}.",
  "unwilling.gone": "ya no está",
  "unwilling.silent": "no se oye nada de él",
  "unwilling.shut_out": "está excluido",
  "unwilling.carried_away": "se lo han llevado",
  "unwilling.out_of_service": "está fuera de servicio",
  "unwilling.error": "tiene una avería",
  "unwilling.stopped": "está parado",
  "unwilling.busy": "está trabajando",
  "unwilling.battery": "su batería está demasiado baja",
  "unwilling.charging": "se le ha enviado a cargar",
  "unwilling.ability": "no puede llevar esto",
  "unwilling.no_way": "no encuentra camino",
  "unwilling.closed": "lo que está cerrado no le deja camino",
  "unwilling.deadline": "no podría llegar a tiempo",
  "unwilling.not_fit": "ahora no acepta trabajo",
  "unwilling.watching_enough": "ya vigila bastantes",
  "unwilling.is_primary": "ya lo lleva",
};
