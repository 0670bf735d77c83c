import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { AtvView } from "../../api/types";
import { world } from "../../stream/stream";
import { vehicleName } from "../../text/elsewhere";
import { t } from "../../text/operator";
import { give } from "../commands/given";
import { hindranceOf } from "../../commands/hindrance";
import { circumstancesOf } from "../state";

/** Long enough to take a slip of the finger back. */
const KEEP_MS = 3000;

/**
 * "It cannot be mended here": another vehicle is to carry its task. It asks no question; for some seconds the same place
 * says that it is being handed over, and one more touch keeps the task.
 */
export function HandOver({ atv }: { atv: AtvView }) {
  const task = atv.task ? world.value?.tasks.get(atv.task.task) : undefined;
  const next = task?.secondary ?? "";
  const aboard = task?.goods_aboard === true;
  return (
    <Leaving
      disabled={aboard || hindranceOf("hand_over", atv, circumstancesOf(atv)) !== null}
      text={(leaving) => handOverText(leaving, aboard, next)}
      onGone={() => void give(atv.id, { kind: "hand_over" })}
    />
  );
}

interface Props {
  readonly disabled: boolean;
  /** What becomes of the work, or how to keep it. */
  readonly text: (leaving: boolean) => string;
  readonly onGone: () => void;
}

/** A button that does what it says after some seconds, in which one more touch keeps things as they are. */
export function Leaving({ disabled, onGone, text }: Props) {
  const leaving = useSignal(false);
  const timer = useRef<number | undefined>(undefined);
  const touch = (): void => {
    clearTimeout(timer.current);
    leaving.value = !leaving.value;
    if (!leaving.value) return;
    timer.current = window.setTimeout(() => {
      leaving.value = false;
      onGone();
    }, KEEP_MS);
  };
  useEffect(() => () => {
    clearTimeout(timer.current);
  }, []);
  return (
    <button
      type="button"
      class={`button hand-over ${leaving.value ? "leaving" : ""}`}
      disabled={disabled}
      onClick={touch}
    >
      <b>{t(leaving.value ? "handOver.keep" : "handOver.now")}</b>
      <small>{text(leaving.value)}</small>
    </button>
  );
}

function handOverText(leaving: boolean, aboard: boolean, next: string): string {
  if (aboard) return t("handOver.aboard");
  if (leaving) return t("handOver.leaving");
  return next === "" ? t("handOver.auction") : t("handOver.to", { atv: vehicleName(next) });
}
