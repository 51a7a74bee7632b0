#!/bin/sh
# Tests the heart that beats. An independent script measures its figures on the files, and `anatomy check` is tested on
# good and bad folders. Bodies are coarser than usual (--body-scale 2) and have no skeleton, to save time.
programs=anatomy
. "$(dirname "$0")/../../check/tool.sh"

is_bad() { # is_bad NAME WORDS: checking $work/bad ends with 1 and prints the words
    refuses "$1" 1 "$2" check "$work/bad"
    rm -rf "$work/bad"
}

bad() { cp -r "$work/small" "$work/bad"; }

"$tool" heart -o "$work/heart" --heart-only --body-scale 2 --quiet >"$work/said" 2>&1
report "the heart is made" $?
python3 "$here/check_heart.py" "$work/heart" $((number + 1)) || failed=1
number=$((number + 10))

"$tool" check "$work/heart/beat" >"$work/said" 2>&1
report "its folder of frames is a beat" $?

"$tool" heart -o "$work/bare" --no-bodies --lumen-mm 1.2 --quiet >"$work/said" 2>&1 &&
    ! grep -q "^\[\[body" "$work/bare/scene.toml" && grep -q "^\[motion" "$work/bare/scene.toml" &&
    [ "$(ls "$work/bare/lumen_beat" | wc -l)" -ge 24 ] && [ ! -e "$work/bare/skin.ply" ]
report "without bodies its scene is the moving lumen alone" $?
refuses "a lesion of an unknown branch is refused" 2 "NOPE" heart -o "$work/none" --no-bodies --lesion NOPE:75:14:22
[ ! -e "$work/none" ]
report "nothing is written then" $?

# The borrowed beat for another heart.
places=$(python3 "$here/check_beat.py" make "$work/heart" "$work/other.obj" "$tool")
# shellcheck disable=SC2086 # words on purpose
"$tool" beat "$work/other.obj" $places -o "$work/borrowed" >"$work/said" 2>&1 &&
    grep -q "1.20 times as large" "$work/said" && [ -s "$work/borrowed_inhaled.ply" ] &&
    python3 "$here/check_beat.py" compare "$work/heart" "$work/borrowed" >>"$work/said" 2>&1
report "another heart, larger and turned, borrows the same beat" $?
refuses "places on one line are refused" 2 "one line" beat "$work/other.obj" --left 0 0 0 --right 10 0 0 \
    --apex 90 0 0 -o "$work/no"
refuses "a heart in the wrong unit is refused with its size" 2 "0.10 times as large" beat "$work/other.obj" \
    --left 2 15 1 --right 0 13 3.5 --apex 7.8 6.9 4.8 -o "$work/no"
refuses "a place of another heart is refused by name" 2 "mm off where a heart like the shipped one has it" beat \
    "$work/other.obj" --left 20 150 14 --right 90 150 14 --apex 78 69 48 -o "$work/no"

# A tetrahedron that grows and shrinks, and two objects, one of which has a face of four corners.
mkdir "$work/small"
awk -v folder="$work/small" \
    'BEGIN { for (i = 0; i < 24; i++) { name = sprintf("%s/f_%02d.obj", folder, i); h = 10 + sin(i * 3.14159265 / 12)
    printf "o one\nv 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 %.4f\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n", h > name
    printf "o two\nv 0 0 20\nv 5 0 20\nv 5 5 20\nv 0 5 %.4f\nf -4//1 -3//1 -2//1 -1//1\n", 10 + h > name
    close(name) } }'
"$tool" check "$work/small" >"$work/said" 2>&1 && grep -q "^one  *4 vertices  *4 triangles" "$work/said" &&
    grep -q "^two  *4 vertices  *2 triangles" "$work/said"
report "objects, negative corners and faces of four corners are read" $?
bad; rm "$work/bad/f_07.obj"
is_bad "a missing frame is named by the count" "holds 23 .obj files"
bad; sed -i 's/^f 1 2 4/f 1 4 2/' "$work/bad/f_09.obj"
is_bad "a frame with other faces is named" "f_09.obj: one, triangle 1 has other corners"
bad; sed -i 's/^o two/o three/' "$work/bad/f_11.obj"
is_bad "a frame with other bodies is named" "f_11.obj: has another body (three, not two)"
bad; sed -i '5s/.*/v 0 0 -5/' "$work/bad/f_13.obj"
is_bad "inverted faces are named with their frame" "one .*turned in frame 13"
bad; for i in $(seq 0 23); do sed -i "5s/.*/v 0 0 $((10 + i))/" "$work/bad/f_$(printf %02d "$i").obj"; done
is_bad "a jump from the last frame to the first is found" "one .*from the last frame to the first"
bad; sed -i '3s/.*/v 10 nan 0/' "$work/bad/f_03.obj"
is_bad "a number that is none is named with file and line" "f_03.obj:3: a vertex needs three finite numbers"
bad; sed -i '6s/.*/f 1 99 2/' "$work/bad/f_02.obj"
is_bad "a corner without a vertex is named with file and line" "f_02.obj:6: '99' names no vertex"
mkdir "$work/bad"
is_bad "an empty folder holds no beat" "holds 0 .obj files"
is_bad "a folder that is not there is named" "no such folder"

echo "1..$number"
exit $failed
