/** What is chosen stands in the address of the plant: it can be sent, and the browser goes back and forward over it. */
import { effect, signal } from "@preact/signals";
import { choose, type Chosen, lastChosen, selection, tellStories } from "../../selection/selection";
import { world } from "../../stream/stream";
import { followed, storyOf } from "./story";
import { learnTerms } from "./Term";
import { ask, asked, view } from "../views";

const KINDS = ["atv", "machine", "place", "task", "order"] as const;

/** Whether the map and the cards go along with what is chosen. */
export const following = signal(false);

export function saidOf({ id, kind }: Chosen): string {
  return `${kind}:${id}`;
}

export function chosenFrom(said = ""): Chosen | null {
  const cut = said.indexOf(":");
  const kind = KINDS.find((each) => each === said.slice(0, Math.max(0, cut)));
  const id = said.slice(cut + 1);
  return kind === undefined || id === "" ? null : { kind, id };
}

export function followSelection(): void {
  tellStories((before, chosen) => storyOf(world.peek(), before, chosen));
  // The address leads: it was opened, or the browser went back. It is read once there is a plant to read it by.
  const told = effect(() => {
    if (world.value !== null) queueMicrotask(() => { told(); followAddress(); learnTerms(); });
  });
}

function followAddress(): void {
  effect(() => {
    if (view.value !== "plant") return;
    const { at, follow } = asked.value;
    const chosen = chosenFrom(at);
    following.value = follow === "yes";
    const last = lastChosen(selection.peek());
    if (chosen !== null && (last === null || saidOf(last) !== saidOf(chosen))) choose(chosen);
    // Whoever comes from another view finds what was chosen before.
    if (chosen === null && last !== null) ask({ at: saidOf(last) }, "replace");
  });
  effect(() => {
    const chosen = lastChosen(selection.value);
    if (chosen === null || view.peek() !== "plant") return;
    const { at } = asked.peek();
    if (at !== saidOf(chosen)) ask({ at: saidOf(chosen) }, at === undefined ? "replace" : "step");
  });
  effect(() => {
    if (following.value) selection.value = followed(world.value, selection.peek());
  });
}

export function follow(on: boolean): void {
  ask({ follow: on ? "yes" : "" }, "replace");
}
