/** Where an agent is in the change of its software, in words: it leaves, or it is on probation; nothing for all others. */
import type { AtvView, MachineView } from "../../../api/types";
import { t } from "../../../text/manager";

export function updateText(agent: AtvView | MachineView): string {
  if (agent.draining) return t("agent.draining");
  return agent.probation ? t("agent.probation", { done: agent.probation.done, of: agent.probation.of }) : "";
}
