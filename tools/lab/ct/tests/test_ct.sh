#!/bin/sh
# Tests the program `ct` as a person uses it. Scans of a wire in a short tube are segmented, checked against the truth,
# and made into a case that calibrate reads, from the scans alone. Errors in scans and cases are refused with file and
# remedy, and leave nothing half-written. An interrupt keeps what was finished. Prints TAP.
programs="ct calibrate"
. "$(dirname "$0")/../../../check/tool.sh"

# A tube of 7 mm radius along the head axis as an OBJ, a case with two depths in it, and its truth: a wire that leans
# on the wall.
python3 - "$work" <<'END'
import math, os, sys
work = sys.argv[1]
sides, radius, low, high = 32, 7.0, -28.0, 12.0
with open(work + "/tube.obj", "w", encoding="utf-8") as out:
    for y in (low, high):
        for i in range(sides):
            a = 2 * math.pi * i / sides
            out.write("v %.6f %.6f %.6f\n" % (radius * math.sin(a), y, radius * math.cos(a)))
        out.write("v 0 %g 0\n" % y)
    top = sides + 1
    for i in range(sides):
        j = (i + 1) % sides
        for t in ((i, j, top + i), (j, top + j, top + i), (j, i, sides), (top + i, top + j, top + sides)):
            out.write("f %d %d %d\n" % tuple(1 + v for v in t))


def wire(length):
    # The wire runs straight past the introducer at y = -22, then towards the wall.
    points, y = [(0.0, -22.0, 0.0)], -22.0
    arc = 0.0
    while arc < length - 1e-9:
        step = min(0.5, length - arc)
        bend = max(0.0, min(1.0, (arc - 4) / 16))
        angle = 0.35 * math.sin(math.pi * bend)
        x, y, z = points[-1]
        points.append((x + step * math.sin(angle), y + step * math.cos(angle), z))
        arc += step
    return points


for name in ("case/truth", "scans"):
    os.makedirs(work + "/" + name)
for i, length in enumerate((16, 24)):
    with open("%s/case/truth/depth_%d.csv" % (work, i + 1), "w", encoding="utf-8") as out:
        out.write("x_mm,y_mm,z_mm\n" + "".join("%.4f,%.4f,%.4f\n" % p for p in wire(length)))
END
write_case() { # write_case FOLDER KEYS writes a case with these lines in its first table
    {
        printf '# a person wrote this\nformat = 1\nname = "tube"\n'
        printf 'instrument = "%s/shared/examples/instruments/amplatz_super_stiff.toml"\n' "$PWD"
        printf 'friction_kinetic = 0.1\nfriction_static = 0.1\nspeed_mm_per_s = 20\n%b' "$2"
        for i in 1 2; do
            printf '[[depth]]\nname = "depth %d"\ninserted_mm = %d\nturn_deg = 0\n' $i $((8 + 8 * i))
            printf 'scan = "scan_%d.nrrd"\ncentreline = "depth_%d.csv"\n' $i $i
        done
    } >"$1/case.toml"
}
write_case "$work/case" 'scene = "none.scene"\nsurface = "../tube.obj"\nmouth_mm = [0, -22, 0]\ndirection = [0, 1, 0]\n'
"$tool" simulate "$work/case" --views 160 >"$work/said" 2>&1 && [ -s "$work/case/scan_1.nrrd" ] &&
    [ -s "$work/case/scan_2.nrrd" ]
report "two depths are scanned" $?
"$tool" segment "$work/case" >"$work/said" 2>&1 && "$tool" check "$work/case" >>"$work/said" 2>&1 &&
    [ "$(grep -c ': good' "$work/said")" = 6 ]
report "segmented within the bars, lines and lumen, both ways" $?
pages=$(find "$work/case/segmentation" -name index.html | wc -l)
pictures=$(find "$work/case/segmentation" -name '*.png' -size +1k | wc -l)
[ "$pages" = 3 ] && [ "$pictures" -ge 10 ] && grep -q 'href="depth_2/index.html"' "$work/case/segmentation/index.html"
report "a page for the case and for every depth, with pictures" $?

