/** Digits to touch, below the field for the PIN. The field stays what is sent, and takes a keyboard's digits too. */

const DIGITS = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "0"];

export function addPinPad(): void {
  const field = document.querySelector<HTMLInputElement>(".by-pin #secret");
  if (!field) return;
  // The tablet's own keyboard would cover the pad.
  field.inputMode = "none";
  const pad = document.createElement("div");
  pad.className = "pad";
  const add = (text: string, label: string, change: (typed: string) => string): void => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = text;
    button.setAttribute("aria-label", label);
    button.addEventListener("click", () => {
      field.value = change(field.value).slice(0, field.maxLength);
    });
    pad.append(button);
  };
  for (const digit of DIGITS) add(digit, digit, (typed) => typed + digit);
  add("\u232b", field.dataset.delete ?? "", (typed) => typed.slice(0, -1));
  field.after(pad);
}
