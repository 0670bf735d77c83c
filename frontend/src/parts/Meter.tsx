/** How full something is, with an optional mark. */

interface Props {
  frac: number;
  label: string;
  tone?: "normal" | "warn" | "alarm" | "chosen" | "done";
  /** Where the mark stands, e.g. a reorder point. */
  mark?: number | undefined;
  /** A second, fainter part behind the first. */
  behind?: number;
}

export function Meter({ frac, label, tone = "normal", mark, behind }: Props) {
  return (
    <span class={`meter meter-${tone}`} role="img" aria-label={label}>
      {behind !== undefined && <i class="meter-behind" style={{ width: percent(behind) }} />}
      <i class="meter-fill" style={{ width: percent(frac) }} />
      {mark !== undefined && mark > 0 && <i class="meter-mark" style={{ left: percent(mark) }} />}
    </span>
  );
}

function percent(frac: number): string {
  return `${Math.min(1, Math.max(0, frac)) * 100}%`;
}
