import { t } from "../../../text/manager";

/** @param href where the table comes from; it names the file itself */
export function CsvLink({ href }: { href: string }) {
  return (
    <a class="button" href={href} download title={t("filter.csvTitle")}>
      {t("filter.csv")}
    </a>
  );
}
