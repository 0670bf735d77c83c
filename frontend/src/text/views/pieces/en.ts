/** What is said of the pieces of a machine, loaded when somebody looks at one, in English. */
export const pieces = {
  "pieces.since": "Pieces since {since}",
  "pieces.none": "No piece was finished since {since}.",
  "pieces.product": "Product",
  "pieces.good": "Good",
  "pieces.bad": "Bad",
  "pieces.ratio": "Quality",
} as const;
