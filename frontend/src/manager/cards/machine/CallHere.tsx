import { useSignal } from "@preact/signals";
import { Later } from "../../../parts/Later";
import { t } from "../../../text/manager";
import { me } from "../../shell/session";

export interface Opened {
  readonly place: string;
  readonly end: "from" | "to";
  /** Of the opening: the form is shown anew each time. */
  readonly number: number;
}

const load = async () => (await import("../../pages/transports/CallSheet")).load();

/** Has something brought to the chosen place, or taken away from it: the form for it opens with that place in it. */
export function CallHere({ place }: { place: string }) {
  const opened = useSignal<Opened | null>(null);
  if (me.value?.scopes.includes("transports:call") !== true) return null;
  const open = (end: Opened["end"]): void => {
    opened.value = { place, end, number: (opened.value?.number ?? 0) + 1 };
  };
  return (
    <>
      <button type="button" class="button small" onClick={() => { open("to"); }}>
        {t("place.bring")}
      </button>
      <button type="button" class="button small" onClick={() => { open("from"); }}>
        {t("place.take")}
      </button>
      {opened.value && <Later load={load} of={opened.value} />}
    </>
  );
}
