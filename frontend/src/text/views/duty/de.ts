/** What the row of people on duty says, loaded when somebody looks at it, in German. */
import type { Catalogue } from "../../catalogue";
import type { duty as en } from "./en";

export const duty: Catalogue<typeof en> = {
  "duty.title": "Im Dienst",
  "duty.nobodyAtAll": "niemand",
  "duty.count": "{count} im Dienst",
  "duty.nobodyIn": "Niemand im Dienst: {areas}",
  "duty.nobodyUntil": "{area} (bis {at})",
  "duty.busyWith": "bei {caller}",
  "duty.until": "bis {at}",
  "duty.status.free": "frei",
  "duty.status.busy": "beschäftigt",
  "duty.status.break": "Pause",
};
