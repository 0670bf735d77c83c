import { Later } from "../../../parts/Later";
import type { Printing } from "./PrintAll";

/** Prints all that a list finds. */
export function PrintButton({ of }: { of: Printing }) {
  return <Later<Printing> load={async () => (await import("./PrintAll")).load()} of={of} />;
}
