# Reads the call graphs that gcc -fcallgraph-info=su writes (.ci) and walks them from a function.
#   awk -f stack.awk -v root=raster_render_tile *.ci   prints the bytes of the deepest path from root
#   awk -f stack.awk *.ci                              checks all: prints functions that recurse or size their stack at run time
# Calls through pointers (the board's functions) and into the run-time library are not followed.
/^node:/ {
    split($0, q, "\"")
    f = q[2]
    if (match(q[4], /[0-9]+ bytes \([a-z,]+\)/)) {
        split(substr(q[4], RSTART, RLENGTH), w, " ")
        bytes[f] = w[1]
        if (w[3] != "(static)") dynamic[f] = w[3]
    }
}
/^edge:/ {
    split($0, q, "\"")
    callees[q[2]] = callees[q[2]] " " q[4]
}
function deepest(f,    n, i, list, d, most) {
    if (f in depth) return depth[f]
    if (f in open_path) {
        recursive[f] = 1
        return 0
    }
    open_path[f] = 1
    n = split(callees[f], list, " ")
    most = 0
    for (i = 1; i <= n; i++) {
        d = deepest(list[i])
        if (d > most) most = d
    }
    delete open_path[f]
    return depth[f] = bytes[f] + most
}
END {
    if (root != "") {
        if (!(root in bytes)) {
            print "stack.awk: no function " root > "/dev/stderr"
            exit 1
        }
        print deepest(root)
        exit
    }
    for (f in bytes) {
        deepest(f)
        count++
    }
    for (f in recursive) print f " recurses"
    for (f in dynamic) print f " sizes its stack at run time " dynamic[f]
    if (!count) print "no function found"
}
