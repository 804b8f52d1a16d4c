#!/usr/bin/env bash
# Table files through another implementation of KTX 2.0: npm's ktx-parse 2.0, installed into the build folder.
set -u
cd "$(dirname "$0")/../.." || exit 1
B=$(cd "${B:-build}" && pwd) || exit 1
G=$B/gtlut
T=$(mktemp -d) && trap 'rm -rf "$T"' EXIT
MODULE=$B/npm/node_modules/ktx-parse/dist/index.mjs
claims=("ktx-parse reads what was written: format, dimensions, descriptor, metadata, texels"
    "ktx-parse rewrites the file byte-identically"
    "ktx-parse reads an atlas as one texture and rewrites it")

skip_all() {
    for i in "${!claims[@]}"; do echo "ok $((i + 1)) - ${claims[i]} # SKIP $1"; done
    echo "1..${#claims[@]}"
    exit 0
}

command -v npm >/dev/null && command -v node >/dev/null || skip_all "no npm"
if [ ! -e "$MODULE" ]; then
    timeout 120 npm install --prefix "$B/npm" --no-audit --no-fund --no-save ktx-parse@2.0 >"$T/npm" 2>&1
    [ -e "$MODULE" ] || {
        sed 's/^/# /' "$T/npm"
        skip_all "the npm registry did not deliver ktx-parse 2.0"
    }
fi

# usage: node check.mjs module file width height depth source theta_max first_texel; prints what differs, and last "same" or "differs"
cat >"$T/check.mjs" <<'JS'
import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { isDeepStrictEqual } from 'node:util';

const [module, file, width, height, depth, source, thetaMax, firstTexel] = process.argv.slice(2);
const { read, write } = await import(pathToFileURL(module).href);
const bytes = readFileSync(file);
const ktx = read(new Uint8Array(bytes));

const sample = (bitOffset, bitLength, channelType, sampleLower, sampleUpper) =>
    ({ bitOffset, bitLength, channelType, samplePosition: [0, 0, 0, 0], sampleLower, sampleUpper });
const want = {
    vkFormat: 123, typeSize: 4, pixelWidth: +width, pixelHeight: +height, pixelDepth: +depth,
    layerCount: 0, faceCount: 1, levelCount: 1, supercompressionScheme: 0,
    dataFormatDescriptor: [{
        vendorId: 0, descriptorType: 0, versionNumber: 2,
        colorModel: 1, colorPrimaries: 1, transferFunction: 1, flags: 0,
        texelBlockDimension: [0, 0, 0, 0], bytesPlane: [4, 0, 0, 0, 0, 0, 0, 0],
        samples: [0, 1, 2].flatMap((c) => [sample(9 * c, 8, c, 0, 8448), sample(27, 4, c | 0x20, 15, 31)]),
    }],
};
const plain = (x) => JSON.parse(JSON.stringify(x, (key, value) => (ArrayBuffer.isView(value) ? [...value] : value)));
for (const key of Object.keys(want)) {
    let got = plain(ktx[key]);
    if (key === 'dataFormatDescriptor') got = got.map(({ descriptorBlockSize, ...rest }) => rest);
    if (!isDeepStrictEqual(got, want[key])) console.log(`${key}: ${JSON.stringify(got)}, want ${JSON.stringify(want[key])}`);
}
const keys = Object.keys(ktx.keyValue), text = (key) => {
    const value = ktx.keyValue[key]; // bytes but for the writer's name
    return (typeof value === 'string' ? value : Buffer.from(value ?? [])).toString().replace(/\0$/, '');
};
if (!isDeepStrictEqual(keys, [...keys].sort())) console.log(`keys not sorted: ${keys}`);
for (const [key, value] of [['goniotile.kind', 'specular_frame'], ['goniotile.version', '1'], ['goniotile.source', source],
    ['goniotile.theta_max', thetaMax], ['KTXwriter', null], ['goniotile.extrapolation', null]]) {
    if (!keys.includes(key) || (value !== null && text(key) !== value)) console.log(`${key}: ${text(key)}, want ${value}`);
}
if (!text('KTXwriter').startsWith('Goniotile gtlut ')) console.log(`KTXwriter: ${text('KTXwriter')}`);
const level = ktx.levels[0].levelData;
if (ktx.levels.length !== 1 || level.byteLength !== 4 * width * height * depth) console.log(`level: ${level.byteLength} bytes`);
const first = new DataView(level.buffer, level.byteOffset).getUint32(0, true);
if (first !== +firstTexel) console.log(`first texel ${first}, want ${firstTexel}`);
console.log(Buffer.compare(Buffer.from(write(ktx, { keepWriter: true })), bytes) === 0 ? 'same' : 'differs');
JS

