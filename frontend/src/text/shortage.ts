/** For what material somebody waits, in the reader's language; what this version does not know stays as it is. */
import { format, t } from "./index";

const FOR = /^for (.+)$/;

/** As "Rotor (storage S3 has none and storages S4, S5 do not answer)". */
const MATERIAL = /^(.+) \((.+)\)$/;

const REASON = /^storages? (.+) (?:(has|have) none|(?:does|do) not answer)$/;

/** The material that an order waits for, as "Rotor (nothing in storage S3)"; empty when it waits for something else. */
export function shortageText(waits: string): string {
  const told = FOR.exec(waits)?.[1];
  return told === undefined ? "" : format.list(told.split("; ").map(materialText));
}

function materialText(told: string): string {
  const [, material = "", reasons = ""] = MATERIAL.exec(told) ?? [];
  if (material === "") return told;
  return t("shortage.material", { material, reasons: format.list(reasons.split(" and ").map(reasonText)) });
}

function reasonText(told: string): string {
  const [, storages = "", lacks] = REASON.exec(told) ?? [];
  if (storages === "") return told;
  const named = { storages: format.list(storages.split(", ")) };
  return lacks === undefined ? t("shortage.silent", named) : t("shortage.none", named);
}
