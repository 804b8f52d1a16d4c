#!/usr/bin/env bash
# gtscene's command line: what it accepts, what it refuses and how it says so.
. tests/e2e/gtscene_common.sh

# A small scene with a given line changed by a sed expression.
scene() { # sed_expression
    cat >"$work/base.json" <<'JSON'
{
  "meshes": [{"name": "m", "shape": "sphere", "segments": 4}],
  "materials": [{"name": "a", "model": "measured", "slot": 3, "kd": [0.5, 0.5, 0.5], "ks": [0, 0, 0], "exponent": 8}],
  "objects": [{"mesh": "m", "material": "a", "position": [0, 0, 0], "rotation": [10, 20, 30], "scale": 1}],
  "lights": [{"direction": [0, 1, 1], "irradiance": [1, 1, 1]}],
  "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 40, "near": 0.5},
  "output": {"exposure": 1, "tone_curve": "aces", "background": "#102030"}
}
JSON
    sed -E "$1" "$work/base.json" >"$work/s.json"
    cmp -s "$work/base.json" "$work/s.json" && [ -n "$1" ] && echo "the change did not apply: $1" && return 1
    return 0
}
build() { # [sed_expression [options]]
    scene "${1-}" && "$G" build "$work/s.json" -o "$work/good.blob" "${@:2}"
}
bad() { # sed_expression code pattern
    scene "$1" && refused "$2" "$3" "$G" build "$work/s.json" -o "$work/x.blob"
}
bad_mesh() { # file_name code pattern: a scene whose mesh is that file
    bad "s/\"shape\".*segments\": 4/\"file\": \"$1\"/" "$2" "$3"
}
info_has() { # pattern...
    local p
    "$G" info "$work/good.blob" >"$work/info" || return 1
    for p in "$@"; do grep -qE "$p" "$work/info" || { echo "no line like: $p"; cat "$work/info"; return 1; }; done
}

# --- shapes ---
for shape in sphere rounded_cube knot vase gear spring; do
    check "$shape has about 5000 triangles by default" bash -c "
        printf '%s' '{\"meshes\":[{\"name\":\"m\",\"shape\":\"$shape\"}],\"materials\":[{\"name\":\"a\",\"model\":\"lafortune_phong\"}],
        \"objects\":[{\"mesh\":\"m\",\"material\":\"a\"}],\"lights\":[],\"camera\":{\"eye\":[0,0,5],\"target\":[0,0,0],\"fov_y\":40}}' >$work/shape.json
        $G build $work/shape.json -o $work/shape.blob && $G info $work/shape.blob | awk '/^drawn/ { exit !(\$2 >= 4600 && \$2 <= 5400) }'"
done
smallest() { # shape parameters_at_their_lowest
    build "s/\"shape\".*segments\": 4/\"shape\": \"$1\", $2/" && "$G" info "$work/good.blob"
}
check "shapes build at their coarsest" eval 'smallest sphere "\"segments\": 2" && smallest rounded_cube "\"segments\": 2, \"exponent\": 12" &&
    smallest knot "\"rings\": 24, \"sides\": 3, \"major\": 0.5, \"minor\": 0.2, \"depth\": 0.5" && smallest vase "\"rings\": 17, \"sides\": 3" &&
    smallest gear "\"teeth\": 3, \"samples\": 4, \"sides\": 8" && smallest spring "\"rings\": 8, \"sides\": 3, \"turns\": 0.5"'

# --- the blob ---
check "a scene builds and info describes it" eval 'build && info_has "^drawn +192 " "^objects +1 " "^lights +1 " "slot  3 measured"'
check "two builds give the same bytes" eval '"$G" build host_tools/scenes/six_models.json -o "$work/1" &&
    "$G" build host_tools/scenes/six_models.json -o - >"$work/2" && cmp "$work/1" "$work/2"'
check "an object without lights and rotation, and a light by colour, build" eval \
    'build "s/\"irradiance\": \[1, 1, 1\]/\"color\": [1, 0.5, 0], \"intensity\": 2/; s/\"rotation\": [^]]*\]/\"rotation\": {\"axis\": [0, 1, 0], \"degrees\": -90}/"'
