/** Where a vehicle can be put back. */
import type { AtvView, PlantFile } from "../api/types";
import { byId } from "./places";

type Standing = Pick<AtvView, "holds" | "id" | "node" | "removal">;

/** Parking places and chargers where no other vehicle is, or is about to be: those nearest to where it stood come first. */
export function freePlaces(plant: PlantFile | null, atvs: Iterable<Standing>, atv: Pick<AtvView, "id" | "x_m" | "y_m">): string[] {
  if (!plant) return [];
  const taken = new Set([...atvs].filter((each) => each.id !== atv.id && !each.removal).flatMap((each) => [each.node, ...each.holds]));
  const spots = new Map(plant.nodes.map((node) => [node.id, node]));
  const away = ({ node }: { node: string }): number => {
    const spot = spots.get(node);
    return spot ? Math.hypot(spot.x_m - atv.x_m, spot.y_m - atv.y_m) : Infinity;
  };
  const free = [...plant.parkings, ...plant.chargers].filter(({ node }) => !taken.has(node));
  return free.sort((one, other) => away(one) - away(other) || byId(one, other)).map(({ id }) => id);
}
