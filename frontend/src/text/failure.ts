/** Reasons in the reader's language. What this version does not know stays as it is. */
import type { CauseView, LackView } from "../api/types";
import { withNames } from "./elsewhere";
import { format, t, word } from "./index";
import { factoryTime } from "./plant-time";
import { waitText } from "./wait";

/** Words of vehicles and controllers in which something is filled in. */
const FILLED = [
  { says: /^cannot carry an? (?<ability>.+)$/, key: "failure.carry" },
  { says: /^(?<left>-?\d+)% would be left, (?<needed>\d+)% are needed$/, key: "failure.left" },
  { says: /^(?<time>\d+) s too late$/, key: "failure.late" },
  { says: /^(?<count>\d+) tasks$/, key: "failure.tasks" },
  { says: /^its controller is not heard: (?<why>.+)$/, key: "failure.notHeard" },
  { says: /^its controller has a fault: (?<what>.+)$/, key: "failure.fault" },
  { says: /^its controller has no value for (?<signal>\w+): (?<why>.+)$/, key: "failure.noValue" },
  { says: /^its controller does not take (?<signal>\w+): (?<why>.+)$/, key: "failure.notTaken" },
  { says: /^its controller refuses a permit \((?<signal>\w+)\): (?<why>.+)$/, key: "failure.permit" },
  { says: /^its count is in doubt: (?<why>.+)$/, key: "failure.doubt" },
  { says: /^its count is in doubt \((?<number>\d+)\): (?<why>.+)$/, key: "failure.doubtOf" },
] as const;

/** What somebody reports in words of their own; some of them are known here. */
export function failureText(said: string): string {
  for (const { says, key } of FILLED) {
    const found = says.exec(said);
    if (found) return t(key, found.groups as never);
  }
  return withNames(word("failure", said));
}

/** One of the reasons of the wire. */
export function reasonText(reason: string): string {
  return word("reason.why", reason);
}

/** Why something does not go on. */
export function causeText(cause: CauseView): string {
  const said = [whatText(cause), cause.detail === "" ? "" : failureText(cause.detail)].filter((each) => each !== "");
  const text = said.join("; ");
  return cause.times === 1 ? text : t("cause.times", { what: text, times: format.count(cause.times) });
}

/** The material that somebody waits for, as "Rotor (nothing in storage S3)". */
export function lacksText(lacks: readonly LackView[]): string {
  return format.list(lacks.map(lackText));
}

function whatText({ clock_ahead_s: aheadS, detail, handover, lacks, machines, not_made: products, reason, wait }: CauseView): string {
  if (products.length > 0) return t("cause.notMade", { products: format.list(products) });
  if (machines.length > 0) return format.list(machines.map((each) => t("cause.of", { agent: each.agent, what: reasonText(each.reason) })));
  if (lacks.length > 0) return lacksText(lacks);
  if (wait !== null) return waitText(wait);
  if (handover !== null) return t("cause.handover", { ...handover });
  if (aheadS !== 0) return t(aheadS < 0 ? "alerts.what.clock_behind" : "alerts.what.clock_ahead", { by: factoryTime(Math.abs(aheadS)) });
  // What a vehicle reports says more than that it reports something.
  return reason === "problem" && detail !== "" ? "" : reasonText(reason);
}

function lackText({ material, short, silent }: LackView): string {
  const reasons = [
    short.length > 0 ? t("cause.short", { storages: format.list(short) }) : "",
    silent.length > 0 ? t("cause.silentStation", { storages: format.list(silent) }) : "",
  ].filter((each) => each !== "");
  return reasons.length === 0 ? material : t("cause.lack", { material, reasons: format.list(reasons) });
}
