/**
 * As much of a Zenoh session as a vehicle needs: a client of one router over TLS.
 *
 * Put, subscribe, ask (a query with a payload), declare a liveliness token, and watch tokens. Zenoh's wire protocol 9, without
 * quality of service, compression or shared memory, none of which a router insists on. Frames go on the reliable channel.
 */

import { randomBytes } from 'node:crypto';
import { connect, type TLSSocket } from 'node:tls';

import { Reader, Writer } from './bytes.ts';

const VERSION = 9;
const CLIENT = 2;
/** Longest batch, its length's two bytes not counted. */
const BATCH = 65_535;
/** Sequence numbers have 28 bits. */
const NUMBERS = 2 ** 28;
const LEASE_MS = 2_000;
const OPEN_WITHIN_MS = 10_000;
const UNSENT_MAX = 1_048_576;

const T = { INIT: 0x01, OPEN: 0x02, CLOSE: 0x03, KEEP_ALIVE: 0x04, FRAME: 0x05, FRAGMENT: 0x06 };
const N = { OAM: 0x1f, DECLARE: 0x1e, PUSH: 0x1d, REQUEST: 0x1c, RESPONSE: 0x1b, FINAL: 0x1a, INTEREST: 0x19 };
const D = { KEY: 0, UN_KEY: 1, SUBSCRIBER: 2, UN_SUBSCRIBER: 3, QUERYABLE: 4, UN_QUERYABLE: 5, TOKEN: 6, UN_TOKEN: 7, FINAL: 0x1a };
const Z = { PUT: 0x01, DEL: 0x02, QUERY: 0x03, REPLY: 0x04, ERR: 0x05 };
/** In a header: extensions follow; a key has a suffix; its number is one of the sender's. */
const MORE = 0x80;
const NAMED = 0x20;
const SENDERS = 0x40;
const ATTACHMENT = 0x03;
const QUERY_BODY = 0x03;
const EXT_BYTES = 0x40;

export interface Files {
  readonly authority: string;
  readonly certificate: string;
  readonly key: string;
}

/** Hears what is said on a key. */
export type OnSample = (key: string, payload: Buffer, attachment: Buffer) => void;
/** Hears of a token's key that it is there, or is no more. */
export type Watch = (key: string, there: boolean) => void;

/** The floor's own refusal, or nobody there. */
export class NoAnswer extends Error {}

interface Question {
  readonly take: (answer: Buffer) => void;
  readonly fail: (why: NoAnswer) => void;
}

export class Session {
  /** Settles when the link has ended, with the reason. */
  readonly ended: Promise<string>;
  #end!: (reason: string) => void;
  #socket: TLSSocket;
  #unread: Buffer = Buffer.alloc(0);
  #opened?: () => void;
  #isOpen = false;
  #number = randomBytes(3).readUIntLE(0, 3);
  #nextId = 1;
  #keys = new Map<number, string>();
  #tokens = new Map<number, string>();
  #subscribers = new Map<string, { id: number; onSample: OnSample }>();
  #watches: Watch[] = [];
  #questions = new Map<number, Question>();
  #fragments: Buffer[] = [];
  #heardAt = Date.now();
  #saidAt = 0;
  #leaseMs = 10_000;
  #pulse?: NodeJS.Timeout;

