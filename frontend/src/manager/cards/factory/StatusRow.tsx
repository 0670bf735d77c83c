import { toneOfAtv, toneOfMachine } from "../../../parts/Tag";
import { format, t, word } from "../../../text/manager";

interface Props {
  name: string;
  group: "atv" | "machine";
  counts: Readonly<Record<string, number>>;
  /** Statuses from good to bad. */
  order: readonly string[];
}

/** How many are in which status: a bar of shares, and the same in words. */
export function StatusRow({ name, group, counts, order }: Props) {
  const present = order.filter((status) => (counts[status] ?? 0) > 0);
  const tone = group === "atv" ? toneOfAtv : toneOfMachine;
  return (
    <div class="status-row">
      <span>{name}</span>
      <div class="shares" aria-hidden="true">
        {present.map((status) => (
          <i key={status} class={`share share-${status}`} style={{ flexGrow: counts[status] ?? 0 }} />
        ))}
      </div>
      <ul>
          {present.map((status) => (
            <li key={status} class={`tone-${tone(status)}`}>
              <i class={`swatch share-${status}`} aria-hidden="true" />
              {t("factory.ofStatus", { count: format.count(counts[status] ?? 0), status: word(group, status) })}
            </li>
          ))}
      </ul>
    </div>
  );
}
