/** What is wrong in one row of a spreadsheet, in the reader's language. */
import type { components } from "../../../api/types";
import { fill } from "../../../text/catalogue";
import { t } from "../../../text/views/rows";
import { messageOf } from "../../../text/views/rows/fault-text";

type RowFault = components["schemas"]["RowFault"];

export function rowText({ code, column, reason, values }: RowFault): string {
  return fill(messageOf(code, column) ?? t("rowFault.plant", { reason }), values);
}
