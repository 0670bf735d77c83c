/** Where an agent is in the change of its software, in words: it leaves, or it is on trial; nothing for all others. */
import type { AtvView, MachineView } from "../../api/types";
import { t } from "../../text/manager";

export function updateText(agent: AtvView | MachineView): string {
  if (agent.leaving) return t("agent.leaving");
  return agent.trial ? t("agent.trial", { done: agent.trial.done, of: agent.trial.of }) : "";
}
