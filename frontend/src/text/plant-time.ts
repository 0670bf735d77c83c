/** Lengths of time on the factory's clock; where it runs otherwise than the one on the wall, they say so. */
import { world } from "../stream/stream";
import { format, t } from "./index";

/** Factory seconds per real second. */
function clockSpeed(): number {
  return world.value?.factory.speed ?? 1;
}

/** What passes on the factory's clock in so many seconds of the clock on the wall. */
export function factorySeconds(wallS: number, speed = clockSpeed()): number {
  return wallS * speed;
}

/**
 * @param speed factory seconds per real second, where it is not that of the plant as it is now
 * @param as how it is written: a price has tenths, and so has a short age
 */
export function factoryTime(seconds: number, speed = clockSpeed(), as: "age" | "duration" | "price" = "duration"): string {
  const time = format[as](seconds);
  return speed === 1 ? time : t("time.factory", { time });
}

/** The head of figures that are all of the factory's clock. */
export function inFactoryTime(head: string, speed = clockSpeed()): string {
  return speed === 1 ? head : t("time.inFactory", { head });
}

/** A text with figures that are all of the factory's clock, and the sentence that says so. */
export function ofFactoryTime(text: string, speed = clockSpeed()): string {
  return speed === 1 ? text : `${text} ${t("time.allFactory")}`;
}
