/** What somebody does, in words. */
import { t, word } from "../../../text/views/replay";
import { names, placeOf } from "../../state";
import type { Spell } from "./strips";

export function doingText(spell: Spell): string {
  const { doing, item, other } = spell;
  if (doing === "waits" && other !== "") return t("doing.waitsFor", { other });
  if (doing === "idle" && other !== "") return t("doing.watches", { other });
  if (doing === "starves" && other !== "") return t("doing.starvesFor", { other: names.value(other) });
  if (item === "" || !["fetches", "carries", "makes"].includes(doing)) return word("doing", doing);
  const load = names.value(item);
  const to = doing === "fetches" ? spell.source : spell.destination;
  return `${t("doing.load", { doing: word("doing", doing), item: load })}${to === "" ? "" : ` → ${placeOf(to)}`}`;
}
