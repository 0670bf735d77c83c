/** The asking for the plant, for whoever changes it and for whoever hears that it has changed. */
import { signal } from "@preact/signals";
import { plantLoading } from "../plant/load";
import { problemText } from "./problem-text";
import { plant, plantFailed } from "./state";

export const plantAsked = plantLoading(plant, plantFailed, signal(null), problemText);
