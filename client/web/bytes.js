// Bytes of a stream, which may say anything: whoever reads them asks here, and never beyond what is there.

/// What is wrong with a stream or with this browser, in one line for the person who watches.
export class StreamError extends Error {}

export const expectedFound = (what, expected, found) =>
    new StreamError(`${what}: expected ${expected}, found ${found}`);

/// Of fields one after the other. Running out is a StreamError.
export class ByteReader {
    constructor(bytes, what, littleEndian = false) {
        this.bytes = bytes;
        this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
        this.what = what;
        this.little = littleEndian;
        this.at = 0;
    }

    get left() {
        return this.bytes.length - this.at;
    }

    skip(count) {
        if (!(count <= this.left))
            throw expectedFound(this.what, `${count} more bytes`, `${this.left}`);
        this.at += count;
        return this.at - count;
    }

    take(count) {
        const from = this.skip(count);
        return this.bytes.subarray(from, from + count);
    }

    u8() {
        return this.view.getUint8(this.skip(1));
    }
    u16() {
        return this.view.getUint16(this.skip(2), this.little);
    }
    u32() {
        return this.view.getUint32(this.skip(4), this.little);
    }
    i32() {
        return this.view.getInt32(this.skip(4), this.little);
    }
    u64() {
        return Number(this.view.getBigUint64(this.skip(8), this.little));
    }
    i64() {
        return Number(this.view.getBigInt64(this.skip(8), this.little));
    }
    f32() {
        return this.view.getFloat32(this.skip(4), this.little);
    }
    f64() {
        return this.view.getFloat64(this.skip(8), this.little);
    }
    name() {
        return String.fromCharCode(...this.take(4));
    }
    text(count) {
        return new TextDecoder().decode(this.take(count));
    }
}

/// What has come of a stream and has not been read: grows by push(), shrinks by drop().
export class ByteQueue {
    constructor() {
        this.bytes = new Uint8Array(0);
        this.begin = 0;
        this.end = 0;
    }

    get length() {
        return this.end - this.begin;
    }

    push(more) {
        if (this.end + more.length > this.bytes.length) {
            const room = new Uint8Array(Math.max(2 * (this.length + more.length), 65536));
            room.set(this.bytes.subarray(this.begin, this.end));
            this.end -= this.begin;
            this.begin = 0;
            this.bytes = room;
        }
        this.bytes.set(more, this.end);
        this.end += more.length;
    }

    peek(count) {
        return this.bytes.subarray(this.begin, this.begin + count);
    }

    drop(count) {
        this.begin += count;
    }
}
