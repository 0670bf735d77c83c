import { commandMachine, commandStation } from "../../../api/client";
import type { DoubtView } from "../../../api/types";
import { vehicleName } from "../../../text/elsewhere";
import { format, t } from "../../../text/manager";
import { names } from "../../state";
import { IsThere } from "../auction/LoadSeen";

interface Asking {
  /** The machine or station that asks. */
  readonly agent: string;
  readonly station: boolean;
  readonly doubts: readonly DoubtView[];
}

/** Loads of which nobody can tell whether they lie here: whoever has counted says so. */
export function Doubts({ agent, doubts, station }: Asking) {
  return doubts.map(({ brought, item, load: task, quantity, vehicle }) => (
    <IsThere
      key={task}
      ask={t(brought ? "doubt.brought" : "doubt.taken", { quantity: format.count(quantity), item: names.value(item), atv: vehicleName(vehicle) })}
      say={async (there) => {
        const answer = { kind: there ? "load_there" : "load_missing", task } as const;
        return await (station ? commandStation(agent, answer) : commandMachine(agent, answer));
      }}
    />
  ));
}
