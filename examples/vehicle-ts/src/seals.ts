/** Certificates, seals, letters and tokens: who has said what (docs/agents.md, "Certificates" and "Seals and letters"). */

import {
  X509Certificate,
  createCipheriv,
  createDecipheriv,
  createPrivateKey,
  diffieHellman,
  hkdfSync,
  randomBytes,
  sign,
  verify,
  type KeyObject,
} from 'node:crypto';

import { pack, unpack, type Value } from './msgpack.ts';
import type { Files } from './zenoh.ts';

const FRESH_MS = 30_000;
const CERTIFICATES_MAX = 1_000;
const TAG_BYTES = 16;

/** What came in is of nobody whom we know, or not for us, not here, not now. */
export class SealError extends Error {}

interface Known {
  readonly certificate: X509Certificate;
  /** Kind by name, of the agents of this plant. */
  readonly agents: ReadonlyMap<string, string>;
}

/** Where a message stands: on which key, in which life of its sender, with which number. */
export interface Place {
  readonly key: string;
  readonly life: number;
  readonly number: number;
}

export class Seals {
  readonly kinds: ReadonlyMap<string, string>;
  readonly #plant: string;
  readonly #authority: X509Certificate;
  readonly #own: Buffer;
  readonly #key: KeyObject;
  #certificates = new Map<string, Known>();
  /** By agent: the certificate of its newest life. */
  #met = new Map<string, { life: number; known: Known }>();

  constructor(plant: string, files: Files) {
    this.#plant = plant;
    this.#authority = new X509Certificate(files.authority);
    this.#own = new X509Certificate(files.certificate).raw;
    this.#key = createPrivateKey(files.key);
    this.kinds = this.#know(this.#own).agents;
  }

  // --- what is published ---