# The names' lengths make every padding of the key/value data occur; 0.8/pi is 261 * 2^(14-24).
"$G" measure matte_white -o "$T/white.csv" || echo "measure failed" >>"$T/log"
for name in a ab abc abcd; do
    cp "$T/white.csv" "$T/$name.csv"
    for size in 361x181 91x46 5x3; do
        "$G" build "$T/$name.csv" --size $size -o "$T/t.ktx2" || echo "build failed" >>"$T/log"
        node "$T/check.mjs" "$MODULE" "$T/t.ktx2" ${size%x*} ${size#*x} 4 $name.csv 60000 $((261 * (1 + 512 + 512 * 512) + 14 * 134217728)) \
            >"$T/out" 2>&1
        sed '$d' "$T/out" >>"$T/log"
        tail -1 "$T/out" | grep -qx same || echo "$name $size: $(tail -1 "$T/out")" >>"$T/rewrite"
    done
done
printf 'theta_in,theta_out,phi_out,R,G,B\n0,0,0,1,0.5,0\n0,80,0,1,0.5,0\n' >"$T/one.csv"
"$G" build "$T/one.csv" --size 2x2 -o "$T/t.ktx2" 2>"$T/energy" && node "$T/check.mjs" "$MODULE" "$T/t.ktx2" 2 2 1 one.csv 90000 \
    $((256 + 128 * 512 + 16 * 134217728)) >"$T/out" 2>&1
sed '$d' "$T/out" >>"$T/log"
tail -1 "$T/out" | grep -qx same || echo "one slice: $(tail -1 "$T/out")" >>"$T/rewrite"

# Nine cells of a table each, the last one empty.
cat >"$T/atlas.mjs" <<'JS'
import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
const [module, file, table] = process.argv.slice(2), { read, write } = await import(pathToFileURL(module).href);
const bytes = readFileSync(file), ktx = read(new Uint8Array(bytes)), one = read(new Uint8Array(readFileSync(table)));
const words = (k) => new Uint32Array(k.levels[0].levelData.slice().buffer), all = words(ktx), cell = words(one);
if (`${ktx.vkFormat} ${ktx.pixelWidth} ${ktx.pixelHeight} ${ktx.pixelDepth}` !== '123 273 138 4') console.log('format or size');
if (Buffer.from(ktx.keyValue['goniotile.tables']).toString() !== '8\0') console.log('tables');
for (let i = 0; i < 9; i++)
    for (let at = 0; at < cell.length; at++) {
        const x = at % 91, y = Math.floor(at / 91) % 46, z = Math.floor(at / 91 / 46);
        const got = all[(i % 3) * 91 + x + 273 * (Math.floor(i / 3) * 46 + y + 138 * z)];
        if (got !== (i < 8 ? cell[at] : 0)) { console.log(`cell ${i}, texel ${at}`); break; }
    }
if (Buffer.compare(Buffer.from(write(ktx, { keepWriter: true })), bytes)) console.log('differs when written');
JS
"$G" build "$T/white.csv" --size 91x46 -o "$T/t.ktx2" && "$G" atlas $(printf "$T/t.ktx2 %.0s" 1 2 3 4 5 6 7 8) -o "$T/atlas.ktx2" &&
    node "$T/atlas.mjs" "$MODULE" "$T/atlas.ktx2" "$T/t.ktx2" >"$T/atlas" 2>&1 || echo "failed" >>"$T/atlas"

report() { # number claim file_of_problems
    if [ -s "$3" ]; then
        echo "not ok $1 - $2"
        sed 's/^/# /' "$3" | head -20
    else
        echo "ok $1 - $2"
    fi
}
report 1 "${claims[0]}" "$T/log"
report 2 "${claims[1]}" "$T/rewrite"
report 3 "${claims[2]}" "$T/atlas"
echo "1..3"
