#!/usr/bin/env bash
# Trains the tracker of tips on 5,000 pictures, and judges it on pictures of other anatomies, instruments and doses
# (docs/tracker.md). What exists already is not made again.
# usage: tracker.sh [FOLDER]     results: FOLDER/curve.tsv, errors.tsv, *.png (out/tracker)
# BUILD names the build folder; FRAMES the number of pictures to learn from (5000); TRACKER_WORDS has more words for
# `train`.
set -euo pipefail
cd "$(dirname "$0")/../../.."
build=${BUILD:-build} out=${1:-out/tracker} frames=${FRAMES:-5000}
cournand=$(python3 host/python/tests/prepare.py)
make_in() { PYTHONPATH=$build/python/site "$cournand" -m "$@"; }
tracker() { PYTHONPATH=host/python/examples /usr/bin/python3 -m tip_tracker "$@"; }

# Anatomies, instruments and doses to learn from, and others to judge with (`rare`). No instrument is in both lists.
scenes=aorta rare_scenes=
for seed in 1 2 3 4; do scenes+=,$out/scenes/aorta-$seed-bodies.scene; done
for seed in 101 102; do rare_scenes+=${rare_scenes:+,}$out/scenes/aorta-$seed-bodies.scene; done
tools=j_wire,rosen,coronary_014,beacon_5f,pigtail_5f,terumo_4f,j_wire+beacon_5f,bentson+pigtail_5f
tools+=,coronary_014+guide_jr4_6f,rosen+balloon_6x20,rosen+balloon_6x20@renal_6_0x18
tools+=,coronary_014+balloon_3x20+guide_jl4_6f
rare_tools=terumo_stiff_angled,simmons_2_5f,terumo_stiff_angled+terumo_5f
dose="20 160" low_dose="10 20" high_dose="160 320" # nGy at the detector

make_in cournand.anatomies --bodies --first 1 --count 4 --out "$out/scenes" --programs "$build/bin"
make_in cournand.anatomies --bodies --first 101 --count 2 --out "$out/scenes" --programs "$build/bin"

# data(name, frames, seed, scenes, tools, dose) makes a data set, 20 pictures of each course, 4 of each view.
data() {
    # shellcheck disable=SC2086
    make_in cournand.factory --frames "$2" --seed "$3" --scenes "$4" --tools "$5" --dose $6 \
        --shard-frames 20 --block-frames 4 --out "$out/data/$1" --quiet
}
data train "$frames" 1 "$scenes" "$tools" "$dose"
data held_out 600 7 "$rare_scenes" "$rare_tools" "$high_dose"
data held_out_noisy 600 2 "$rare_scenes" "$rare_tools" "$low_dose"
data same 300 3 "$scenes" "$tools" "$dose"
data anatomy 300 4 "$rare_scenes" "$tools" "$dose"
data instrument 300 5 "$scenes" "$rare_tools" "$dose"
data noise 300 6 "$scenes" "$tools" "$low_dose"

# shellcheck disable=SC2086
[ -e "$out/tracker.pt" ] || tracker train "$out/data/train" --out "$out" --keep "$out/kept" ${TRACKER_WORDS:-}
words=()
for name in held_out held_out_noisy same anatomy instrument noise; do words+=("$name=$out/data/$name"); done
tracker judge "$out" "${words[@]}" --out "$out" --keep "$out/kept"
