/** What may go wrong by a person's hand: only a simulated factory's panel loads it. */
import { world } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { tables } from "../../../text/views/faults";
import { Later } from "../../../parts/Later";

interface OfAgent {
  readonly agent: string;
  readonly kind: "atv" | "machine";
}

const loadMenu = async () => {
  await speakAlso(tables);
  return (await import("./FaultMenu")).FaultMenu;
};
const loadFacts = async () => {
  await speakAlso(tables);
  return (await import("./FaultFacts")).FaultFacts;
};
const loadLaneMenu = async () => {
  await speakAlso(tables);
  return (await import("./LaneFaultMenu")).LaneFaultMenu;
};

const isSimulated = (): boolean => world.value?.fault_injection === true;

export function FaultMenu(of: OfAgent) {
  return isSimulated() && <Later load={loadMenu} of={of} />;
}

export function FaultFacts({ agent }: { agent: string }) {
  return isSimulated() && <Later load={loadFacts} of={{ agent }} />;
}

export function LaneFaultMenu() {
  return isSimulated() && <Later load={loadLaneMenu} />;
}
