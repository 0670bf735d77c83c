import { nowS } from "../../../../stream/stream";
import { format, t } from "../../../../text/views/transports";
import { Figure } from "../../../orders/page/Head";
import type { stepsOf } from "./story";

/** When the steps between call and arrival were reached. */
export function Steps({ aboardS, setOffS }: ReturnType<typeof stepsOf>) {
  return (
    <>
      {setOffS !== null && <Figure head={t("called.page.setOff")}>{format.due(setOffS, nowS.value)}</Figure>}
      {aboardS !== null && <Figure head={t("called.page.aboard")}>{format.due(aboardS, nowS.value)}</Figure>}
    </>
  );
}