  seal(place: Place, data: Buffer): Buffer {
    const at = Date.now();
    return pack([this.#own, at, sign('sha256', signed(place, at, data), this.#key)]);
  }

  /** The kind of the agent who has really said this. */
  examine(seal: Buffer, sender: string, place: Place, data: Buffer): string {
    const [certificate, at, signature] = parts(seal, 3);
    const known = this.#know(bytes(certificate));
    checkAge(at);
    if (!verify('sha256', signed(place, whole(at), data), known.certificate.publicKey, bytes(signature)))
      throw new SealError('its signature does not fit');
    return this.#meet(sender, place.life, known);
  }

  // --- what is said to one agent ---

  /** A letter and its seal; nothing when the reader has not shown its certificate yet. */
  write(sender: string, reader: string, place: Place, words: Buffer): { letter: Buffer; seal: Buffer } | undefined {
    const met = this.#met.get(reader);
    if (!met) return undefined;
    const at = Date.now();
    const nonce = randomBytes(12);
    const cipher = createCipheriv('aes-256-gcm', this.#secret(sender, reader, met.known), nonce);
    cipher.setAAD(bound(reader, place, at));
    const letter = Buffer.concat([cipher.update(words), cipher.final(), cipher.getAuthTag()]);
    return { letter, seal: pack([this.#own, sender, at, nonce]) };
  }

  /** Who has written a letter to us, of which kind that is, and the words. */
  read(seal: Buffer, reader: string, place: Place, letter: Buffer): { sender: string; kind: string; words: Buffer } {
    const [certificate, sender, at, nonce] = parts(seal, 4);
    if (typeof sender !== 'string') throw new SealError('no sender');
    const known = this.#know(bytes(certificate));
    checkAge(at);
    const secret = this.#secret(sender, reader, known);
    const cipher = createDecipheriv('aes-256-gcm', secret, bytes(nonce), { authTagLength: TAG_BYTES });
    cipher.setAAD(bound(reader, place, whole(at)));
    try {
      cipher.setAuthTag(letter.subarray(-TAG_BYTES));
      const words = Buffer.concat([cipher.update(letter.subarray(0, -TAG_BYTES)), cipher.final()]);
      return { sender, kind: this.#meet(sender, place.life, known), words };
    } catch (error) {
      throw error instanceof SealError ? error : new SealError('it cannot be opened');
    }
  }

  // --- who is there ---

  /** The last chunk of a token's key: that it is we who are there. */
  vouch(words: string): string {
    const signature = sign('sha256', Buffer.from(`there ${words}`), this.#key);
    return pack([this.#own, signature]).toString('base64').replaceAll('+', '-').replaceAll('/', '_');
  }

  /** Believe a token, and know its agent's certificate from now on. */
  examineToken(words: string, agent: string, life: number, chunk: string): void {
    const [certificate, signature] = parts(Buffer.from(chunk, 'base64url'), 2);
    const known = this.#know(bytes(certificate));
    if (!verify('sha256', Buffer.from(`there ${words}`), known.certificate.publicKey, bytes(signature)))
      throw new SealError('its signature does not fit');
    this.#meet(agent, life, known);
  }

  #meet(agent: string, life: number, known: Known): string {
    const kind = known.agents.get(agent);
    if (kind === undefined) throw new SealError(`its certificate does not name ${agent}`);
    const now = Date.now();
    const { validFrom, validTo } = known.certificate;
    if (now < Date.parse(validFrom) || now > Date.parse(validTo)) throw new SealError('its certificate is not valid now');
    const met = this.#met.get(agent);
    if (!met || met.life <= life) this.#met.set(agent, { life, known });
    return kind;
  }

  #know(der: Buffer): Known {
    const name = der.toString('latin1');
    const before = this.#certificates.get(name);
    if (before) return before;
    const certificate = new X509Certificate(der);
    if (!certificate.checkIssued(this.#authority) || !certificate.verify(this.#authority.publicKey))
      throw new SealError('its certificate is not of our authority');
    const known = { certificate, agents: agentsOf(certificate, this.#plant) };
    if (this.#certificates.size >= CERTIFICATES_MAX) this.#certificates.clear();
    this.#certificates.set(name, known);
    return known;
  }

  #secret(sender: string, reader: string, other: Known): Buffer {
    const shared = diffieHellman({ privateKey: this.#key, publicKey: other.certificate.publicKey });
    const words = `dray letter ${this.#plant} ${sender} ${reader}`;
    return Buffer.from(hkdfSync('sha256', shared, Buffer.alloc(0), words, 32));
  }
}

/** The agents that a certificate names in this plant: URIs `dray:PLANT/KIND/AGENT`. */
function agentsOf(certificate: X509Certificate, plant: string): Map<string, string> {
  const found = new Map<string, string>();
  for (const name of (certificate.subjectAltName ?? '').split(', ')) {
    const match = /^URI:dray:([^/]+)\/([^/]+)\/([^/]+)$/.exec(name);
    if (match?.[1] === plant) found.set(match[3]!, match[2]!);
  }
  return found;
}

function signed({ key, life, number }: Place, at: number, data: Buffer): Buffer {
  return Buffer.concat([Buffer.from(`${key} ${life} ${number} ${at} `), data]);
}

function bound(reader: string, { life, number }: Place, at: number): Buffer {
  return Buffer.from(`${reader} ${life} ${number} ${at}`);
}

function parts(seal: Buffer, count: number): Value[] {
  let read: Value;
  try {
    read = unpack(seal);
  } catch {
    throw new SealError('no seal');
  }
  if (!Array.isArray(read) || read.length < count) throw new SealError('no seal');
  return read;
}

function bytes(value: Value | undefined): Buffer {
  if (value instanceof Uint8Array) return Buffer.from(value);
  throw new SealError('no bytes');
}

function whole(value: Value | undefined): number {
  if (typeof value === 'number' && Number.isSafeInteger(value) && value >= 0) return value;
  throw new SealError('no whole number');
}

function checkAge(at: Value | undefined): void {
  const age = Date.now() - whole(at);
  if (Math.abs(age) > FRESH_MS) throw new SealError(`said ${age} ms ago`);
}
