import { useSignal } from "@preact/signals";
import { Card } from "../../../parts/Card";
import { nowS } from "../../../stream/stream";
import { format, n, t } from "../../../text/views/order";
import { Once } from "../../parts/Once";
import { Sure } from "../../parts/Sure";
import { problemText } from "../../problem-text";
import type { Story } from "./lanes";

interface Props {
  title: string;
  links: Story["links"];
  /** What whoever has a link sees. */
  hint: string;
  /** Whether all are to be taken back. */
  sure: string;
  make: () => Promise<{ tracking_url: string }>;
  revoke: () => Promise<void>;
  onChanged: () => void;
}

/** The page of an order or a transport for others: its links are made, copied and taken back here. */
export function LinkCard({ hint, links, make: makeLink, onChanged, revoke: revokeLinks, sure, title }: Props) {
  const made = useSignal("");
  const asking = useSignal(false);
  const busy = useSignal(false);
  const failed = useSignal("");
  const valid = links.filter((link) => link.revoked_at_s === null && (link.expires_at_s === null || link.expires_at_s > nowS.value));
  const doing = async (act: () => Promise<void>) => {
    busy.value = true;
    failed.value = "";
    try {
      await act();
      onChanged();
    } catch (error) {
      failed.value = t("links.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
      asking.value = false;
    }
  };
  const make = () =>
    doing(async () => {
      made.value = (await makeLink()).tracking_url;
    });
  const revoke = () =>
    doing(async () => {
      await revokeLinks();
      made.value = "";
    });
  return (
    <Card title={title} aside={<span class="muted">{n("links.valid", valid.length, format.count(valid.length))}</span>} class="order-links">
      <p class="muted">{hint}</p>
      {made.value !== "" && (
        <Once value={made.value} label={t("links.address")} copy={t("links.copy")} copied={t("links.copied")} notCopied={t("links.notCopied")} hint={t("links.once")}>
          <a class="button small" href={made.value} target="_blank" rel="noreferrer">
            {t("links.look")}
          </a>
        </Once>
      )}
      {asking.value ? (
        <Sure
          asked={sure}
          no={t("links.revokeNot")}
          yes={t("links.revokeDo")}
          busy={busy.value}
          onNo={() => (asking.value = false)}
          onYes={() => void revoke()}
        />
      ) : (
        <p class="order-actions">
          <button type="button" class="button small" disabled={busy.value} onClick={() => void make()}>
            {t("links.make")}
          </button>
          {valid.length > 0 && (
            <button type="button" class="button small" disabled={busy.value} onClick={() => (asking.value = true)}>
              {t("links.revoke")}
            </button>
          )}
        </p>
      )}
      {failed.value !== "" && (
        <p class="complaint" role="alert">
          {failed.value}
        </p>
      )}
    </Card>
  );
}
