/** What the row of people on duty says, loaded when somebody looks at it, in English. */
export const duty = {
  "duty.title": "On duty",
  "duty.nobodyAtAll": "nobody",
  "duty.count": "{count} on duty",
  "duty.nobodyIn": "Nobody is on duty: {areas}",
  "duty.nobodyUntil": "{area} (until {at})",
  "duty.busyWith": "with {caller}",
  "duty.until": "until {at}",
  "duty.status.free": "free",
  "duty.status.busy": "busy",
  "duty.status.break": "break",
} as const;
