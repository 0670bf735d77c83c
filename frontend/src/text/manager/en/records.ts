/** What the management panel says of people and of every list, in English. */
export const records = {
  "person.menu": "Who works here",
  "person.logOut": "Log out",
  "person.role.manager": "Management",
  "person.role.operator": "Operator",
  "person.role.admin": "Administrator",
  "person.role.key": "Key of another system",

  "audit.title": "Audit log",

  "filter.find": "Find in this list",
  "filter.any": "any",
  "filter.open": "open",
  "filter.inProduction": "planned or in production",
  "filter.none": "Nothing fits.",
  "filter.csv": "CSV",
  "filter.csvTitle": "Download for a spreadsheet",

  "watch.title": "Watch",

  "promises.title": "Promises",

  "kpis.title": "Figures over time",
  "filter.findAll": "Find in all",
  "list.failed": "The list could not be read: {reason}. Trying again.",
  "list.since": "From",
  "list.until": "To",
  "pages.label": "Pages",
  "pages.before": "Back",
  "pages.next": "More",
} as const;
