/** The login without a script is whole; this makes it quicker where somebody has logged in before, or wears gloves. */
import "@fontsource-variable/inter/wght.css";
import "../styles/tokens.css";
import "./page.css";
import "./call.css";
import { addBadgeReader } from "./badge";
import { addPinPad } from "./pin-pad";

/** Who is known needs no name; somebody else does. */
function followChoice(): void {
  const name = document.querySelector<HTMLInputElement>("#name");
  const choices = document.querySelectorAll<HTMLInputElement>('input[name="known"]');
  if (!name || choices.length === 0) return;
  const follow = (): void => {
    const other = document.querySelector<HTMLInputElement>('input[name="known"]:checked')?.value === "";
    name.closest<HTMLElement>(".who")?.toggleAttribute("hidden", !other);
    name.required = other;
    if (!other) name.value = "";
  };
  for (const each of choices) each.addEventListener("change", follow);
  // Typed before this came: somebody else is meant.
  if (name.value.trim() !== "") for (const each of choices) each.checked = each.value === "";
  follow();
}

followChoice();
addPinPad();
addBadgeReader();
