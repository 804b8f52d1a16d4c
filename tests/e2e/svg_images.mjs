// Looks into an SVG that gnuplot wrote. Arguments: file, then what to print:
//   check      fails unless every tag is closed and every number is one
//   images     one line "number width height channels" per picture in it
//   N x,y ...  pixels of picture N, one line "R G B [A]" each
//   text       the text of each label, one a line
import { readFileSync } from 'node:fs';
import { inflateSync } from 'node:zlib';

function readPng(b) {
    const width = b.readUInt32BE(16), height = b.readUInt32BE(20), channels = { 2: 3, 6: 4 }[b[25]], stride = channels * width, parts = [];
    if (b[24] !== 8 || !channels || b[28]) throw new Error('an 8-bit RGB or RGBA picture is wanted');
    for (let at = 8; at < b.length; at += 12 + b.readUInt32BE(at))
        if (b.toString('latin1', at + 4, at + 8) === 'IDAT') parts.push(b.subarray(at + 8, at + 8 + b.readUInt32BE(at)));
    const raw = inflateSync(Buffer.concat(parts)), out = Buffer.alloc(stride * height);
    for (let i = 0; i < out.length; i++) {
        const y = Math.floor(i / stride), x = i % stride, filter = raw[y * (stride + 1)];
        const left = x >= channels ? out[i - channels] : 0, up = y ? out[i - stride] : 0, corner = x >= channels && y ? out[i - stride - channels] : 0;
        const p = left + up - corner, d = [Math.abs(p - left), Math.abs(p - up), Math.abs(p - corner)];
        const paeth = d[0] <= d[1] && d[0] <= d[2] ? left : d[1] <= d[2] ? up : corner;
        out[i] = raw[y * (stride + 1) + 1 + x] + [0, left, up, (left + up) >> 1, paeth][filter];
    }
    return { width, height, channels, at: (x, y) => [...out.subarray(y * stride + channels * x, y * stride + channels * (x + 1))] };
}

function check(svg) {
    const open = [], body = svg.replace(/<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>]*>/gs, '');
    for (const [tag, end, name, rest] of body.matchAll(/<(\/?)([A-Za-z]+)((?:"[^"]*"|'[^']*'|[^'">])*)>/g)) {
        if (end) { if (open.pop() !== name) throw new Error(`${tag} closes nothing`); }
        else if (!rest.endsWith('/')) open.push(name);
        if (/\b(nan|inf)\b/i.test(rest.replace(/href='[^']*'/, ''))) throw new Error(`no number: ${tag.slice(0, 80)}`);
    }
    if (open.length || !body.trim().startsWith('<svg') || !body.trim().endsWith('</svg>')) throw new Error(`not closed: ${open}`);
}

const [file, what, ...points] = process.argv.slice(2), svg = readFileSync(file, 'utf8');
const images = [...svg.matchAll(/href='data:image\/png;base64,([^']*)'/g)].map((m) => readPng(Buffer.from(m[1], 'base64')));
if (what === 'check') check(svg);
else if (what === 'images') images.forEach((i, n) => console.log(n, i.width, i.height, i.channels));
else if (what === 'text') for (const m of svg.matchAll(/<text>(.*?)<\/text>/gs)) console.log(m[1].replace(/<[^>]*>/g, ''));
else for (const point of points) console.log(images[what].at(...point.split(',').map(Number)).join(' '));
