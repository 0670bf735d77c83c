import type { MachineView } from "../api/types";
import { t } from "../text";
import { Tag } from "./Tag";

const TONES = { unread: "normal", reading: "normal", verified: "normal", differs: "alarm", unreachable: "alarm" } as const;

/** What a machine has to know for its goals: each with whether it may be used. Nothing where its goals need none. */
export function Documents({ machine, name }: { machine: MachineView | undefined; name: (product: string) => string }) {
  if (!machine || machine.documents.length === 0) return null;
  return (
    <div class="stock documents">
      <h3>{t("documents.title")}</h3>
      <ul>
        {machine.documents.map((document) => (
          <li key={`${document.product} ${document.sha256} ${document.name}`}>
            <a class="link" href={document.address} target="_blank" rel="noreferrer noopener">
              {document.name}
            </a>{" "}
            <Tag tone={TONES[document.state]}>{t(`documents.${document.state}`)}</Tag>
            <small class="line muted">
              {name(document.product)} · {document.media_type}
              {document.detail !== "" && ` · ${document.detail}`}
            </small>
          </li>
        ))}
      </ul>
    </div>
  );
}
