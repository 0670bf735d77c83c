/** What is said of things that lie on lanes and of doors that do not open, which is loaded where there are any, in English. */
export const floor = {
  "obstacles.title": "In the way",
  "obstacles.seen": "Met by {atv} at {at}. Vehicles go round it; from {until} on somebody looks again.",
  "obstacles.cleared": "It is gone",
  "obstacles.clearedOf": "It is gone: {where}",
  "obstacles.door": "{door} does not open",
  "obstacles.doorSeen": "{where}: {atv} stood before it at {at}. Vehicles go round it; from {until} on somebody looks again.",
  "obstacles.doorCleared": "It opens",
  "obstacles.doorClearedOf": "It opens: {door}, {where}",
} as const;
