/** What the row of people on duty says, loaded when somebody looks at it, in Spanish. */
import type { Catalogue } from "../../catalogue";
import type { duty as en } from "./en";

export const duty: Catalogue<typeof en> = {
  "duty.title": "De guardia",
  "duty.nobodyAtAll": "nadie",
  "duty.count": "{count} de guardia",
  "duty.nobodyIn": "Nadie de guardia: {areas}",
  "duty.nobodyUntil": "{area} (hasta {at})",
  "duty.busyWith": "con {caller}",
  "duty.until": "hasta las {at}",
  "duty.status.free": "libre",
  "duty.status.busy": "ocupado",
  "duty.status.break": "pausa",
};
