#!/usr/bin/env bash
# Tests what a session leaves on the disk. There is one DICOM file per press of the pedal, in which dciodvfy
# finds no error; a replay gives the same bytes; pictures have 16 bits. No half-written file stays after
# Ctrl-C or on a full disk. It prints TAP.
set -u
. "$(dirname "$0")/program.sh"
wire="$root/shared/examples/instruments/bentson.toml"
log="$work/said"
: >"$log"
cd "$work" || exit 1

cat >pedal.session <<'END'
begin inserted 20 mm
fluoro on
advance 20 mm at 100 mm/s
fluoro off
wait 200 ms
c-arm LAO 40 CAU 30
fluoro on
wait 600 ms
fluoro off
wait 100 ms
END
session() { "$program" run --tool "$wire" --session pedal.session --size 64 --quiet "$@"; }

session --record a.rec --dicom a --png16 a16.png --png a8.png >said 2>&1
[ $? = 0 ] && [ "$(ls a)" = $'run_01_fluoro.dcm\nrun_02_fluoro.dcm' ] && grep -q "written *a/run_02_fluoro.dcm" said
result $? "every press of the pedal is one file, and the program names it"

"$program" dicom-check a >said 2>&1
[ $? = 0 ] && grep -q "a/run_01_fluoro.dcm: XAImage, 0 errors" said && grep -q "^2 files: 0 errors" said
result $? "dicom-check finds no error in them and ends with 0"

"$program" replay a.rec --dicom b --size 64 >said 2>&1 && diff -r a b >>said
result $? "the replay of its recording gives the same bytes"

"$program" replay a.rec --dicom named --size 64 --dicom-values linear --patient-name 'Phantom^Aorta' --patient-id P1 \
    --study-date 20260131 >said 2>&1 && "$program" dicom-check named >>said 2>&1 &&
    grep -q 'Phantom^Aorta' named/run_01_fluoro.dcm
result $? "with a patient's name, number and date, and linear values, there is no error either"

# Compares the values of a 16-bit PNG, read by its specification (filters of section 9), with those of the
# last frame in the DICOM file.
python3 - >said 2>&1 <<'END'
import struct, zlib
def chunks(data):
    at = 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        yield kind, data[at + 8 : at + 8 + length]
        at += 12 + length
def paeth(a, b, c):
    return min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
def rows(name, step):
    parts = list(chunks(open(name, "rb").read()))
    width, height = struct.unpack(">II", parts[0][1][:8])
    lines = zlib.decompress(b"".join(data for kind, data in parts if kind == b"IDAT"))
    stride, above = width * step, bytes(width * step)
    for y in range(height):
        kind, line = lines[y * (stride + 1)], bytearray(lines[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        for i in range(stride):
            left, corner = (line[i - step], above[i - step]) if i >= step else (0, 0)
            line[i] = (line[i] + (0, left, above[i], (left + above[i]) // 2, paeth(left, above[i], corner))[kind]) & 255
        above = bytes(line)
        yield above
head = open("a16.png", "rb").read(33)
assert struct.unpack(">IIBB", head[16:26]) == (64, 64, 16, 0), head
assert struct.unpack(">IIBB", open("a8.png", "rb").read(33)[16:26]) == (64, 64, 8, 2)
values = struct.unpack(">4096H", b"".join(rows("a16.png", 2)))
assert values == struct.unpack("<4096H", open("named/run_02_fluoro.dcm", "rb").read()[-8192:])
assert max(values) > 500, max(values)
END
result $? "--png16 holds the values of the last frame, 16 bits of grey; --png is 8 bits of colour"

cat >acquire.session <<'END'
cine on
wait 500 ms
cine off
dsa on
wait 2 s
dsa off
mask frames 1 to 2
shift mask right 1 px up 0.5 px
END
"$program" run --tool "$wire" --session acquire.session --size 64 --quiet --dicom acquired >said 2>&1 &&
    [ "$(ls acquired)" = $'run_01_cine.dcm\nrun_02_dsa.dcm' ] && "$program" dicom-check acquired >>said 2>&1
result $? "cine and DSA are files without an error, named by their kind"

# Mask Frame Numbers are 1 and 2; Sub-pixel Shift is half a row up and one column to the right (down and left
# are positive).
python3 - >said 2>&1 <<'END'
import struct
data = open("acquired/run_02_dsa.dcm", "rb").read()
assert b"\x28\x00\x10\x61US\x04\x00" + struct.pack("<2H", 1, 2) in data
assert b"\x28\x00\x14\x61FL\x08\x00" + struct.pack("<2f", -0.5, -1.0) in data
assert b"\x28\x00\x90\x10CS\x04\x00SUB " in data
END
result $? "the mask and its shift are those chosen while the run was looked at"

head -c 5000 a/run_01_fluoro.dcm >cut.dcm
"$program" dicom-check --warnings cut.dcm a/run_02_fluoro.dcm >said 2>&1
[ $? = 1 ] && grep -q "Error - Dicom dataset read failed" said && grep -q "Warning - " said &&
    grep -q "run_02_fluoro.dcm: XAImage, 0 errors" said
result $? "dicom-check ends with 1 for a damaged file, says why, and goes on to the next"

echo "no image" >text.dcm
"$program" dicom-check text.dcm >said 2>&1
[ $? = 1 ] && grep -q "text.dcm: not recognised, [1-9]" said
result $? "dicom-check ends with 1 for what is no DICOM file"

mkdir bin && ln -s "$(command -v env)" bin/env
PATH="$work/bin" "$program" dicom-check a >said 2>&1
[ $? = 1 ] && grep -q "dciodvfy was not found; install it (Debian: apt-get install dicom3tools)" said
result $? "dicom-check names the package of the program that is missing"

sed '/fluoro/d' pedal.session >dark.session
"$program" run --tool "$wire" --session dark.session --size 64 --quiet --dicom dark >said 2>&1
[ $? = 0 ] && grep -q "no file, because the pedal was never down" said && [ ! -e dark ]
result $? "without a press of the pedal it says so and leaves no folder"

(ulimit -f 16 && session --dicom full) >said 2>&1
[ $? = 1 ] && grep -q "full.*cannot be written: File too large; make room" said && [ ! -e full ]
result $? "a full disk is told, and nothing is left"

# A long session is stopped in the middle: one Ctrl-C ends it, two end the program.
{ echo "fluoro on"; for _ in $(seq 60); do echo "wait 10 s"; done; } >long.session
start_long() { # folder, further options: begins the session and waits until frames are on the disk
    "$program" run --tool "$wire" --session long.session --size 256 --dicom "$@" >said 2>&1 &
    long=$!
    for _ in $(seq 600); do
        [ -n "$(find "$1" -size +1000k 2>/dev/null)" ] && return
        kill -0 $long 2>/dev/null || return
        sleep 0.05
    done
}

start_long once --mp4 once.mp4
kill -INT $long
wait $long
[ $? = 1 ] && [ "$(ls once)" = run_01_fluoro.dcm ] && "$program" dicom-check once >>said 2>&1 &&
    [ -z "$(ffmpeg -v error -i once.mp4 -f null - 2>&1)" ]
result $? "Ctrl-C ends the session; what was seen until then is a whole file, and a whole film"

start_long twice
kill -INT $long
for _ in $(seq 20); do kill -INT $long 2>/dev/null; done
wait $long
code=$?
{ [ $code = 130 ] && [ -z "$(ls twice)" ]; } || { [ $code = 1 ] && [ "$(ls twice)" = run_01_fluoro.dcm ]; }
result $? "a second Ctrl-C ends the program and leaves no half file"

echo "1..$number"
exit $failed
