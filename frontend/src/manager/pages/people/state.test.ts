import { beforeEach, expect, test, vi } from "vitest";
import { addPerson, giveSecret, type Person } from "../../../api/people";
import { add, begin, chosen, edit, editSecret, give, kind, secret, written } from "./state";

vi.mock("../../../api/people", () => ({ addPerson: vi.fn(), giveSecret: vi.fn() }));

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
  expect([chosen.value, secret.value]).toEqual([ben, "9"]);
});
