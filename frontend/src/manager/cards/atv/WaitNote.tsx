import type { WaitView } from "../../../api/types";
import { Link } from "../../../parts/Link";
import { presentS, world } from "../../../stream/stream";
import { t } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";
import { waitText } from "../../../text/wait";

/** For whom a vehicle waits, as a sentence, and below it step by step with how long each has stood. */
export function WaitNote({ wait }: { wait: WaitView }) {
  const { cause, id } = wait;
  const last = cause.chain.length - 1;
  return (
    <div class="wait-note">
      <p>{t("wait.says", { atv: id, what: waitText(cause) })}</p>
      <ol>
        <Step id={id} sinceAtS={wait.since_at_s} />
        {cause.chain.map((each, i) => (
          <Step key={each} id={each} sinceAtS={world.value?.waits.get(each)?.since_at_s ?? (i === last ? cause.since_at_s : null)} />
        ))}
      </ol>
    </div>
  );
}

function Step({ id, sinceAtS }: { id: string; sinceAtS: number | null }) {
  const stoodS = sinceAtS === null ? null : Math.max(0, presentS.value - sinceAtS) * (world.value?.factory.speed ?? 1);
  return (
    <li>
      <Link kind="atv" id={id} /> <span class="num">{stoodS === null ? "" : factoryTime(stoodS)}</span>
    </li>
  );
}
