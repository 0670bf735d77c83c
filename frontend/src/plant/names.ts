/** Names that people use for what agents know by id. */
import type { PlantFile } from "../api/types";
import { t } from "../text";

export type Names = (id: string) => string;

/** The item of what has no master data (`dray.messages.THING`). */
export const THING = ".thing";

const SAME: Names = (id) => id;

/**
 * @param former what those are called that are not in the plant any more; their id if it is not known
 */
export function namesOf(plant: PlantFile | null, former: Names = SAME): Names {
  const items = [...(plant?.materials ?? []), ...(plant?.products ?? [])];
  const names = new Map(items.map((item) => [item.id, item.name]));
  return (id) => names.get(id) ?? (id === THING ? t("item.thing") : former(id));
}
