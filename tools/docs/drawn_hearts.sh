#!/usr/bin/env bash
# Draws the coronary arteries of several seeds, from the front (above) and from behind (below): drawn_hearts.sh OUT.png
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
seeds=(0 6 13 12)
turns=(20 200)
pictures=()
for seed in "${seeds[@]}"; do
    build/bin/anatomy heart --seed "$seed" --heart-only --quiet -o "$folder/$seed" >"$folder/said"
    for turn in "${turns[@]}"; do
        build/bin/centreline show --wireframe --mesh "$folder/$seed/beat/frame_00.obj" --part coronaries_left \
            --part coronaries_right --turn "$turn" --size 500 -o "$folder/$seed-$turn.png" >"$folder/said"
    done
done
for turn in "${turns[@]}"; do
    for seed in "${seeds[@]}"; do pictures+=(-i "$folder/$seed-$turn.png"); done
done
ffmpeg -v error -y "${pictures[@]}" -filter_complex \
    "[0][1][2][3]hstack=4[above];[4][5][6][7]hstack=4[below];[above][below]vstack,format=gray" "$1"
