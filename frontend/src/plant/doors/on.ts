/** Which lanes the doors of a plant stand on. */
import type { PlantFile } from "../../api/types";

export type Door = PlantFile["doors"][number];
type Ends = Door["lanes"][number];

/** Whether a lane leads from here to there, in either direction. */
export const joins = ({ end, start }: Ends, from: string, to: string | undefined): boolean => (from === start && to === end) || (from === end && to === start);

/** The door that stands on a lane, in either direction. */
export function doorOn(doors: readonly Door[], { end, start }: Ends): Door | undefined {
  return doors.find(({ lanes }) => lanes.some((lane) => joins(lane, start, end)));
}
