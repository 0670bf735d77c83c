/** Bytes as Zenoh writes them: whole numbers of seven bits a byte, and slices with their length before them. */

export class Writer {
  #parts: Uint8Array[] = [];

  byte(value: number): this {
    return this.raw(Uint8Array.of(value));
  }

  uint16(value: number): this {
    return this.raw(Uint8Array.of(value & 0xff, value >> 8));
  }

  /** A whole number, the lowest seven bits first; the highest bit of a byte says that more follow. */
  zint(value: number): this {
    const bytes: number[] = [];
    while (value > 0x7f) {
      bytes.push((value % 128) | 0x80);
      value = Math.floor(value / 128);
    }
    bytes.push(value);
    return this.raw(Uint8Array.from(bytes));
  }

  slice(bytes: Uint8Array): this {
    return this.zint(bytes.length).raw(bytes);
  }

  text(value: string): this {
    return this.slice(Buffer.from(value));
  }

  raw(bytes: Uint8Array): this {
    this.#parts.push(bytes);
    return this;
  }

  bytes(): Buffer {
    return Buffer.concat(this.#parts);
  }
}

export class Reader {
  #bytes: Buffer;
  #at = 0;

  constructor(bytes: Uint8Array) {
    this.#bytes = Buffer.from(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  get left(): number {
    return this.#bytes.length - this.#at;
  }

  byte(): number {
    return this.raw(1)[0]!;
  }

  uint16(): number {
    const bytes = this.raw(2);
    return bytes[0]! | (bytes[1]! << 8);
  }

  zint(): number {
    let value = 0;
    for (let place = 1; ; place *= 128) {
      const byte = this.byte();
      value += (byte & 0x7f) * place;
      // The ninth byte of a 64-bit number has eight bits; what we read is never that long.
      if (byte < 0x80) return value;
      if (place > 2 ** 56) throw new Error('a number without an end');
    }
  }

  slice(): Buffer {
    return this.raw(this.zint());
  }

  text(): string {
    return this.slice().toString();
  }

  raw(length: number): Buffer {
    if (length > this.left) throw new Error(`${length} bytes wanted, ${this.left} left`);
    this.#at += length;
    return this.#bytes.subarray(this.#at - length, this.#at);
  }

  rest(): Buffer {
    return this.raw(this.left);
  }
}
