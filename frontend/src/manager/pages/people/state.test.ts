import { beforeEach, expect, test, vi } from "vitest";
import { addPerson, giveSecret, makeKey, makeLoginLink, type Person, revokeKey } from "../../../api/people";
import { Problem } from "../../../api/problem";
import { add, addKey, begin, beginKey, chosen, complaints, edit, editKey, editSecret, give, key, keyOpenings, kind, link, makeLink, openings, outcome, secret, stays, takeBack, written } from "./state";

vi.mock("../../../api/people", () => ({ addPerson: vi.fn(), giveSecret: vi.fn(), makeKey: vi.fn(), makeLoginLink: vi.fn(), revokeKey: vi.fn() }));

const mia = { id: "mia", name: "Mia", role: "operator", areas: ["A"], disabled_at_s: null } as unknown as Person;

beforeEach(() => {
  begin(null);
});

test("an area that is ticked while somebody is added stays ticked, and nothing else of what was written", async () => {
  edit({ id: " mia ", name: "Mia", areas: ["A"] });
  vi.mocked(addPerson).mockImplementation(async () => {
    edit({ areas: ["A", "B"] });
    return await Promise.resolve(mia);
  });
  await add();
  expect(chosen.value).toBe(mia);
  expect(written.value).toMatchObject({ id: "mia", areas: ["A", "B"] });
});

test("a secret that was given is gone, and the one that is written since stays", async () => {
  begin(mia);
  kind.value = "badge";
  editSecret("1234");
  vi.mocked(giveSecret).mockResolvedValueOnce(mia);
  await give(mia);
  expect([secret.value, kind.value]).toEqual(["", "pin"]);
  editSecret("5678");
  vi.mocked(giveSecret).mockImplementation(async () => {
    editSecret("56789");
    return await Promise.resolve(mia);
  });
  await give(mia);
  expect(secret.value).toBe("56789");
});

test("an answer about one person changes nothing of another one who was chosen since", async () => {
  const ben = { ...mia, id: "ben", name: "Ben" };
  begin(mia);
  vi.mocked(giveSecret).mockImplementation(async () => {
    begin(ben);
    editSecret("9");
    return await Promise.resolve(mia);
  });
  await give(mia);
  expect([chosen.value, secret.value, outcome.value]).toEqual([ben, "9", null]);
});

const tooShort = new Problem(422, "too short", [{ field: "secret", reason: "too short" }]);

test("a login link is never shown for somebody who was chosen since", async () => {
  begin(mia);
  vi.mocked(makeLoginLink).mockImplementation(async () => {
    begin({ ...mia, id: "ben", name: "Ben" });
    return await Promise.resolve("https://dray/login/x");
  });
  await makeLink(mia);
  expect(link.value).toBe("");
});

test("a refusal is told by the person's name once another one is chosen, and restores what was typed", async () => {
  begin(mia);
  editSecret("12");
  vi.mocked(giveSecret).mockImplementation(async () => {
    beginKey();
    return await Promise.reject(tooShort);
  });
  await give(mia);
  expect([complaints.value, outcome.value]).toEqual([{}, null]);
  expect(openings.refused.value.map(({ text }) => text)).toEqual(["Not done for Mia: too short"]);
  openings.refused.value[0]?.restore();
  expect([chosen.value, secret.value, complaints.value]).toEqual([mia, "12", { secret: "too short" }]);
});

test("a refused key is told beside the sheet once somebody is chosen", async () => {
  beginKey();
  editKey({ name: "Press", days: "0" });
  vi.mocked(makeKey).mockImplementation(async () => {
    begin(mia);
    return await Promise.reject(new Problem(422, "too few", [{ field: "days", reason: "too few" }]));
  });
  await addKey();
  expect(complaints.value).toEqual({});
  keyOpenings.refused.value[0]?.restore();
  expect([key.value.days, complaints.value]).toEqual(["0", { days: "too few" }]);
});

test("why a key cannot be taken back is told", async () => {
  vi.mocked(revokeKey).mockRejectedValueOnce(new Problem(503, "the database is away"));
  await takeBack({ id: "k1", name: "Press" } as never);
  expect(stays.value).toBe("Not done for Press: the database is away");
});
