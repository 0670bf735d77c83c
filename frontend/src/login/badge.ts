/** A badge's reader types like a keyboard: its code logs in wherever the focus is, as after a touch beside the field, or with the PIN begun. */
import { NOTHING, pressed } from "../parts/scan";

/** The shortest code that a badge may have (`dray.gateway.access.login.secrets`). */
const CODE_CHARS = 8;
/** The longest PIN. */
const PIN_CHARS = 12;

/** Whether what was read is a badge's code. @param inPin whether it was typed into the PIN's field: a quick hand's digits are a PIN there */
export function isBadge(code: string, inPin: boolean): boolean {
  const isPin = inPin && /^\d*$/.test(code) && code.length <= PIN_CHARS;
  return code.length >= CODE_CHARS && !isPin;
}

export function addBadgeReader(): void {
  const badge = document.querySelector<HTMLInputElement>("#badge");
  const pin = document.querySelector<HTMLInputElement>("#secret");
  if (!badge || !pin) return;
  let scan = NOTHING;
  const onKey = (event: KeyboardEvent): void => {
    if (event.target === badge || event.target === document.querySelector("#name")) return;
    const [after, code] = pressed(scan, event.key, event.timeStamp);
    scan = after;
    if (code === null || !isBadge(code, event.target === pin)) return;
    event.preventDefault();
    pin.value = "";
    badge.value = code;
    badge.form?.requestSubmit();
  };
  document.addEventListener("keydown", onKey, true);
}