# From the scans alone, lumen, scene and mouth_mm are found, and calibrate inserts an instrument there.
cp "$work"/case/scan_?.nrrd "$work/scans"
write_case "$work/scans" ''
cp "$work/scans/case.toml" "$work/alone.toml"
"$tool" segment "$work/scans" >"$work/said" 2>&1 && [ -s "$work/scans/segmentation/lumen.scene" ]
report "a case of scans alone is segmented, and its lumen baked" $?
sed -n 's/^mouth_mm = \[\(.*\)\]/\1/p' "$work/scans/case.toml" |
    awk -F, '{ exit !(($1 ^ 2 + ($2 + 22) ^ 2 + $3 ^ 2) < 1) }'
report "the mouth is found within a millimetre" $?
grep -q "a person wrote this" "$work/scans/case.toml"
report "the rest of case.toml is as it was" $?
"$BUILD/bin/calibrate" "$work/scans" --evaluate alpha=0.05 -o "$work/fit" >"$work/said" 2>&1 &&
    [ -s "$work/fit/depth_2.csv" ]
report "calibrate inserts the instrument into the segmented lumen" $?

# An error is named with its remedy, and the case is not changed by it.
head_of() { # head_of FILE FROM TO replaces FROM by TO in a volume's text head
    python3 -c 'import sys
data = open(sys.argv[1], "rb").read()
assert sys.argv[2].encode() in data[:1000], data[:600]
open(sys.argv[1], "wb").write(data.replace(sys.argv[2].encode(), sys.argv[3].encode(), 1))' "$@"
}
spoiled() { # spoiled NAME WORDS: segmenting the folder `bad` ends with 1 and these words, and leaves its case unchanged
    refuses "$1" 1 "$2" segment "$work/bad"
    cmp -s "$work/before.toml" "$work/bad/case.toml" && ! find "$work/bad" -name '*.scene' -o -name '*.part*' |
        grep -q .
    report "$1, and its case stays as it was" $?
}
fresh() { # makes the folder `bad`: the case of scans alone, for the test to spoil
    rm -rf "$work/bad"
    mkdir "$work/bad"
    cp "$work/alone.toml" "$work/bad/case.toml"
    cp "$work"/case/scan_?.nrrd "$work/bad"
    cp "$work/bad/case.toml" "$work/before.toml"
}
spacing='(0.53000000000000003,0,0) (0,0.53000000000000003,0) (0,0,1)'
fresh
sed -i 's/inserted_mm = 24/inserted_mm = 33/' "$work/bad/case.toml"
cp "$work/bad/case.toml" "$work/before.toml"
spoiled "depths that contradict each other are refused" "inserted_mm.*mend it"
fresh
sed -i 's/inserted_mm = 24/inserted_mm = 147/' "$work/bad/case.toml"
cp "$work/bad/case.toml" "$work/before.toml"
spoiled "a scan that does not show the mouth is refused" "write mouth_mm and direction"
fresh
head_of "$work/bad/scan_2.nrrd" "$spacing" '(0.53,0,0) (0,0.53,0) (0,0,1.6)'
spoiled "a spacing that is not the case's is refused" "spacing"
fresh
head_of "$work/bad/scan_1.nrrd" "$spacing" '(0.00053,0,0) (0,0.00053,0) (0,0,0.001)'
spoiled "a spacing in metres is refused" "scan_1.nrrd: spacing 0.00053 x 0.00053 x 0.001 mm cannot be"
fresh
head_of "$work/bad/scan_1.nrrd" "$spacing" '(0,0,0) (0,0.53,0) (0,0,1)'
spoiled "a spacing of zero is refused" "scan_1.nrrd:8: .*spacings above 0"
fresh
head_of "$work/bad/scan_2.nrrd" "$spacing" '(0.53,0,0) (0,0.53,0) (0,0,-1)'
spoiled "mirrored axes are refused" "mirrored"
fresh
python3 -c 'import os, sys; os.truncate(sys.argv[1], os.path.getsize(sys.argv[1]) - 20000)' "$work/bad/scan_1.nrrd"
spoiled "a cut file is refused" "scan_1.nrrd: .*truncated"
fresh
rm "$work/bad/scan_2.nrrd"
spoiled "a missing scan is named" "scan_2.nrrd: is not there"

