import type { ComponentChildren } from "preact";
import { speakAlso } from "../../../text/speech";
import { t, tables } from "../../../text/views/guide";

const disc = (sign: string, r = 6) => <circle cx="14" cy="10" {...{ r }} class={`sign-${sign}`} />;
const line = (sign: string) => <path d="M2 10h24" class={`sign-${sign}`} />;

/** The drawings are those of the map, in its colours. */
const SIGNS = [
  ["vehicle", disc("vehicle")],
  ["loaded", <>{disc("vehicle")}<rect x="11.5" y="7.5" width="5" height="5" class="sign-load" /></>],
  ["free", disc("free")],
  ["charging", <>{disc("charging")}<path d="M15 5.6l-3.8 5h2.6l-.8 3.8 3.8-5h-2.6z" class="sign-load" /></>],
  ["chosen", <>{disc("halo", 9)}{disc("chosen", 5)}</>],
  ["standby", <>{disc("standby", 9)}{disc("vehicle", 5)}</>],
  ["trouble", <>{disc("trouble")}<path d="M14 6.8v4M14 12.6v1" class="sign-trouble" /></>],
  ["silent", <>{disc("silent")}<path d="M12 8l4 4M16 8l-4 4" class="sign-trouble" /></>],
  ["radio", <>{disc("vehicle", 5)}<path d="M17.2 3.6a7 7 0 0 1 3 3.4M19 .8a10.5 10.5 0 0 1 4.2 4.8" class="sign-warn" /></>],
  ["machine", <rect x="5" y="3.5" width="18" height="13" rx="3" class="sign-machine" />],
  ["starved", <rect x="5" y="3.5" width="18" height="13" rx="3" class="sign-starved" />],
  ["way", line("way")],
  ["chosenWay", <><path d="M2 10h19" class="sign-chosen-way" /><circle cx="23" cy="10" r="3.5" class="sign-way-end" /></>],
  ["primary", line("primary")],
  ["watch", line("watch")],
  ["overdue", line("overdue")],
  ["mesh", line("mesh")],
  ["door", <path d="M14 1v18" class="sign-door" />],
  ["doorOpening", <path d="M14 1v6M14 13v6" class="sign-door sign-door-opening" />],
  ["doorOpen", <path d="M14 0v3M14 17v3" class="sign-door" />],
  ["doorFailed", <><path d="M14 10v10" class="sign-door sign-door-failed" /><circle cx="14" cy="7" r="6" class="sign-door-fault" /><path d="M11.5 4.5l5 5M16.5 4.5l-5 5" class="sign-door-cross" /></>],
  ["obstacle", <><path d="M14 2l8 15H6z" class="sign-obstacle" /><path d="M14 7v5M14 14v1.2" class="sign-exclamation" /></>],
  ["closed", <rect x="3" y="5" width="22" height="10" class="sign-closed" />],
] as const satisfies readonly (readonly [string, ComponentChildren])[];

/** The list of signs, once it has its words. */
export async function load(): Promise<typeof Signs> {
  await speakAlso(tables);
  return Signs;
}

/** What the signs of the map mean. */
export function Signs() {
  return (
    <ul class="legend-signs" aria-label={t("legend.title")}>
      {SIGNS.map(([name, drawing]) => (
        <li key={name}>
          <svg width="28" height="20" viewBox="0 0 28 20" aria-hidden="true">{drawing}</svg>
          <span>{t(`legend.${name}`)}</span>
        </li>
      ))}
    </ul>
  );
}