point='s/"direction".*irradiance": \[1, 1, 1\]/"type": "point", "position": [1, -2.5, 3], "power": 60, "radius": 7.5/'
metal='s/"measured".*exponent": 8/"metallic_roughness", "base_color": [1, 0.5, 0], "metalness": 1, "roughness": 0.25/'
bytes() { # array_number offset count: bytes of the first element of an array of the blob, in decimal
    local at
    at=$(od -An -tu4 -j $((76 + 8 * $1)) -N 4 "$work/good.blob")
    od -An -tu4 -v -w64 -j $((at + $2)) -N "$3" "$work/good.blob" | xargs
}
check "a point light builds: power over 4 pi, radius" eval 'build "$point" && info_has "^lights +1 " "^light +0 point at 1, -2.5, 3, ends at 7.5$" &&
    [ "$(bytes 0 0 32)" = "1 65536 4294803456 196608 312911 312911 312911 491520" ]'
check "a point light of three powers builds" eval 'build "$point; s/\"power\": 60/\"power\": [0, 60, 800000]/" &&
    [ "$(bytes 0 16 12)" = "0 312911 4172151340" ]'
check "an object may name a table slot instead of a material" eval 'build "s/\"material\": \"a\", \"position\"/\"slot\": 7, \"position\"/" && info_has "^materials +2 " "slot 7 +slot +7 measured$"'
check "an object of a slot that a material has gets that material" eval 'build "s/\"material\": \"a\", \"position\"/\"slot\": 3, \"position\"/" && info_has "^materials +1 "'
check "a slot beside a material is refused" bad 's/"material": "a", "position"/"material": "a", "slot": 3, "position"/' 4 'objects\[0\]\.slot: given beside a material; give one or the other'
check "a slot beyond the last is refused" bad 's/"material": "a", "position"/"slot": 16, "position"/' 4 'objects\[0\]\.slot: 16 is out of range; give a number from 0 to 15'
check "a light may say that it is directional" eval 'build "s/\"direction\"/\"type\": \"directional\", \"direction\"/" && info_has "^light +0 directional from 0.0000, 0.7071, 0.7071, irradiance 1.0000, 1.0000, 1.0000$"'
many() { scene "/\"lights\"/s/(\{.*\})/$(printf '\\1,%.0s' {1..127})\1/" && "$G" build "$work/s.json" -o "$work/good.blob"; }
check "128 lights build" eval 'many && info_has "^lights +128 "'
check "a metallic-roughness material builds" eval 'build "$metal" && info_has "slot  0 metallic_roughness$" &&
    [ "$(bytes 1 0 40)" = "3 65536 32768 0 0 0 0 65536 65536 16384" ]'
check "metalness and roughness of a metallic-roughness material have defaults" eval 'build "$metal; s/, \"metalness.*0\.25//" &&
    [ "$(bytes 1 32 8)" = "0 32768" ]'
check "another material says what it is as metallic-roughness" eval 'build "s/\"exponent\": 8/\"exponent\": 8, \"metalness\": 0.5, \"roughness\": 1/" &&
    [ "$(bytes 1 32 8)" = "32768 65536" ]'
check "a scene without objects builds" eval 'build "/\"objects\"/s/\[\{.*/[],/" && info_has "^objects +0 "'

# --- levels of detail ---
scene "" && sed -i 's/"segments": 4/"segments": 20/' "$work/s.json" && cp "$work/s.json" "$work/fine.json"
fine() { "$G" build "$work/fine.json" -o "$work/good.blob" "$@"; }
check "a mesh gets a chain of levels" eval 'fine && info_has "^drawn +4800 " "^lods +[5-9] " "^lod error +0.500 " "^mesh +0 .*: 4800 \(0\) 2[0-9]{3} \([1-9]"'
check "--no-lod stores the finest level only" eval 'fine --no-lod && info_has "^drawn +4800 " "^lods +1 " "^triangles +4800 "'
check "--lod-error sets the threshold" eval 'fine --lod-error 2.25 && info_has "^lod error +2.250 "'
check "the scene file sets the threshold, an option overrules it" eval 'build "s/\"tone_curve\"/\"lod_error\": 0.75, \"tone_curve\"/" && info_has "^lod error +0.750 " &&
    build "s/\"tone_curve\"/\"lod_error\": 0.75, \"tone_curve\"/" --lod-error 0 && info_has "^lod error +0.000 "'