printf 'x_mm,y_mm,z_mm\n-4,-60,0\n-4,60,0\n' >"$work/left.csv"
printf 'x_mm,y_mm,z_mm\n4,-60,0\n4,60,0\n' >"$work/right.csv"
scan() { "$tool" scan "$work/tube.obj" "$@" --views 120 --slice-mm 2 --box -11 -12 -11 11 14 11 >"$work/said" 2>&1; }
scan -o "$work/none.nrrd" && scan "$work/left.csv" "$work/right.csv" -o "$work/two.nrrd" &&
    scan "$work/left.csv" -o "$work/series"
report "scans of nothing, of two wires, and a DICOM series" $?
refuses "a scan without an instrument is refused" 1 "none.nrrd: no instrument in the scan" segment "$work/none.nrrd" \
    -o "$work/out"
refuses "two instruments are refused" 1 "two.nrrd: two instruments.*--seed" segment "$work/two.nrrd" -o "$work/out"
[ ! -e "$work/out/centreline.csv" ] && [ ! -e "$work/out/index.html" ]
report "neither leaves a centreline" $?
"$tool" segment "$work/series" -o "$work/out" >"$work/said" 2>&1 && [ -s "$work/out/lumen.ply" ]
report "a DICOM series is segmented" $?
slice=$(find "$work/series" -name '*.dcm' | sort | sed -n 5p)
cp "$slice" "$work/kept.dcm"
python3 -c 'import os, sys; os.truncate(sys.argv[1], os.path.getsize(sys.argv[1]) // 2)' "$slice"
refuses "a cut slice is refused" 1 "truncated" segment "$work/series" -o "$work/out2"
rm "$slice"
refuses "a missing slice is refused" 1 "series: .*images" segment "$work/series" -o "$work/out2"
refuses "one slice of a series is refused" 1 "give the folder" segment "$work/kept.dcm" -o "$work/out2"
[ ! -e "$work/out2/centreline.csv" ]
report "neither leaves a centreline either" $?

# An interrupt keeps the finished files, and a final name never belongs to half a file.
interrupted() { # interrupted FILE COMMAND... interrupts the command as soon as FILE exists
    wanted=$1
    shift
    "$tool" "$@" >"$work/said" 2>&1 &
    process=$!
    while [ ! -e "$wanted" ]; do
        kill -0 $process 2>/dev/null || return 1
        sleep 0.02
    done
    kill -INT $process
    wait $process
    [ $? = 1 ] && grep -q "interrupted" "$work/said"
}
rm -rf "$work/case"/scan_* "$work/case"/depth_* "$work/case/segmentation"
interrupted "$work/case/scan_1.nrrd" simulate "$work/case" --views 160 && [ ! -e "$work/case/scan_2.nrrd" ]
report "an interrupted simulation keeps the finished scan" $?
"$tool" simulate "$work/case" --views 160 >"$work/said" 2>&1 &&
    interrupted "$work/case/depth_1.csv" segment "$work/case" && [ ! -e "$work/case/depth_2.csv" ] &&
    ! find "$work/case" -name '*.part*' | grep -q .
report "an interrupted segmentation keeps the finished depth" $?

refuses "a folder that is no case is named" 1 "nowhere" segment "$work/nowhere"
refuses "a case without a mouth cannot be checked" 1 "let ct segment find it" check "$work/bad"
refuses "no sub-command is a usage error" 2 "subcommand"
refuses "an unknown option is a usage error" 2 "--nothing" segment x --nothing
for command in simulate segment check scan; do
    refuses "help of $command" 0 "docs/ct.md" $command --help
done
refuses "help shows examples" 0 "ct segment out/case && ct check" --help

echo "1..$number"
exit $failed
