import { Fact } from "../../../parts/Facts";
import { world } from "../../../stream/stream";
import { t, word } from "../../../text/views/faults";
import { busy, end, failed } from "./act";
import { faultsOf } from "./faults";

/** What was begun by hand and goes on, each with the way back. */
export function FaultFacts({ agent }: { agent: string }) {
  const faults = faultsOf(world.value?.faults.values() ?? [], agent);
  const complaint = failed.value?.agent === agent ? failed.value.text : "";
  return (
    <>
      {faults.map((fault) => {
        const what = word("fault.now", fault.kind);
        return (
          <Fact key={fault.id} name={t("fault.on")}>
            <span class="tone-warn">{what}</span>{" "}
            <button
              type="button"
              class="link"
              disabled={busy.value}
              aria-label={t("fault.endOf", { what })}
              onClick={() => void end(fault.id, agent)}
            >
              {t("fault.end")}
            </button>
          </Fact>
        );
      })}
      {complaint !== "" && (
        <dd class="fault-complaint">
          <span class="complaint" role="alert">
            {complaint}
          </span>
        </dd>
      )}
    </>
  );
}
