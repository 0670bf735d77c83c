import { fetchKeys, type Key } from "../../../api/people";
import { Card } from "../../../parts/Card";
import { columnsOf } from "../../../parts/stacked";
import { nowS } from "../../../stream/stream";
import { format, t, word } from "../../../text/views/people";
import { RefusedSince } from "../../parts/RefusedSince";
import { Sure } from "../../parts/Sure";
import { useRefreshed } from "../../refreshed";
import { KEY, KeySheet } from "./KeySheet";
import { names, placeOf } from "../../state";
import { asked, beginKey, busy, calls, keyOpenings, stays, takeBack } from "./state";

const EVERY_MS = 10_000;

const HEADS = ["keyName", "scopes", "limits", "used", "keyState", "actions"] as const;

/** Keys by which other systems and call buttons use the API. */
export function KeysCard() {
  const { again, answer, failed } = useRefreshed(fetchKeys, EVERY_MS);
  const keys = answer.value ?? [];
  const none = failed.value === null ? t(answer.value ? "people.noKeys" : "view.loading") : t("list.failed", { reason: failed.value });
  return (
    <Card
      title={t("people.keys")}
      class="people-keys"
      aside={
        <button type="button" class="button small" popovertarget={KEY} onClick={beginKey}>
          {t("people.keyAdd")}
        </button>
      }
    >
      <p class="table-hint">{t("people.keysHint")}</p>
      {keys.length === 0 ? (
        <p class="empty">{none}</p>
      ) : (
        <div class="table-scroll" tabIndex={0} role="group" aria-label={t("people.keys")}>
          <table class="stacked" style={columnsOf(HEADS.map((head) => t(`people.${head}`)))}>
            <thead>
              <tr>
                {HEADS.map((head) => (
                  <th key={head} scope="col">
                    {t(`people.${head}`)}
                  </th>
                ))}
              </tr>
            </thead>
            <tbody>
              {keys.map((each) => (
                <Row key={each.id} of={each} onChanged={again} />
              ))}
            </tbody>
          </table>
        </div>
      )}
      {stays.value !== "" && (
        <p class="complaint" role="alert">
          {stays.value}
        </p>
      )}
      <RefusedSince of={keyOpenings} form={KEY} />
      <KeySheet onChanged={again} />
    </Card>
  );
}

function Row({ of, onChanged }: { of: Key; onChanged: () => void }) {
  const { id, name, scopes, used_at_s: usedAtS } = of;
  const state = stateOf(of);
  return (
    <tr>
      <th scope="row" class="people-name">
        {name}
        <small class="line muted">{id}</small>
      </th>
      <td class="people-scopes">{format.list(scopes.map((each) => word("audit.value", each)))}</td>
      <td class="people-limits">
        {limitsOf(of).map((line) => (
          <span key={line} class="line">
            {line}
          </span>
        ))}
      </td>
      <td>{usedAtS === null ? t("people.never") : format.when(usedAtS, nowS.value)}</td>
      <td>{state.text}</td>
      <td>
        {state.works &&
          (asked.value === id ? (
            <Sure
              asked={t("people.keySure", { name })}
              no={t("people.keyKeep")}
              yes={t("people.keyRevoke")}
              busy={busy.value}
              onNo={() => { asked.value = ""; }}
              onYes={() => void takeBack(of).then(onChanged)}
            />
          ) : (
            <button type="button" class="button small" aria-label={t("people.keyRevokeOf", { name })} onClick={() => { asked.value = id; }}>
              {t("people.keyRevoke")}
            </button>
          ))}
      </td>
    </tr>
  );
}

/** Which transports a key may call for; nothing of one that calls for none. */
function limitsOf({ items, open_each_max: openEach, open_max: open, places, priority, scopes }: Key): string[] {
  if (!calls(scopes)) return [];
  return [
    places.length === 0 ? t("people.everywhere") : format.list(places.map(placeOf)),
    ...(items.length === 0 ? [] : [format.list(items.map(names.value))]),
    t("people.limitsOpen", { each: openEach, most: open }),
    t("people.limitsPriority", { priority: word("priority", priority) }),
  ];
}

function stateOf({ expires_at_s: endsS, revoked_at_s: revokedAtS }: Key): { works: boolean; text: string } {
  if (revokedAtS !== null) return { works: false, text: t("people.keyRevoked", { at: format.when(revokedAtS, nowS.value) }) };
  if (endsS === null) return { works: true, text: t("people.keyForGood") };
  const at = format.when(endsS, nowS.value);
  return endsS > nowS.value ? { works: true, text: t("people.keyUntil", { at }) } : { works: false, text: t("people.keyEnded", { at }) };
}