check "a threshold out of range is refused" eval 'refused 2 "lod-error.*64" "$G" build "$work/s.json" -o "$work/x.blob" --lod-error 65 &&
    bad "s/\"tone_curve\"/\"lod_error\": 65, \"tone_curve\"/" 4 "output\.lod_error: .*out of range"'
check "a mesh of one million triangles builds" eval 'scene "s/\"sphere\", \"segments\": 4/\"knot\", \"rings\": 1250, \"sides\": 400/" &&
    "$G" build "$work/s.json" -o "$work/good.blob" && info_has "^drawn +1000000 " "^lods +1[0-9] "'

# --- scene files ---
check "malformed JSON is refused with its line" bad '/"lights"/s/:/;/' 4 's\.json:5:[0-9]+: not valid JSON'
check "text after the document is refused" bad '$s/$/ x/' 4 'not valid JSON'
check "an unknown key is refused with its place" bad 's/"target"/"look"/' 4 's\.json: camera\.look: unknown key; known here: eye, target'
check "a key of another shape is refused" bad 's/"segments"/"teeth"/' 4 'meshes\[0\]\.teeth: unknown key; known here: name, shape, segments$'
check "a key given twice is refused" bad 's/"near": 0.5/"near": 0.5, "near": 1/' 4 'camera\.near: given twice'
check "a missing key is refused" bad 's/, "fov_y": 40//' 4 'camera\.fov_y: missing'
check "a missing slot of a measured material is refused" bad 's/"slot": 3, //' 4 'materials\[0\]\.slot: missing'
check "a value of the wrong type is refused" bad 's/"scale": 1/"scale": "1"/' 4 'objects\[0\]\.scale: not a number'
check "a vector of two is refused" bad 's/\[0, 0, 5\]/[0, 5]/' 4 'camera\.eye: not three numbers'
check "an unknown shape is refused" bad 's/"sphere"/"sphinx"/' 4 "meshes\[0\]\.shape: 'sphinx' is no built-in shape"
nowhere() {
    scene 's/"shape": "sphere", "segments": 4/"file": "no.obj"/' && grep -q no.obj "$work/s.json" &&
        refused 3 "meshes\\[0\\] 'm': .*no\\.obj: No such file.*; put it beside .* --data" "$G" build "$work/s.json" -o "$work/x.blob"
}
check "a missing mesh file is named, with its entry and what to do" nowhere
lonely() {
    scene '' && for option in '--envmap-lights 8' '--envmap-scale 2' '--envmap-rotate 3'; do
        refused 2 "${option% *}: .*; give --envmap FILE" "$G" build "$work/s.json" -o "$work/x.blob" $option || return 1
    done
}
check "options of an environment map without one are refused" lonely
prints_nowhere() {
    for command in --help --version 'build --help' "info $work/good.blob"; do
        "$G" $command >/dev/full 2>"$work/err"
        [ $? = 3 ] && [ "$(wc -l <"$work/err")" = 1 ] || { echo "$command"; cat "$work/err"; return 1; }
    done
}
check "what cannot be printed is exit code 3" prints_nowhere
check "an unknown mesh is refused" bad 's/"mesh": "m"/"mesh": "q"/' 4 "objects\[0\]\.mesh: 'q' is not among the meshes"
check "an unknown material is refused" bad 's/"material": "a"/"material": "q"/' 4 "objects\[0\]\.material: 'q' is not among"
check "an unknown model is refused" bad 's/"measured"/"magic"/' 4 "materials\[0\]\.model: 'magic' is no model"
check "an unknown tone curve is refused" bad 's/"aces"/"filmic"/' 4 "output\.tone_curve: 'filmic'"
check "a colour that is none is refused" bad 's/#102030/#10203g/' 4 "output\.background: '#10203g'"
check "a name of 16 characters is refused" bad 's/"name": "a"/"name": "abcdefghijklmnop"/' 4 'has 16 characters; give 1 to 15'
check "a second mesh of the same name is refused" bad 's/"segments": 4\}/"segments": 4}, {"name": "m", "shape": "knot"}/' 4 \
    "meshes\[1\]\.name: 'm' is taken"
