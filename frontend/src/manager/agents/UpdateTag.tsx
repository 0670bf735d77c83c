import type { AtvView, MachineView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { t } from "../../text/manager";

/** Where an agent is in the change of its software: it leaves, or it is on trial; nothing for all others. */
export function UpdateTag({ agent }: { agent: AtvView | MachineView }) {
  if (agent.leaving) return <Tag>{t("agent.leaving")}</Tag>;
  return agent.trial && <Tag>{t("agent.trial", { done: agent.trial.done, of: agent.trial.of })}</Tag>;
}
