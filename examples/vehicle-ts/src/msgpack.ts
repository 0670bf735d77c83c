/** As much of MessagePack as seals and bodies need. */

export type Value = null | boolean | number | string | Uint8Array | readonly Value[] | { readonly [name: string]: Value };

export function pack(value: Value): Buffer {
  const parts: Uint8Array[] = [];
  write(value, parts);
  return Buffer.concat(parts);
}

export function unpack(bytes: Uint8Array): Value {
  const reader = { bytes: Buffer.from(bytes), at: 0 };
  const value = read(reader);
  if (reader.at !== reader.bytes.length) throw new Error('more bytes than one value');
  return value;
}

function write(value: Value, parts: Uint8Array[]): void {
  if (value === null) parts.push(Uint8Array.of(0xc0));
  else if (typeof value === 'boolean') parts.push(Uint8Array.of(value ? 0xc3 : 0xc2));
  else if (typeof value === 'number') parts.push(number(value));
  else if (typeof value === 'string') {
    const bytes = Buffer.from(value);
    parts.push(head(bytes.length, 0xa0, 31, [0xd9, 0xda, 0xdb]), bytes);
  } else if (value instanceof Uint8Array) parts.push(head(value.length, 0, -1, [0xc4, 0xc5, 0xc6]), value);
  else if (Array.isArray(value)) {
    parts.push(head(value.length, 0x90, 15, [undefined, 0xdc, 0xdd]));
    for (const each of value as readonly Value[]) write(each, parts);
  } else {
    const entries = Object.entries(value);
    parts.push(head(entries.length, 0x80, 15, [undefined, 0xde, 0xdf]));
    for (const [name, each] of entries) {
      write(name, parts);
      write(each, parts);
    }
  }
}

/** The length of what follows, in the shortest form that there is of it. */
function head(length: number, short: number, shortMax: number, forms: (number | undefined)[]): Uint8Array {
  if (length <= shortMax) return Uint8Array.of(short | length);
  if (length < 2 ** 8 && forms[0] !== undefined) return Uint8Array.of(forms[0], length);
  if (length < 2 ** 16) return Uint8Array.of(forms[1]!, length >> 8, length & 0xff);
  const bytes = Buffer.alloc(5);
  bytes.writeUInt8(forms[2]!);
  bytes.writeUInt32BE(length, 1);
  return bytes;
}

function number(value: number): Uint8Array {
  if (Number.isInteger(value) && value >= 0 && value < 128) return Uint8Array.of(value);
  const bytes = Buffer.alloc(9);
  if (Number.isSafeInteger(value)) {
    bytes.writeUInt8(value < 0 ? 0xd3 : 0xcf);
    if (value < 0) bytes.writeBigInt64BE(BigInt(value), 1);
    else bytes.writeBigUInt64BE(BigInt(value), 1);
  } else {
    bytes.writeUInt8(0xcb);
    bytes.writeDoubleBE(value, 1);
  }
  return bytes;
}

interface Input {
  readonly bytes: Buffer;
  at: number;
}

function take(input: Input, length: number): Buffer {
  if (input.at + length > input.bytes.length) throw new Error('cut off');
  input.at += length;
  return input.bytes.subarray(input.at - length, input.at);
}

function uint(input: Input, size: number): number {
  return size === 8 ? Number(take(input, 8).readBigUInt64BE()) : take(input, size).readUIntBE(0, size);
}

function read(input: Input): Value {
  const form = uint(input, 1);
  if (form < 0x80) return form;
  if (form < 0x90) return map(input, form & 0x0f);
  if (form < 0xa0) return array(input, form & 0x0f);
  if (form < 0xc0) return take(input, form & 0x1f).toString();
  if (form >= 0xe0) return form - 256;
  switch (form) {
    case 0xc0:
      return null;
    case 0xc2:
    case 0xc3:
      return form === 0xc3;
    case 0xc4:
    case 0xc5:
    case 0xc6:
      return Buffer.from(take(input, uint(input, 1 << (form - 0xc4))));
    case 0xca:
      return take(input, 4).readFloatBE();
    case 0xcb:
      return take(input, 8).readDoubleBE();
    case 0xcc:
    case 0xcd:
    case 0xce:
    case 0xcf:
      return uint(input, 1 << (form - 0xcc));
    case 0xd0:
      return take(input, 1).readInt8();
    case 0xd1:
      return take(input, 2).readInt16BE();
    case 0xd2:
      return take(input, 4).readInt32BE();
    case 0xd3:
      return Number(take(input, 8).readBigInt64BE());
    case 0xd9:
    case 0xda:
    case 0xdb:
      return take(input, uint(input, 1 << (form - 0xd9))).toString();
    case 0xdc:
    case 0xdd:
      return array(input, uint(input, 2 << (form - 0xdc)));
    case 0xde:
    case 0xdf:
      return map(input, uint(input, 2 << (form - 0xde)));
    default:
      throw new Error(`nothing begins with ${form}`);
  }
}

function array(input: Input, length: number): Value[] {
  return Array.from({ length }, () => read(input));
}

function map(input: Input, length: number): Value {
  const found: Record<string, Value> = {};
  for (let place = 0; place < length; place += 1) {
    const name = read(input);
    if (typeof name !== 'string') throw new Error('a name that is no text');
    found[name] = read(input);
  }
  return found;
}
