/** Reasons in the reader's language. What this version does not know stays as it is. */
import type { CauseView, LackView } from "../api/types";
import { withNames } from "./elsewhere";
import { format, t, word } from "./index";
import { factoryTime } from "./plant-time";
import { waitText } from "./wait";

/** Words of vehicles and of those who speak for controllers, in which something is filled in (`tests/contracts/test_problem_words.py`). */
const FILLED = [
  { says: /^cannot carry an? (?<ability>.+)$/, key: "failure.carry" },
  { says: /^(?<left>-?\d+)% would be left, (?<needed>\d+)% are needed$/, key: "failure.left" },
  { says: /^must charge: (?<left>\d+)% left, takes work again from (?<enough>\d+)% on$/, key: "failure.mustCharge" },
  { says: /^on probation, and this is not short: it would take (?<time>\d+) s$/, key: "failure.notShort" },
  { says: /^it has not come nearer to (?<node>\S+) for (?<time>\d+) s: (?<why>.+)$/, key: "failure.stuck" },
  { says: /^(?<item>\S+) is a material$/, key: "failure.isMaterial" },
  { says: /^uses (?<item>\S+) itself$/, key: "failure.usesItself" },
  { says: /^makes (?<item>\S+) itself$/, key: "failure.makesItself" },
  { says: /^no material (?<item>\S+)$/, key: "failure.noMaterial" },
  { says: /^no storage holds (?<item>\S+)$/, key: "failure.noStorage" },
  { says: /^(?<count>\d+) (?<item>\S+) do not fit into a buffer of (?<most>\d+)$/, key: "failure.noRoom" },
  { says: /^(?<item>\S+) is listed twice$/, key: "failure.listedTwice" },
  { says: /^(?<time>\d+) s too late$/, key: "failure.late" },
  { says: /^(?<count>\d+) tasks$/, key: "failure.tasks" },
  { says: /^no piece of (?<product>\S+) was counted for (?<time>\d+) s$/, key: "failure.noPiece" },
  { says: /^its controller is not heard: (?<why>.+)$/, key: "failure.notHeard" },
  { says: /^its controller has a fault: (?<what>.+)$/, key: "failure.fault" },
  { says: /^its controller has no value for (?<signal>\w+): (?<why>.+)$/, key: "failure.noValue" },
  { says: /^its controller does not take (?<signal>\w+): (?<why>.+)$/, key: "failure.notTaken" },
  { says: /^its controller refuses a permit \((?<signal>\w+)\): (?<why>.+)$/, key: "failure.permit" },
  { says: /^its count is in doubt: (?<why>.+)$/, key: "failure.doubt" },
  { says: /^its count is in doubt \((?<number>\d+)\): (?<why>.+)$/, key: "failure.doubtOf" },
  { says: /^the broker is away: (?<why>.+)$/, key: "failure.brokerAway" },
  { says: /^it has not told any place yet: (?<missing>.+)$/, key: "failure.neverTold" },
  { says: /^it does not tell its place, and was last at (?<node>\S+): (?<missing>.+)$/, key: "failure.lastAt" },
  { says: /^the vehicle is not there: (?<state>\w+)$/, key: "failure.vehicleAway" },
  { says: /^the vehicle says nothing, for (?<time>\d+) s and more$/, key: "failure.saysNothing" },
  { says: /^emergency stop \((?<stop>\w+)\)$/, key: "failure.emergencyStop" },
  { says: /^its mode is (?<mode>\w+)$/, key: "failure.mode" },
  { says: /^its position cannot be: x (?<x>\S+) m, y (?<y>\S+) m$/, key: "failure.position" },
  { says: /^it is on a map that is not (?<map>.+)$/, key: "failure.otherMap" },
  { says: /^it stands on no lane of the plant: \((?<x>\S+), (?<y>\S+)\)$/, key: "failure.noLane" },
  { says: /^it takes no order: (?<why>.+)$/, key: "failure.takesNoOrder" },
  { says: /^it has refused (?<count>\d+) orders one after the other: (?<why>.+)$/, key: "failure.refusedAll" },
  { says: /^its action (?<action>\S+) has not ended for (?<time>\d+) s$/, key: "failure.overlong" },
  { says: /^its action (?<action>\S+) has not ended for (?<time>\d+) s: (?<why>.+)$/, key: "failure.overlongWhy" },
  { says: /^it has ended (?<count>\d+) orders one after the other, and has not driven: (?<why>.+)$/, key: "failure.fruitless" },
  { says: /^it is at its charger, and its battery level has not risen for (?<time>\d+) s$/, key: "failure.gainsNothing" },
  { says: /^tells that (?<theirs>.+) is on board, and (?<ours>.+) should be: see to it, then MANUAL and back$/, key: "failure.loadDiffers" },
  { says: /^our own fault, see the log: (?<event>.+) cannot be dealt with$/, key: "failure.ownFault" },
  { says: /^it has refused order (?<order>\S+): (?<why>.+)$/, key: "failure.refusedOrder" },
  { says: /^it does not show order (?<order>\S+)$/, key: "failure.notShown" },
  { says: /^order (?<order>\S+) is cancelled$/, key: "failure.cancelledOrder" },
  { says: /^its action (?<action>\S+)$/, key: "failure.action" },
  { says: /^it drives to (?<node>\S+)$/, key: "failure.drives" },
  { says: /^the vehicle has not said anything yet that can be used: (?<odd>.+)$/, key: "failure.nothingUsable" },
  { says: /^the way must begin at (?<node>\S+)$/, key: "failure.mustBegin" },
  { says: /^no lane from (?<from>\S+) to (?<to>\S+)$/, key: "failure.noLaneFrom" },
  { says: /^it was moved from (?<from>\S+) to (?<to>\S+)$/, key: "failure.movedFrom" },
  { says: /^it was bound for (?<node>\S+) already$/, key: "failure.boundFor" },
  { says: /^no station (?<place>\S+)$/, key: "failure.noStation" },
  { says: /^not at (?<place>\S+)$/, key: "failure.notAt" },
  { says: /^(?<item>\S+) is on board$/, key: "failure.aboard" },
] as const;

