/** Who waits for whom, in words. */
import type { WaitCauseView } from "../api/types";
import { vehicleName } from "./elsewhere";
import { format, t } from "./index";
import { placeOf } from "./place";

/** As "waits for ATV3, which waits for ATV7 at the dock of M8". */
export function waitText(cause: WaitCauseView): string {
  const { chain, kind, more } = cause;
  const last = chain.at(-1);
  if (last === undefined) return t(kind === "closed" ? "wait.noWay" : "wait.noAnswer");
  const others = chain.slice(0, -1).map(vehicleName);
  if (more > 0) others.push(t("wait.more", { n: format.count(more) }));
  return [...others, endText(last, cause)].map((who, i) => t(i === 0 ? "wait.for" : "wait.which", { who })).join("");
}

/** A jam: how many wait in it, and for whom in the end. */
export function jamText(vehicles: readonly string[], cause: WaitCauseView): string {
  const said = { n: format.count(vehicles.length), names: format.list(vehicles.map(vehicleName)) };
  const { chain, kind } = cause;
  if (kind === "circle") return t("wait.circle", { ...said, circle: [...chain, ...chain.slice(0, 1)].map(vehicleName).join(" → ") });
  return t("wait.jam", { ...said, who: endText(chain.at(-1) ?? "", cause) });
}

/** The one that holds up all others, and what holds it up. */
function endText(atv: string, { kind, place }: WaitCauseView): string {
  const who = vehicleName(atv);
  if (place !== "" && (kind === "docked" || kind === "charging" || kind === "standing")) return t(`wait.at.${kind}`, { who, place: placeOf(place) });
  return t(`wait.end.${kind}`, { who });
}
