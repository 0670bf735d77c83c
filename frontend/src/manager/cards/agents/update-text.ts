/** Where an agent is in the change of its software, in words: it leaves, is out of service, or on probation; nothing for all others. */
import type { AtvView, MachineView } from "../../../api/types";
import { t } from "../../../text/manager";

export function updateText(agent: AtvView | MachineView): string {
  if (agent.draining) return t("agent.draining");
  const out = "out_of_service" in agent ? agent.out_of_service : null;
  if (out) return t("agent.outOfService", { by: out.by, reason: out.reason });
  return agent.probation ? t("agent.probation", { done: agent.probation.done, of: agent.probation.of }) : "";
}