/** Why a controller is not heard, has no value, or its count is in doubt: what stands within the words above. */
const WHY = [
  { says: /^(?<why>it stands|it says that it drives, .+?|its status is .+?); it reports: (?<what>.+)$/, key: "why.andReports" },
  { says: /^it reports: (?<what>.+)$/, key: "why.reports" },
  { says: /^it says that its last node is (?<node>.+), and is (?<gap>\S+) m before it$/, key: "why.ahead" },
  { says: /^its status is (?<status>.+)$/, key: "why.status" },
  { says: /^(?<where>[\w.]+:\/\/\S+): (?<why>.+)$/, key: "why.at" },
  { says: /^(?<signal>\w+) went from (?<last>[\d,]+) to (?<now>[\d,]+): (?<most>[\d,]+) pieces at most can have been made since$/, key: "why.made" },
  { says: /^(?<signal>\w+) went from (?<last>[\d,]+) to (?<now>[\d,]+): (?<most>[\d,]+) pieces at most can have been let in since$/, key: "why.letIn" },
  { says: /^(?<signal>\w+) went from (?<last>[\d,]+) to (?<now>[\d,]+): it counts backwards$/, key: "why.backwards" },
  { says: /^(?<signal>\w+) went from (?<last>[\d,]+) to (?<now>[\d,]+) while nobody listened: pieces made before that may be missing$/, key: "why.resetMade" },
  { says: /^(?<signal>\w+) went from (?<last>[\d,]+) to (?<now>[\d,]+) while nobody listened: pieces let in before that may be missing$/, key: "why.resetLetIn" },
  { says: /^(?<signal>\w+) was not heard for a while: pieces may be missing$/, key: "why.pulses" },
  { says: /^(?<signal>\w+) showed a piece that was not admitted$/, key: "why.notAdmitted" },
  { says: /^(?<signal>\w+) grew after a broken connection, by (?<held>\S+) or by (?<asked>\S+)$/, key: "why.unsure" },
  { says: /^(?<signal>\w+) is read from (?<here>.+), and was read from (?<there>.+): pieces made in between may be missing$/, key: "why.anotherMade" },
  { says: /^(?<signal>\w+) is read from (?<here>.+), and was read from (?<there>.+): pieces let in in between may be missing$/, key: "why.anotherLetIn" },
  { says: /^(?<value>.+) is no label$/, key: "why.noLabel" },
  { says: /^(?<value>.+) is no count$/, key: "why.noCount" },
  { says: /^(?<value>.+) is no pulse$/, key: "why.noPulse" },
  { says: /^(?<value>.+) is neither true nor false$/, key: "why.noBit" },
  { says: /^(?<value>.+) is no state that is known$/, key: "why.noState" },
  { says: /^it is no single value but a (?<kind>\w+)$/, key: "why.noSingleOf" },
  { says: /^its message is no JSON: (?<error>.+)$/, key: "why.noJson" },
  { says: /^its message has nothing at (?<path>.+)$/, key: "why.nothingAt" },
  { says: /^a message of (?<size>[\d,]+) bytes is none of a sensor$/, key: "why.tooLong" },
  { says: /^nothing was said for (?<silent>[\d.]+) s$/, key: "why.silent" },
  { says: /^it has ended the subscription: (?<status>.+)$/, key: "why.ended" },
  { says: /^fault (?<code>[\d.e+-]+)$/, key: "why.faultOf" },
  { says: /^it says that it drives an order of somebody else: (?<order>.+)$/, key: "why.drivesOther" },
  { says: /^its action (?<action>.+) is (?<status>\w+), of an order of somebody else: (?<order>.+)$/, key: "why.actionOther" },
  { says: /^its action (?<action>.+) is (?<status>\w+), of an earlier order$/, key: "why.actionEarlier" },
  { says: /^it shows an order of somebody else: (?<order>.+)$/, key: "why.showsOther" },
] as const;