check "129 lights are refused" bad "/\"lights\"/s/(\{.*\})/$(printf '\\1,%.0s' {1..128})\1/" 4 'lights: 129 elements, more than the limit of 128'

# key, value out of range, the place reported
while read -r key value place; do
    check "$place out of range is refused" bad "s/\"$key\": (\[[^]]*\]|[0-9.]+)/\"$key\": $value/" 4 "$place: .*(out of range; give|not a whole number)"
done <<'EOT'
segments 401 meshes\[0\]\.segments
segments 2.5 meshes\[0\]\.segments
slot 16 materials\[0\]\.slot
kd [0,1.01,0] materials\[0\]\.kd\[1\]
ks [-0.1,0,0] materials\[0\]\.ks\[0\]
exponent 4097 materials\[0\]\.exponent
position [0,0,40000] objects\[0\]\.position\[2\]
rotation [0,361,0] objects\[0\]\.rotation\[1\]
scale 0 objects\[0\]\.scale
scale 1e999 objects\[0\]\.scale
irradiance [257,0,0] lights\[0\]\.irradiance\[0\]
eye [0,1e9,0] camera\.eye\[1\]
fov_y 180 camera\.fov_y
near 0 camera\.near
exposure 257 output\.exposure
EOT
bad_light() { bad "$point; $1" 4 "$2"; }
bad_metal() { bad "$metal; $1" 4 "$2"; }
check "an unknown type of light is refused" bad_light 's/"point"/"spot"/' "lights\[0\]\.type: 'spot' is no type of light; give directional or point"
check "a point light without position is refused" bad_light 's/"position": \[1, -2.5, 3\], //' 'lights\[0\]\.position: missing'
check "a point light without radius is refused" bad_light 's/, "radius": 7.5//' 'lights\[0\]\.radius: missing'
check "a point light without power is refused" bad_light 's/"power": 60, //' 'lights\[0\]\.power: missing'
check "a point light's radius of zero is refused" bad_light 's/7\.5/0/' 'lights\[0\]\.radius: 0 is out of range; give a number from 0.001 to 32768'
check "a point light's radius that is too large is refused" bad_light 's/7\.5/32769/' 'lights\[0\]\.radius: 32769 is out of range'
check "a point light's power that is too large is refused" bad_light 's/60/800001/' 'lights\[0\]\.power: 800001 is out of range; give a number from 0 to 800000'
check "a point light's negative power is refused" bad_light 's/60/[1, 2, -3]/' 'lights\[0\]\.power\[2\]: -3 is out of range'
check "a point light far away is refused" bad_light 's/-2\.5/40000/' 'lights\[0\]\.position\[1\]: 40000 is out of range'
check "irradiance of a point light is refused" bad_light 's/"power"/"irradiance"/' 'lights\[0\]\.irradiance: unknown key; known here: type, position, power, radius$'
check "kd of a metallic-roughness material is refused" bad_metal 's/base_color/kd/' 'materials\[0\]\.kd: unknown key; known here: name, model, slot, base_color, metalness, roughness$'
check "base colour of another material is refused" bad 's/"kd"/"base_color"/' 4 'materials\[0\]\.base_color: unknown key'
check "a base colour out of range is refused" bad_metal 's/\[1, 0.5, 0\]/[1, 1.5, 0]/' 'materials\[0\]\.base_color\[1\]: 1.5 is out of range'
check "a metalness out of range is refused" bad_metal 's/"metalness": 1/"metalness": 1.1/' 'materials\[0\]\.metalness: 1.1 is out of range; give a number from 0 to 1$'
check "a roughness below the least is refused" bad_metal 's/0\.25/0.03/' 'materials\[0\]\.roughness: 0.03 is out of range; give a number from 0.03125 to 1$'
check "a light without direction is refused" bad 's/\[0, 1, 1\]/[0, 0, 0]/' 4 'lights\[0\]\.direction: has no direction'
check "an eye at the target is refused" bad 's/\[0, 0, 5\]/[0, 0, 0]/' 4 'camera\.target: is where the eye is'
check "an up along the view is refused" bad 's/"up": \[0, 1, 0\]/"up": [0, 0, 2]/' 4 'camera\.up: points along the view'
check "an object that is too large is refused" bad 's/"scale": 1\}/"scale": 1e6}/' 4 'objects\[0\]: .* out of range'
{ head -c 17000000 /dev/zero | tr '\0' ' '; } >"$work/long.json"
check "a scene file that is too long is refused" refused 4 'long\.json: longer than the limit of' "$G" build "$work/long.json" -o "$work/x.blob"
check "a missing scene file is refused" refused 3 'nowhere.json: No such file' "$G" build "$work/nowhere.json" -o "$work/x.blob"
head -c 200 /dev/urandom >"$work/noise.json"
check "a scene file of noise is refused" refused 4 'noise\.json' "$G" build "$work/noise.json" -o "$work/x.blob"
check "an output folder that is not there is refused" eval 'scene "" && refused 3 "nowhere/x.blob" "$G" build "$work/s.json" -o "$work/nowhere/x.blob"'

