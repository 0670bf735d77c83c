/** What lists say of being printed, in English. */
export const paper = {
  "paper.print": "Print",
  "paper.printTitle": "Print all that the filter finds, not only this page",
  "paper.reading": "Reading… {n}",
  "paper.all": "All {n} that the filter finds, printed {at}",
  "paper.first": "The first {n} that the filter finds; there are more. Narrow the list down, or take the CSV file. Printed {at}",
  "paper.screen": "Only the page on the screen: the button Print prints all that the filter finds.",
  "paper.failed": "Not printed: {reason}",
} as const;
