/** A frame's collections without a thing in them, for tests of what reads frames. */
import { type Collection, COLLECTIONS } from "./world";

export const nothing = Object.fromEntries(Object.values(COLLECTIONS).map((name) => [name, []])) as unknown as Record<Collection, []>;
