/** What parts say that all panels share; a panel's own words are in the folder of its name. */
import type { en } from "./shared/en";
import { textsOf } from "./speech";

export { format } from "./speech";
export const { t, n, word } = textsOf<typeof en>();
