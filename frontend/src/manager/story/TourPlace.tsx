import { Later } from "../../parts/Later";
import { step } from "./tour";

const loadTour = async () => (await import("./guide/Tour")).load();

/** Where the tour stands, for who comes for the first time or asks for it. */
export function TourPlace() {
  return step.value === 0 ? null : <Later load={loadTour} />;
}
