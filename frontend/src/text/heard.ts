/** How long ago something was heard, by the factory's clock, as all other lengths of time of the plant are. */
import { world } from "../stream/stream";
import { format } from "./index";
import { factoryTime } from "./plant-time";

/** @param realS real seconds since then */
export function sinceHeard(realS: number, speed = world.value?.factory.speed ?? 1): string {
  return factoryTime(Math.max(0, realS) * speed, speed, "age");
}

/** The same where the head of a table says which clock it is. */
export function sinceHeardIn(realS: number, speed = world.value?.factory.speed ?? 1): string {
  return format.age(Math.max(0, realS) * speed);
}
