// Prints pixels of an RGB image: one line "R G B" per "x,y" argument after the file's name, or all of "x,y,step,width,height". Reads just
// what the tools write, PNG of 8 bits and EXR of zip-compressed 32-bit floats, and the screen file of Xvfb -fbdir, XWD.
import { readFileSync } from 'node:fs';
import { inflateSync } from 'node:zlib';

function readPng(b) {
    const width = b.readUInt32BE(16), stride = 3 * width, parts = [];
    for (let at = 8; at < b.length; at += 12 + b.readUInt32BE(at))
        if (b.toString('latin1', at + 4, at + 8) === 'IDAT') parts.push(b.subarray(at + 8, at + 8 + b.readUInt32BE(at)));
    const raw = inflateSync(Buffer.concat(parts)), out = Buffer.alloc(stride * b.readUInt32BE(20));
    for (let i = 0; i < out.length; i++) {
        const y = Math.floor(i / stride), x = i % stride, filter = raw[y * (stride + 1)];
        const left = x >= 3 ? out[i - 3] : 0, up = y ? out[i - stride] : 0, corner = x >= 3 && y ? out[i - stride - 3] : 0;
        const p = left + up - corner, d = [Math.abs(p - left), Math.abs(p - up), Math.abs(p - corner)];
        const paeth = d[0] <= d[1] && d[0] <= d[2] ? left : d[1] <= d[2] ? up : corner;
        out[i] = raw[y * (stride + 1) + 1 + x] + [0, left, up, (left + up) >> 1, paeth][filter];
    }
    return (x, y) => [...out.subarray(y * stride + 3 * x, y * stride + 3 * x + 3)];
}

function readExr(b) {
    let at = 8, width, height, compression;
    const text = () => { const from = at; while (b[at]) at++; return b.toString('latin1', from, at++); };
    for (let name; (name = text());) {
        text();
        const bytes = b.readUInt32LE(at);
        at += 4;
        if (name === 'dataWindow') [width, height] = [b.readInt32LE(at + 8) + 1, b.readInt32LE(at + 12) + 1];
        if (name === 'compression') compression = b[at];
        at += bytes;
    }
    const rows = [];
    for (let i = 0; i < Math.ceil(height / 16); i++) { // compression 3: 16 rows per chunk
        const chunk = Number(b.readBigUInt64LE(at + 8 * i)), size = b.readUInt32LE(chunk + 4), stored = b.subarray(chunk + 8, chunk + 8 + size);
        const count = Math.min(16, height - 16 * i), bytes = 12 * width * count;
        const raw = size < bytes ? inflateSync(stored) : stored, out = Buffer.alloc(bytes);
        for (let k = 1; size < bytes && k < bytes; k++) raw[k] += raw[k - 1] - 128;
        for (let k = 0; k < bytes; k++) out[k] = size < bytes ? raw[(k >> 1) + (k & 1) * ((bytes + 1) >> 1)] : raw[k];
        for (let k = 0; k < count; k++) rows.push(out.subarray(12 * width * k, 12 * width * (k + 1)));
    }
    if (compression !== 3) throw new Error(`compression ${compression}`);
    return (x, y) => [2, 1, 0].map((c) => rows[y].readFloatLE(4 * (c * width + x))); // planes are B, G, R
}

function readXwd(b) {
    const at = b.readUInt32BE(0) + 12 * b.readUInt32BE(76), stride = b.readUInt32BE(48); // behind header and colour table: 32 bits, B first
    return (x, y) => [2, 1, 0].map((c) => b[at + y * stride + 4 * x + c]);
}

const [file, ...points] = process.argv.slice(2), bytes = readFileSync(file);
const pixel = bytes[0] === 0x89 ? readPng(bytes) : bytes[7] === 7 ? readXwd(bytes) : readExr(bytes); // XWD is of version 7
for (const point of points) {
    const [x0, y0, step = 1, width = 1, height = 1] = point.split(',').map(Number), lines = [];
    for (let y = 0; y < height; y++)
        for (let x = 0; x < width; x++) lines.push(pixel(x0 + Math.floor(x * step), y0 + Math.floor(y * step)).join(' '));
    console.log(lines.join('\n'));
}
