import { speakAlso } from "../../../text/speech";
import { format, t, tables } from "../../../text/views/rows";
import type { Faults } from "../RowFaults";
import { rowText } from "./row-text";

/** The table, once it has its words. */
export async function load(): Promise<typeof FaultTable> {
  await speakAlso(tables);
  return FaultTable;
}

/** Row, column, and what to do. */
export function FaultTable({ faults }: Faults) {
  return (
    <table>
      <thead>
        <tr>
          <th scope="col">{t("import.row")}</th>
          <th scope="col">{t("import.column")}</th>
          <th scope="col">{t("import.reason")}</th>
        </tr>
      </thead>
      <tbody>
        {faults.map((fault, i) => (
          <tr key={i}>
            <th scope="row">{format.count(fault.row)}</th>
            <td>{fault.column}</td>
            <td>{rowText(fault)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
