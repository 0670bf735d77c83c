import type { AtvView, MachineView } from "../../../api/types";
import { Fact } from "../../../parts/Facts";
import { t } from "../../../text/manager";
import { updateText } from "./update-text";

/** The software of an agent that leaves or is on probation; of all others it is no matter. */
export function UpdateFact({ agent }: { agent: AtvView | MachineView }) {
  const update = updateText(agent);
  if (update === "") return null;
  return (
    <Fact name={t("fleet.software")}>
      {update}
      {agent.software !== "" && <small>{agent.software}</small>}
    </Fact>
  );
}
