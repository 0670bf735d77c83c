import type { BufferView } from "../../../api/types";
import { Meter } from "../../../parts/Meter";
import { filledFrac, isLow } from "../../../plant/stock";
import { format, n, t } from "../../../text/manager";
import { names } from "../../state";

/** Buffers or finished goods: how full, where more is ordered, what is on its way, what a cancelled order has left. */
export function Stock({ title, buffers }: { title: string; buffers: readonly BufferView[] }) {
  if (buffers.length === 0) return null;
  return (
    <div class="stock">
      <h3>{title}</h3>
      {buffers.map((buffer) => (
        <StockRow key={buffer.item} buffer={buffer} />
      ))}
    </div>
  );
}

function StockRow({ buffer }: { buffer: BufferView }) {
  const { capacity, item, level, on_order: order, reorder_point: reorder, spare } = buffer;
  const material = reorder > 0;
  const low = material && isLow(buffer);
  const name = names.value(item);
  const label = t("machine.levelLabel", { item: name, level, capacity, reorder, order });
  return (
    <div class="stock-row" title={label}>
      <span class="clip">{name}</span>
      <Meter
        frac={filledFrac(buffer)}
        behind={filledFrac({ level: level + order, capacity })}
        mark={material ? reorder / capacity : undefined}
        tone={low ? "warn" : "normal"}
        label={label}
      />
      <span class={`num ${low ? "tone-warn" : ""}`}>
        {t("machine.level", { level: format.count(level), capacity: format.count(capacity) })}
      </span>
      {spare > 0 && <small>{n("machine.spare", spare)}</small>}
    </div>
  );
}
