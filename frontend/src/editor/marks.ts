/** Where the numbers of findings are written on the floor, and the labels of measures beside them. All in pixels from a spot, y down. */
import { chosenOf, spotOf, type Box, type Data, type Spot } from "./model";

/** A number's disc lies beside its spot. */
export const NUMBER = { x: 14, y: -14, r: 9 } as const;
export const LABEL = { width: 52, height: 18 } as const;

export interface Mark {
  readonly key: string;
  readonly number: number;
  readonly spot: Spot;
}

/** The number of the first finding of each thing that is drawn. */
export function marksOf(findings: readonly { readonly field: string }[], data: Data): Mark[] {
  const first = new Map<string, Mark>();
  findings.forEach(({ field }, index) => {
    const about = chosenOf(field);
    const key = about && `${about.section}[${about.index}]`;
    const spot = about && spotOf(data, about);
    if (key && spot && !first.has(key)) first.set(key, { key, number: index + 1, spot });
  });
  return [...first.values()];
}

/** Of a letter, as part of its height: names of the floor are mostly capitals. */
const LETTER_FRAC = 0.68;
/** Half of the square that stands for a place without a box. */
const NO_BOX_M = 0.5;

/**
 * From the middle of a place down to where its name is written, in metres: in its box, or below it where the name would stand
 * over its edges, or over the node of a place that has no box yet.
 */
export function nameBelow(name: string, box: Box | null | undefined, size_m: number): number {
  const fits = box && name.length * LETTER_FRAC * size_m <= box.width_m;
  return fits ? 0.35 * size_m : (box ? box.depth_m / 2 : NO_BOX_M) + size_m;
}

interface Point {
  readonly x: number;
  readonly y: number;
}

/** Where a label's middle may be, from that of its measure: the nearest first. */
const PLACES: readonly Point[] = [17, 38, 60].flatMap((away) => [
  { x: 0, y: away },
  { x: 0, y: -away },
  { x: 18 + away, y: 0 },
  { x: -18 - away, y: 0 },
]);

/** Labels that cover neither a number nor one another, as far as there is room.
 *
 * @param middles of the measures, in pixels.
 * @param numbers the spots of all numbers, in pixels.
 * @returns the middle of each label, from the middle of its measure.
 */
export function labelPlaces(middles: readonly Point[], numbers: readonly Point[]): Point[] {
  const taken: Point[] = [];
  return middles.map((middle) => {
    const free = PLACES.find(({ x, y }) => {
      const at = { x: middle.x + x, y: middle.y + y };
      const onNumber = numbers.some((number) => near(at, { x: number.x + NUMBER.x, y: number.y + NUMBER.y }, LABEL.width / 2 + NUMBER.r, LABEL.height / 2 + NUMBER.r));
      return !onNumber && !taken.some((other) => near(at, other, LABEL.width, LABEL.height));
    });
    const place = free ?? { x: 0, y: 17 };
    taken.push({ x: middle.x + place.x, y: middle.y + place.y });
    return place;
  });
}

const near = (one: Point, other: Point, x: number, y: number): boolean => Math.abs(one.x - other.x) < x && Math.abs(one.y - other.y) < y;
