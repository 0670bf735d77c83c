import { Later } from "../../parts/Later";
import type { components } from "../../api/types";

export interface Faults {
  readonly faults: readonly components["schemas"]["RowFault"][];
}

/** What is wrong with a spreadsheet, row by row; nothing where nothing is. */
export function RowFaults({ faults }: Faults) {
  return faults.length === 0 ? null : <Later<Faults> load={async () => (await import("./rows/FaultTable")).load()} of={{ faults }} />;
}
