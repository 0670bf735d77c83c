import type { FunctionComponent } from "preact";
import { useSignal, useSignalEffect } from "@preact/signals";
import { Later } from "../../../parts/Later";
import { nowS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, n, t, tables } from "../../../text/views/kept";
import { asked } from "../../views";
import { earliestS, fetchKept, type Kept, reachOf } from "./kept";

interface Props {
  kind: "tasks" | "alerts" | "audit" | "replay" | "figures";
  /** The earliest moment that is asked for. */
  fromS: number;
}

/** Says that a list or a picture is asked for what is no longer kept, or for what was before all there is. */
export function KeptNote(props: Props) {
  return <Later<Props> load={loadNote} of={props} />;
}

/** The same for a list whose times stand in the address. */
export function ListKeptNote({ kind }: Pick<Props, "kind">) {
  const fromS = earliestS(asked.value.since, asked.value.until);
  return fromS === null ? null : <KeptNote kind={kind} fromS={fromS} />;
}

async function loadNote(): Promise<FunctionComponent<Props>> {
  await speakAlso(tables);
  return Note;
}

function Note({ fromS, kind }: Props) {
  const kept = useSignal<Kept | undefined>(undefined);
  useSignalEffect(() => {
    // Whoever cannot be told what is kept still sees the list.
    fetchKept().then((found) => { kept.value = found.find((each) => each.kind === kind); }, () => undefined);
  });
  const reach = kept.value && reachOf(kept.value, fromS);
  if (kept.value?.days === 0) return <p class="table-hint" role="status">{t("kept.replayOff")}</p>;
  // Figures of a shift in which they began are those of its rest.
  if (!reach || (kind === "figures" && reach.how === "begins")) return null;
  const at = format.when(reach.atS, nowS.value);
  return (
    <p class="table-hint kept-note" role="status">
      {reach.how === "begins" ? t("kept.begins", { at }) : t(`kept.gone.${kind}`, { at, days: n("kept.days", kept.value?.days ?? 0, format.count(kept.value?.days ?? 0)) })}
    </p>
  );
}
