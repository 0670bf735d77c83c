import { speakAlso } from "../../../text/speech";
import { tables } from "../../../text/views/floor";
import { ObstaclesCard } from "../obstacles/ObstaclesCard";
import { ClosuresCard } from "./ClosuresCard";

/** These cards, once they have their words. */
export async function load(): Promise<typeof FloorCards> {
  await speakAlso(tables);
  return FloorCards;
}

/** What keeps vehicles from a part of the floor: people's word, and what lies there. */
export function FloorCards() {
  return (
    <>
      <ClosuresCard />
      <ObstaclesCard />
    </>
  );
}
