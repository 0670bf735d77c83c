/** Which plain transports the address asks for, and as the gateway is asked for them. Pure. */
import type { TransportAnswer, TransportState } from "../../../api/transports";
import type { Asked } from "../../views";

export const STATES = ["waiting", "assigned", "on_board", "delivered", "cancelled"] as const satisfies readonly TransportState[];
const OPEN: readonly TransportState[] = ["waiting", "assigned", "on_board"];

export function queryOf({ place, q, state }: Asked): { q?: string; status?: TransportState[]; place?: string } {
  const one = STATES.filter((each) => each === state);
  const status = state === "open" ? [...OPEN] : one;
  return { ...(q ? { q } : {}), ...(status.length > 0 ? { status } : {}), ...(place ? { place } : {}) };
}

/** Whether it can be called off: not once it is on board, and not twice. */
export function canCallOff({ cancel_at, status }: TransportAnswer): boolean {
  return (status === "waiting" || status === "assigned") && cancel_at === null;
}
