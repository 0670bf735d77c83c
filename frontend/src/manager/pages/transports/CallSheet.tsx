import { useLayoutEffect } from "preact/hooks";
import { speakAlso } from "../../../text/speech";
import { tables } from "../../../text/views/transports";
import type { Opened } from "../../cards/machine/CallHere";
import { edit, EMPTY } from "./call";
import "./call.css";
import { CallForm, FORM } from "./CallForm";

/** The form, once it has its words. */
export async function load(): Promise<typeof CallSheet> {
  await speakAlso(tables);
  return CallSheet;
}

/** The form with which a transport is called for, opened at one place of the plant. */
export function CallSheet({ end, number, place }: Opened) {
  useLayoutEffect(() => {
    edit({ ...EMPTY, [end]: place });
    const sheet = document.getElementById(FORM);
    sheet?.showPopover();
    sheet?.querySelector("select")?.focus();
  }, [end, number, place]);
  return <CallForm onCalled={() => undefined} />;
}
