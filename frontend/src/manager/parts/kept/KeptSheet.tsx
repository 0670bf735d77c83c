import { useSignal } from "@preact/signals";
import { nowS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, n, t, tables } from "../../../text/views/kept";
import { problemText } from "../../problem-text";
import { Sheet } from "../Sheet";
import { fetchKept, type Kept } from "./kept";

const ID = "kept-sheet";

/** The button and its sheet, once they have their words. */
export async function load(): Promise<typeof KeptSheet> {
  await speakAlso(tables);
  return KeptSheet;
}

/** What is kept for how long, since when something of it is there, and what sets it. */
export function KeptSheet() {
  const kinds = useSignal<readonly Kept[]>([]);
  const failed = useSignal("");
  const ask = (): void => {
    fetchKept().then(
      (found) => { kinds.value = found; failed.value = ""; },
      (error: unknown) => { failed.value = problemText(error); },
    );
  };
  return (
    <>
      <button type="button" class="button" popovertarget={ID} onClick={ask}>
        {t("kept.open")}
      </button>
      <Sheet id={ID} title={t("kept.title")}>
        <p class="muted">{t("kept.hint")}</p>
        {failed.value !== "" && <p class="complaint" role="alert">{t("kept.failed", { reason: failed.value })}</p>}
        <table>
          <thead>
            <tr>
              {(["what", "for", "since", "setting"] as const).map((head) => <th key={head} scope="col">{t(`kept.${head}`)}</th>)}
            </tr>
          </thead>
          <tbody>{kinds.value.map((each) => <Row key={each.kind} kept={each} />)}</tbody>
        </table>
        {kinds.value.some(({ is_full }) => is_full) && <p class="tone-warn">{t("kept.full")}</p>}
      </Sheet>
    </>
  );
}

function Row({ kept: { days, kind, setting, since_at_s: sinceS } }: { kept: Kept }) {
  return (
    <tr>
      <th scope="row">{t(`kept.of.${kind}`)}</th>
      <td>{daysText(days)}</td>
      <td class="num">{sinceS === null ? t("kept.nothing") : format.when(sinceS, nowS.value)}</td>
      <td><code>{setting}</code></td>
    </tr>
  );
}

function daysText(days: number | null): string {
  if (days === null) return t("kept.always");
  return days === 0 ? t("kept.notAtAll") : n("kept.days", days, format.count(days));
}