/** What a vehicle's driver says would end its wait. */
const UNTIL = [
  { says: /^it does not, or (?<action>\w+) has ended$/, key: "until.stopsCharging" },
  { says: /^it does, for (?<time>\S+) s$/, key: "until.shows" },
] as const;

/** Which of the names above are figures, grouped in thousands as the reader groups them. */
const FIGURES: ReadonlySet<string> = new Set(["last", "now", "most", "size"]);
/** Which of them say why, in words of their own. */
const INNER: ReadonlySet<string> = new Set(["why", "what", "theirs", "ours"]);

/** What somebody reports in words of their own; some of them are known here. */
export function failureText(said: string): string {
  const text = filled(FILLED, said) ?? known("failure", said);
  return text === said ? withNames(whyText(said)) : text;
}

function whyText(said: string): string {
  return filled(WHY, said) ?? known("why", said);
}

/** What would end the wait of a vehicle's body. */
export function untilText(said: string): string {
  return filled(UNTIL, said) ?? known("until", said);
}

/** What is not known here stays as it is: codes of controllers have lines in them. */
function known(group: string, said: string): string {
  const text = word(group, said);
  return text === said.replaceAll("_", " ") ? said : text;
}

function filled(sentences: typeof FILLED | typeof WHY | typeof UNTIL, said: string): string | null {
  for (const { says, key } of sentences) {
    const found = says.exec(said)?.groups;
    if (found) return t(key, Object.fromEntries(Object.entries(found).map(([name, text]) => [name, inWords(name, text)])) as never);
  }
  return null;
}

function inWords(name: string, text: string): string {
  if (FIGURES.has(name)) return format.count(Number(text.replaceAll(",", "")));
  if (name === "missing") return failureText(text);
  return INNER.has(name) ? whyText(text) : text;
}

/** One of the reasons of the wire. */
export function reasonText(reason: string): string {
  return word("reason.why", reason);
}

/** Why something does not go on. */
export function causeText(cause: CauseView): string {
  const said = [whatText(cause), cause.detail === "" ? "" : failureText(cause.detail)].filter((each) => each !== "");
  const text = said.join("; ");
  return cause.times === 1 ? text : t("cause.times", { what: text, times: format.count(cause.times) });
}

/** The material that somebody waits for, as "Rotor (nothing in storage S3)". */
export function lacksText(lacks: readonly LackView[]): string {
  return format.list(lacks.map(lackText));
}

function whatText({ clock_ahead_s: aheadS, detail, handover, lacks, machines, not_made: products, reason, wait }: CauseView): string {
  if (products.length > 0) return t("cause.notMade", { products: format.list(products) });
  if (machines.length > 0) return format.list(machines.map((each) => t("cause.of", { agent: each.agent, what: reasonText(each.reason) })));
  if (lacks.length > 0) return lacksText(lacks);
  if (wait !== null) return waitText(wait);
  if (handover !== null) return t("cause.handover", { ...handover });
  if (aheadS !== 0) return t(aheadS < 0 ? "alerts.what.clock_behind" : "alerts.what.clock_ahead", { by: factoryTime(Math.abs(aheadS)) });
  // What a vehicle reports says more than that it reports something.
  return reason === "problem" && detail !== "" ? "" : reasonText(reason);
}

function lackText({ material, short, silent }: LackView): string {
  const reasons = [
    short.length > 0 ? t("cause.short", { storages: format.list(short) }) : "",
    silent.length > 0 ? t("cause.silentStation", { storages: format.list(silent) }) : "",
  ].filter((each) => each !== "");
  return reasons.length === 0 ? material : t("cause.lack", { material, reasons: format.list(reasons) });
}
