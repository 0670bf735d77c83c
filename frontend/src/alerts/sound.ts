/** Two short tones for what asks for an answer, where somebody has asked for them in this browser. */
import { signal } from "@preact/signals";
import { recall, remember } from "../memory";

/** Why the browser plays none: it waits for a click on the page, or has no sound at all; empty where it does. */
export type SoundRefusal = "" | "mute" | "noSound";

const KEY = "dray.tell.sound";

export const soundWanted = signal(recall(KEY) === "yes");
/** Whether somebody has chosen, either way. */
export const soundChosen = signal(recall(KEY) !== null);
export const soundRefusal = signal<SoundRefusal>("");

let audio: AudioContext | null = null;

/** To be called by a click only: browsers begin to play by nothing else. */
export async function wantSound(on: boolean): Promise<void> {
  soundRefusal.value = on ? await wake() : "";
  soundWanted.value = on && soundRefusal.value === "";
  soundChosen.value = true;
  remember(KEY, soundWanted.value ? "yes" : "no");
  if (soundWanted.value) playSound();
}

async function wake(): Promise<SoundRefusal> {
  if (typeof AudioContext === "undefined") return "noSound";
  audio ??= new AudioContext();
  await audio.resume();
  return audio.state === "running" ? "" : "mute";
}

/** The second tone is higher: heard in a hall and in a control room, and no alarm bell. Nothing where no sound is wanted. */
export function playSound(): void {
  if (!soundWanted.peek()) return;
  const context = audio;
  if (context?.state !== "running") {
    soundRefusal.value = "mute";
    return;
  }
  soundRefusal.value = "";
  [660, 880].forEach((frequency, place) => {
    const tone = context.createOscillator();
    const loudness = context.createGain();
    const beginS = context.currentTime + place * 0.18;
    tone.frequency.value = frequency;
    loudness.gain.setValueAtTime(0.15, beginS);
    loudness.gain.exponentialRampToValueAtTime(0.001, beginS + 0.16);
    tone.connect(loudness).connect(context.destination);
    tone.start(beginS);
    tone.stop(beginS + 0.17);
  });
}

/** To be called once as a page begins: after a reload a browser plays nothing before the first click on it. */
export function beginSound(): void {
  if (!soundWanted.value || typeof AudioContext === "undefined") return;
  audio = new AudioContext();
  addEventListener("pointerdown", () => void audio?.resume(), { once: true });
  soundRefusal.value = audio.state === "running" ? "" : "mute";
  audio.onstatechange = () => { if (audio?.state === "running") soundRefusal.value = ""; };
}