# --- mesh files ---
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >"$work/tetra.obj"
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n' >"$work/quad.obj"
printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >"$work/one.ply"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >"$work/points.obj"
printf 'v 0 0 0\nv 1 0 0\nl 1 2\n' >"$work/line.obj"
printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >"$work/flat.obj"
printf 'v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n' >"$work/nan.obj"
printf 'v 5 5 5\nv 5 5 5\nv 5 5 5\nf 1 2 3\n' >"$work/dot.obj"
: >"$work/empty.obj"
truncate -s 513M "$work/huge.obj"
# Two triangles back to back; one triangle whose normals contradict each other; one with a normal of no length.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 -1\nf 1//1 2//1 3//1\nf 1//2 3//2 2//2\n' >"$work/leaf.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 -1\nvn 1 0 0\nf 1//1 2//2 3//3\n' >"$work/odd.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n' >"$work/zero.obj"
cp "$work/noise.json" "$work/noise.glb"
cp "$work/tetra.obj" "$work/tetra.stl"
file() { build "s/\"shape\".*segments\": 4/\"file\": \"$1\"/" "${@:2}"; }
check "an OBJ without normals builds" eval 'file tetra.obj && info_has "^drawn +4 "'
check "polygons are triangulated" eval 'file quad.obj && info_has "^drawn +2 "'
# One tetrahedron without normals; OBJ repeats a vertex for each of its faces, PLY and glTF share it among them.
printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n' >"$work/tetra.ply"
{
    printf '\0\0\0\0\0\0\0\0\0\0\0\0' # four positions, four triangles
    printf '\0\0\200\77\0\0\0\0\0\0\0\0' && printf '\0\0\0\0\0\0\200\77\0\0\0\0' && printf '\0\0\0\0\0\0\0\0\0\0\200\77'
    printf '\0\2\1\0\1\3\0\3\2\1\2\3'
} >"$work/tetra.bin"
gltf() { # name nodes
    printf '{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [%s], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,%s"}], "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}, {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}]}' "$2" "$(base64 -w 0 "$work/tetra.bin")" >"$work/$1.gltf"
}
gltf tetra '{"mesh": 0}'
gltf mirrored '{"children": [1], "scale": [-1, 1, 1]}, {"mesh": 0, "translation": [0.25, 0, 0]}'
gltf shifted '{"mesh": 0, "translation": [0.005, 0, 0]}'
printf 'v -0.25 0 0\nv -1.25 0 0\nv -0.25 1 0\nv -0.25 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n' >"$work/mirrored.obj"
printf 'v 0.005 0 0\nv 1.005 0 0\nv 0.005 1 0\nv 0.005 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >"$work/shifted.obj"
same_picture() { # two mesh files
    local one
    for one in "$@"; do
        build "s/\"shape\".*segments\": 4/\"file\": \"$one\"/; s/measured/lafortune_phong/; s/\"eye\": \[0, 0, 5\]/\"eye\": [1, 2, 5]/" &&
            "$B/gtsim" render "$work/good.blob" -o "$work/$one.png" || return 1
    done
    cmp "$work/$1.png" "$work/$2.png"
}
check "normals generated for a PLY are those of the same OBJ" same_picture tetra.obj tetra.ply
check "normals generated for a glTF are those of the same OBJ" same_picture tetra.obj tetra.gltf
check "a glTF node that mirrors keeps the outside outside" same_picture mirrored.obj mirrored.gltf
check "a glTF node that moves its mesh a little moves it" same_picture shifted.obj shifted.gltf
check "a PLY builds" eval 'file one.ply && info_has "^drawn +1 "'
mkdir -p "$work/meshes" && cp "$work/tetra.obj" "$work/meshes/far.obj"
check "--data names the folder of mesh files" eval 'file far.obj --data "$work/meshes" && info_has "^drawn +4 "'
check "normals more than 90 degrees apart split a meshlet" eval 'file leaf.obj && info_has "^drawn +2 " "^meshlets +2 "'
check "contradicting normals and a zero normal build" eval 'file odd.obj && file zero.obj && info_has "^drawn +1 "'
check "a mesh file that is too long is refused" bad_mesh huge.obj 4 'huge\.obj: 537919488 bytes, more than the limit'
check "a mesh file that is not there is refused" bad_mesh far.obj 3 'far\.obj: No such file'
check "a folder as mesh file is refused" eval 'mkdir "$work/folder.obj"; bad_mesh folder.obj 3 "folder\.obj: Is a directory"'
check "a mesh of points is refused" bad_mesh points.obj 4 'points\.obj'
check "a mesh of lines is refused" bad_mesh line.obj 4 'line\.obj'
check "a mesh without area is refused" bad_mesh flat.obj 4 'flat\.obj: no triangle has an area'
check "a mesh without extent is refused" bad_mesh dot.obj 4 'dot\.obj: the mesh is 0 across'
check "a position that is not a number is refused" bad_mesh nan.obj 4 'nan\.obj'
check "an empty mesh file is refused" bad_mesh empty.obj 4 'empty\.obj: the mesh file is empty'
{ printf '\357\273\277' && cat "$work/tetra.obj"; } >"$work/mark.obj"
check "a mesh file with a byte order mark is refused" bad_mesh mark.obj 4 'mark\.obj: begins with a byte order mark; save it without'
check "noise as a mesh is refused" bad_mesh noise.glb 4 'noise\.glb'
check "a mesh of another type is refused" bad_mesh tetra.stl 4 'tetra\.stl: not a mesh file this program reads'

