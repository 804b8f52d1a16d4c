# Straight-line code for llvm-mca from a disassembly (objdump -d --no-show-raw-insn), the first file, and the addresses of instructions in the
# order they are executed, the second. IT, which the cores fold, is left out; conditional instructions count as executed.
FNR == NR {
    if ($0 !~ /^ *[0-9a-f]+:\t/ || $2 ~ /^\.(word|short|byte)$/) next
    at = $1; sub(/:$/, "", at)
    split($0, part, "\t")
    m = part[2]; sub(/\.[nw]$/, "", m)
    rest = part[3]; sub(/[ \t]*[@;].*$/, "", rest)
    if (m ~ /^it[te]*$/) { cond = length(m) - 1; next }
    if (cond && cond--) sub(/..$/, "", m)
    if (m ~ /^(b|bl|cbz|cbnz|b(eq|ne|cs|cc|mi|pl|hi|ls|ge|lt|gt|le|hs|lo))$/) sub(/[0-9a-f]+ <.*/, "loop", rest)
    text[at] = "\t" m "\t" rest
    next
}
FNR == 1 { print "\t.syntax unified\nloop:" }
$1 in text { print text[$1] }
