/** How much is drawn at which scale: what would be too small to read is left out. */

export interface Detail {
  /** Radius of a vehicle on the screen. */
  readonly vehiclePx: number;
  /** Nose, load, battery: from where a vehicle is more than a dot. */
  readonly vehicleParts: boolean;
  readonly vehicleLabels: boolean;
  readonly placeLabels: boolean;
  /** Buffers and product inside a machine's box. */
  readonly machineParts: boolean;
  readonly laneMarks: boolean;
  /** Faint ways and links of everybody, not only of the chosen. */
  readonly everybody: boolean;
}

/** Drawn a little larger than life, so that it can be seen and hit. */
const VEHICLE_RADIUS_M = 0.95;
/** Lines of more than these would cover the floor: a plant of 50 vehicles has some 200. */
export const LINES_MOST = 30;
/** Of more than these at once no names are drawn. */
const NAMES_MOST = 240;

/** @param all whether somebody wants the lines of everybody, however many there are */
export function detailOf(scale: number, vehiclesInSight: number, all = false): Detail {
  const vehiclePx = Math.min(15, Math.max(3, VEHICLE_RADIUS_M * scale));
  return {
    vehiclePx,
    vehicleParts: vehiclePx >= 6,
    vehicleLabels: vehiclePx >= 6.5 && vehiclesInSight <= NAMES_MOST,
    placeLabels: scale >= 4,
    machineParts: scale >= 7,
    laneMarks: scale >= 14,
    everybody: all || vehiclesInSight <= LINES_MOST,
  };
}