# --- info ---
build >/dev/null 2>&1
head -c 300 "$work/good.blob" >"$work/short.blob"
check "info refuses a truncated blob" refused 4 'short\.blob: shorter than' "$G" info "$work/short.blob"
check "info refuses a foreign file" refused 4 'noise\.json: not a scene blob' "$G" info "$work/noise.json"
check "info refuses a missing file" refused 3 'nowhere' "$G" info "$work/nowhere"

# --- usage ---
check "no command is a usage error" refused 2 "'' is not a command; see" "$G"
check "an unknown command is a usage error" refused 2 "'make' is not a command" "$G" make
check "a missing output is a usage error" refused 2 'no output file' "$G" build "$work/s.json"
check "two scene files are a usage error" refused 2 '2 scene files given, 1 wanted' "$G" build a b -o "$work/x.blob"
check "an unknown option is a usage error" refused 2 'unrecognized option' "$G" build --fast a -o "$work/x.blob"
check "help goes to stdout" eval '"$G" --help | grep -q "gtscene build" && "$G" build --help | grep -q rounded_cube && "$G" info --help | grep -q blob'
check "the version is printed" eval '"$G" --version | grep -qE "^gtscene [0-9]+\.[0-9]+\.[0-9]+$"'

# --- the scenes that come along ---
for file in host_tools/scenes/*.json; do
    name=$(basename "$file" .json)
    grep -q '"file"' "$file" && continue
    check "$name builds" "$G" build "$file" -o "$work/$name.blob"
done

# --- real meshes ---
D=${GONIOTILE_DATA:-../shared/data}/meshes
real() { # file triangles
    file "$1.obj" --data "$D" && info_has "^drawn +$2 "
}
for mesh in spot_6k:5856 teapot_6k:6320 bunny_5k:5000 dragon_20k:19978; do
    if [ -r "$D/${mesh%:*}.obj" ]; then
        check "${mesh%:*} builds with all its triangles" real "${mesh%:*}" "${mesh#*:}"
    else
        skip "${mesh%:*} builds with all its triangles" "no data folder"
    fi
done
echo "1..$n"
