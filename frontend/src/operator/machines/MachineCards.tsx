import { world } from "../../stream/stream";
import { t } from "../../text/operator";
import { moment } from "../state";
import { MachineCard } from "./MachineCard";
import { needingMachines } from "./need";

/** Machines of the area that need somebody, or are out of service. */
export function MachineCards() {
  const machines = needingMachines(world.value?.machines.values() ?? [], moment.value);
  if (machines.length === 0) return null;
  return (
    <ul class="cards needing" aria-label={t("cards.machines")}>
      {machines.map((machine) => (
        <MachineCard key={machine.id} machine={machine} />
      ))}
    </ul>
  );
}
