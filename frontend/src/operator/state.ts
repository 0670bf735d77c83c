/** What all parts of the operator panel share. */
import { computed, signal } from "@preact/signals";
import { nameItemsBy } from "../api/problem-words";
import type { PlantFile } from "../api/types";
import { namesOf } from "../plant/names";
import { isLost, type Seen } from "../plant/silence";
import { isPast } from "../stream/freshness";
import { freshness, presentS, world } from "../stream/stream";
import { format, t } from "../text/operator";
import type { Moment } from "./cards/need";
import type { Circumstances } from "../commands/hindrance";
import { ended, me } from "./session/session";

/** The part of the plant that the server shows this person. */
export const plant = signal<PlantFile | null>(null);
export const plantFailed = signal<string | null>(null);

/** Names of materials and products by id. */
export const names = computed(() => namesOf(plant.value));
nameItemsBy((id) => names.value(id));

/** The moment that is shown. */
export const moment = computed<Moment>(() => ({
  nowS: presentS.value,
  speed: world.value?.factory.speed ?? 1,
}));

/** The machine at which this person works. */
export const station = computed(() => plant.value?.machines.find(({ id }) => id === me.value?.station));

/** What the shown areas are called. */
export const placeName = computed(() => {
  const areas = plant.value?.areas ?? [];
  return areas.length === 0 || me.value?.areas === null ? t("top.plant") : format.list(areas.map(({ name }) => name));
});

export function circumstancesOf(atv: Seen): Circumstances {
  return {
    connected: !isPast(freshness.value) && freshness.value !== "connecting",
    ended: ended.value !== null,
    lost: isLost(atv, moment.value.nowS, moment.value.speed),
  };
}