  private constructor(socket: TLSSocket) {
    this.#socket = socket;
    this.ended = new Promise((settle) => {
      this.#end = (reason) => {
        clearInterval(this.#pulse);
        socket.destroy();
        for (const question of this.#questions.values()) question.fail(new NoAnswer(reason));
        this.#questions.clear();
        settle(reason);
      };
    });
    socket.on('data', (data) => this.#guard(() => this.#take(data)));
    socket.on('error', (error) => this.#end(error.message));
    socket.on('close', () => this.#end('the router has closed the link'));
  }

  /** Link with a router at HOST:PORT, both sides showing certificates. Throws when that cannot be had. */
  static async open(address: string, files: Files): Promise<Session> {
    const colon = address.lastIndexOf(':');
    const socket = connect({
      host: address.slice(0, colon),
      port: Number(address.slice(colon + 1)),
      ca: files.authority,
      cert: files.certificate,
      key: files.key,
      minVersion: 'TLSv1.3',
      // Certificates name agents and no hosts; that the plant's authority has signed it is what counts.
      checkServerIdentity: () => undefined,
    });
    const session = new Session(socket);
    const opened = new Promise<void>((settle) => (session.#opened = settle));
    socket.once('secureConnect', () => session.#init());
    const late = setTimeout(() => session.#end('it does not answer'), OPEN_WITHIN_MS);
    const failed = await Promise.race([opened, session.ended]);
    clearTimeout(late);
    if (typeof failed === 'string') throw new Error(`${address}: ${failed}`);
    return session;
  }

  /** Say it to whoever listens. A link that takes nothing loses it: what is said again is worth more than what waits. */
  put(key: string, payload: Uint8Array, attachment: Uint8Array = new Uint8Array()): void {
    const message = named(new Writer(), N.PUSH, key);
    if (attachment.length) message.byte(Z.PUT | MORE).byte(EXT_BYTES | ATTACHMENT).slice(attachment);
    else message.byte(Z.PUT);
    this.#say(message.slice(payload));
  }

  subscribe(key: string, onSample: OnSample): void {
    const id = this.#nextId++;
    this.#subscribers.set(key, { id, onSample });
    this.#declare(D.SUBSCRIBER, id, key);
  }

  unsubscribe(key: string): void {
    const subscriber = this.#subscribers.get(key);
    if (!subscriber) return;
    this.#subscribers.delete(key);
    this.#say(new Writer().byte(N.DECLARE).byte(D.UN_SUBSCRIBER).zint(subscriber.id));
  }

  /** Be there under this key until the link ends. */
  declareToken(key: string): void {
    this.#declare(D.TOKEN, this.#nextId++, key);
  }

  /** Be told of all tokens whose key matches, those that are there already too. */
  watchTokens(pattern: string, watch: Watch): void {
    this.#watches.push(watch);
    const currentAndFuture = 0x20 | 0x40;
    const keys = 0x01;
    const tokens = 0x08;
    const restricted = 0x10;
    const suffix = 0x20;
    const head = new Writer().byte(N.INTEREST | currentAndFuture).zint(this.#nextId++);
    this.#say(head.byte(keys | tokens | restricted | suffix).zint(0).text(pattern));
  }

  /** Ask whoever answers under this key; the first answer. */
  ask(key: string, question: Uint8Array, withinMs: number): Promise<Buffer> {
    const id = this.#nextId++;
    const body = new Writer().zint(0).raw(question).bytes(); // the encoding: bytes
    const message = named(new Writer(), N.REQUEST, key, id);
    message.byte(Z.QUERY | MORE).byte(EXT_BYTES | QUERY_BODY).slice(body);
    return new Promise((take, fail) => {
      const late = setTimeout(() => this.#fail(id, 'no answer in time'), withinMs);
      const settled = <A>(settle: (value: A) => void) => (value: A) => {
        clearTimeout(late);
        settle(value);
      };
      this.#questions.set(id, { take: settled(take), fail: settled(fail) });
      this.#say(message);
    });
  }

  close(): void {
    if (this.#isOpen) this.#batch(new Writer().byte(T.CLOSE | 0x20).byte(0).bytes());
    this.#socket.end(() => this.#end('closed'));
  }

  // --- opening ---

  #init(): void {
    const sizes = 0x40;
    const head = new Writer().byte(T.INIT | sizes).byte(VERSION);
    const id = randomBytes(16);
    id[15] = id[15]! | 1; // an id that ended with zeros would be a shorter one
    head.byte((15 << 4) | CLIENT).raw(id);
    const bits32 = 2 | (2 << 2); // of sequence numbers and of requests
    this.#batch(head.byte(bits32).uint16(BATCH).bytes());
  }

  #initAcknowledged(reader: Reader, header: number): void {
    reader.byte();
    const id = reader.byte();
    reader.raw((id >> 4) + 1);
    if (header & 0x40) {
      if ((reader.byte() & 0x03) < 2) throw new Error('the router counts in fewer than 28 bits');
      reader.uint16();
    }
    const cookie = Buffer.from(reader.slice());
    const message = new Writer().byte(T.OPEN).zint(LEASE_MS).zint(this.#number).slice(cookie);
    this.#batch(message.bytes());
  }

  #openAcknowledged(reader: Reader, header: number): void {
    const lease = reader.zint();
    reader.zint(); // with which number its frames begin: a stream loses none, so nobody counts
    this.#leaseMs = header & 0x40 ? lease * 1_000 : lease;
    this.#isOpen = true;
    this.#heardAt = Date.now();
    this.#pulse = setInterval(() => this.#beat(), LEASE_MS / 4);
    this.#opened?.();
  }

  #beat(): void {
    const now = Date.now();
    if (now - this.#heardAt > this.#leaseMs) this.#end('the router is silent');
    else if (now - this.#saidAt >= LEASE_MS / 4 - 50) this.#batch(Uint8Array.of(T.KEEP_ALIVE));
  }

  // --- saying ---

  #declare(what: number, id: number, key: string): void {
    this.#say(new Writer().byte(N.DECLARE).byte(what | NAMED).zint(id).zint(0).text(key));
  }

  #say(message: Writer): void {
    const bytes = message.bytes();
    if (this.#socket.writableLength > UNSENT_MAX) return;
    const reliable = 0x20;
    const frame = new Writer().byte(T.FRAME | reliable).zint(this.#number).raw(bytes).bytes();
    if (frame.length > BATCH) throw new Error(`${bytes.length} bytes are too long for one batch`);
    this.#number = (this.#number + 1) % NUMBERS;
    this.#batch(frame);
  }

  #batch(bytes: Uint8Array): void {
    if (this.#socket.destroyed) return;
    this.#saidAt = Date.now();
    this.#socket.write(new Writer().uint16(bytes.length).raw(bytes).bytes());
  }

  // --- hearing ---

  /** What cannot be read ends the link, and nothing else. */
  #guard(read: () => void): void {
    try {
      read();
    } catch (error) {
      this.#end(`not understood: ${error instanceof Error ? error.message : String(error)}`);
    }
  }

  #take(data: Buffer): void {
    this.#heardAt = Date.now();
    this.#unread = Buffer.concat([this.#unread, data]);
    while (this.#unread.length >= 2) {
      const length = this.#unread.readUInt16LE(0);
      if (this.#unread.length < 2 + length) return;
      const batch = new Reader(this.#unread.subarray(2, 2 + length));
      this.#unread = this.#unread.subarray(2 + length);
      while (batch.left) this.#readMessage(batch);
    }
  }

  #readMessage(batch: Reader): void {
    const header = batch.byte();
    const kind = header & 0x1f;
    if (kind === T.INIT) {
      this.#initAcknowledged(batch, header);
      if (header & MORE) skipExtensions(batch);
    } else if (kind === T.OPEN) {
      this.#openAcknowledged(batch, header);
      if (header & MORE) skipExtensions(batch);
    } else if (kind === T.KEEP_ALIVE) {
      if (header & MORE) skipExtensions(batch);
    } else if (kind === T.FRAME) {
      batch.zint();
      if (header & MORE) skipExtensions(batch);
      while (batch.left) this.#hearMessage(batch);
    } else if (kind === T.FRAGMENT) {
      this.#hearFragment(batch, header);
    } else if (kind === T.CLOSE) {
      this.#end(`the router has closed the link (${batch.byte()})`);
    } else {
      throw new Error(`a transport message of kind ${kind}`);
    }
  }

  /** A message that was too long for one batch, in parts. One channel, so its parts come one after the other. */
  #hearFragment(batch: Reader, header: number): void {
    batch.zint();
    if (header & MORE) skipExtensions(batch);
    this.#fragments.push(Buffer.from(batch.rest()));
    const more = 0x40;
    if (header & more) return;
    const message = new Reader(Buffer.concat(this.#fragments));
    this.#fragments = [];
    this.#hearMessage(message);
  }

  #hearMessage(reader: Reader): void {
    const header = reader.byte();
    const kind = header & 0x1f;
    if (kind === N.PUSH) {
      const key = this.#key(reader, header);
      if (header & MORE) skipExtensions(reader);
      const put = this.#body(reader);
      if (put) for (const [pattern, { onSample }] of this.#subscribers) if (matches(pattern, key)) onSample(key, ...put);
    } else if (kind === N.DECLARE) {
      if (header & 0x20) reader.zint(); // which of our interests this answers
      if (header & MORE) skipExtensions(reader);
      this.#hearDeclaration(reader);
    } else if (kind === N.RESPONSE) {
      const id = reader.zint();
      this.#key(reader, header);
      if (header & MORE) skipExtensions(reader);
      this.#hearResponse(id, reader);
    } else if (kind === N.FINAL) {
      const id = reader.zint();
      if (header & MORE) skipExtensions(reader);
      this.#fail(id, 'nobody is there');
    } else if (kind === N.INTEREST) {
      this.#skipInterest(reader, header);
    } else if (kind === N.OAM) {
      reader.zint();
      if (header & MORE) skipExtensions(reader);
      skipValue(reader, header);
    } else {
      throw new Error(`a network message of kind ${kind}`);
    }
  }

  /** A key as it is written, or the prefix that the router has given a number, and the rest. */
  #key(reader: Reader, header: number): string {
    const id = reader.zint();
    const suffix = header & NAMED ? reader.text() : '';
    return (id ? (this.#keys.get(id) ?? '') : '') + suffix;
  }

  #body(reader: Reader): [Buffer, Buffer] | undefined {
    const header = reader.byte();
    if (header & 0x20) {
      reader.zint(); // a timestamp, and whose it is
      reader.slice();
    }
    if ((header & 0x1f) === Z.DEL) {
      if (header & MORE) skipExtensions(reader);
      return undefined;
    }
    if ((header & 0x1f) !== Z.PUT) throw new Error(`a body of kind ${header & 0x1f}`);
    if (header & 0x40) skipEncoding(reader);
    const found = header & MORE ? skipExtensions(reader) : new Map<number, Buffer>();
    return [Buffer.from(reader.slice()), found.get(ATTACHMENT) ?? Buffer.alloc(0)];
  }

  #hearResponse(id: number, reader: Reader): void {
    const header = reader.byte();
    if ((header & 0x1f) === Z.REPLY) {
      if (header & 0x20) reader.byte();
      if (header & MORE) skipExtensions(reader);
      const body = this.#body(reader);
      const question = this.#questions.get(id);
      this.#questions.delete(id);
      if (body) question?.take(body[0]);
    } else {
      if (header & 0x40) skipEncoding(reader);
      if (header & MORE) skipExtensions(reader);
      this.#fail(id, reader.text());
    }
  }

  #fail(id: number, why: string): void {
    const question = this.#questions.get(id);
    this.#questions.delete(id);
    question?.fail(new NoAnswer(why));
  }

  #hearDeclaration(reader: Reader): void {
    const header = reader.byte();
    const kind = header & 0x1f;
    if (kind === D.FINAL) {
      if (header & MORE) skipExtensions(reader);
      return;
    }
    const id = reader.zint();
    const named = kind === D.KEY || kind === D.SUBSCRIBER || kind === D.QUERYABLE || kind === D.TOKEN;
    const key = named ? this.#key(reader, header) : '';
    if (header & MORE) skipExtensions(reader);
    if (kind === D.KEY) this.#keys.set(id, key);
    else if (kind === D.UN_KEY) this.#keys.delete(id);
    else if (kind === D.TOKEN) {
      this.#tokens.set(id, key);
      for (const watch of this.#watches) watch(key, true);
    } else if (kind === D.UN_TOKEN) {
      const gone = this.#tokens.get(id);
      this.#tokens.delete(id);
      if (gone !== undefined) for (const watch of this.#watches) watch(gone, false);
    }
  }

  #skipInterest(reader: Reader, header: number): void {
    reader.zint();
    if (header & 0x60) {
      const options = reader.byte();
      if (options & 0x10) this.#key(reader, options);
    }
    if (header & MORE) skipExtensions(reader);
  }
}

/** The head of a message about a key that is written out. */
function named(writer: Writer, kind: number, key: string, request?: number): Writer {
  writer.byte(kind | NAMED | SENDERS);
  if (request !== undefined) writer.zint(request);
  return writer.zint(0).text(key);
}

/** Read over extensions; those that are bytes are told by their number. */
function skipExtensions(reader: Reader): Map<number, Buffer> {
  const found = new Map<number, Buffer>();
  for (;;) {
    const header = reader.byte();
    const value = skipValue(reader, header);
    if (value) found.set(header & 0x0f, value);
    if (!(header & MORE)) return found;
  }
}

/** Nothing, a number or bytes, as bits 5 and 6 of a header say. */
function skipValue(reader: Reader, header: number): Buffer | undefined {
  if ((header & 0x60) === 0x20) skipNumber(reader);
  if ((header & 0x60) === EXT_BYTES) return Buffer.from(reader.slice());
  return undefined;
}

/** A number of 64 bits, which may be too large for ours. */
function skipNumber(reader: Reader): void {
  for (let bytes = 1; reader.byte() >= 0x80 && bytes < 9; bytes += 1);
}

function skipEncoding(reader: Reader): void {
  const id = reader.zint();
  if (id & 1) reader.slice();
}

/** Whether a key matches a pattern: `*` is one chunk, a last `**` any number; neither matches a chunk with an `@`. */
export function matches(pattern: string, key: string): boolean {
  if (pattern === key) return true;
  const wanted = pattern.split('/');
  const chunks = key.split('/');
  for (let place = 0; place < wanted.length; place += 1) {
    if (wanted[place] === '**') return chunks.slice(place).every((chunk) => !chunk.startsWith('@'));
    const chunk = chunks[place];
    if (chunk === undefined) return false;
    if (wanted[place] === '*' ? chunk.startsWith('@') : wanted[place] !== chunk) return false;
  }
  return wanted.length === chunks.length;
}
