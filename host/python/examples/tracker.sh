#!/usr/bin/env bash
# Trains the tracker of tips on 5,000 pictures, and judges it on pictures of other anatomies, instruments and doses
# (docs/tracker.md). What exists already is not made again.
# usage: tracker.sh [FOLDER]     results: FOLDER/curve.tsv, errors.tsv, doses.tsv, contrast.tsv, *.png (out/tracker)
# BUILD names the build folder; FRAMES the number of pictures to learn from (5000); TRACKER_WORDS has more words for
# all commands, such as --bfloat16.
set -euo pipefail
cd "$(dirname "$0")/../../.."
build=${BUILD:-build} out=${1:-out/tracker} frames=${FRAMES:-5000} words=${TRACKER_WORDS:-}
cournand=$(python3 host/python/tests/prepare.py)
make_in() { PYTHONPATH=$build/python/site "$cournand" -m "$@"; }
# shellcheck disable=SC2086
tracker() { PYTHONPATH=host/python/examples /usr/bin/python3 -m tip_tracker "$@" --keep "$out/kept" $words; }

# Anatomies and instruments to learn from, to choose the training with (`valid`), and to judge with (`rare`). No drawn
# anatomy and no instrument is in two of these lists.
scenes=aorta
for seed in 1 2 3 4 5 6 7 8; do scenes+=,$out/scenes/aorta-$seed-bodies.scene; done
valid_scenes=$out/scenes/aorta-201-bodies.scene,$out/scenes/aorta-202-bodies.scene
rare_scenes=$out/scenes/aorta-301-bodies.scene,$out/scenes/aorta-302-bodies.scene
tools=j_wire,rosen,bentson,coronary_014,beacon_5f,pigtail_5f,terumo_4f,guide_jr4_6f,j_wire+beacon_5f
tools+=,bentson+pigtail_5f,coronary_014+guide_jr4_6f,rosen+balloon_6x20,rosen+balloon_6x20@renal_6_0x18
tools+=,coronary_014+balloon_3x20+guide_jl4_6f
valid_tools=amplatz_super_stiff,cook_straight,guide_jl3_6f,cook_straight+guide_ntr_6f
rare_tools=terumo_stiff_angled,simmons_2_5f,terumo_stiff_angled+terumo_5f
dose="20 160" low_dose="10 20" high_dose="160 320" # nGy at the detector

# scenes_of(first, count) makes anatomies with bones and organs.
scenes_of() {
    make_in cournand.anatomies --bodies --first "$1" --count "$2" --out "$out/scenes" --programs "$build/bin"
}
scenes_of 1 8
scenes_of 201 2
scenes_of 301 2

# data(name, frames, seed, scenes, tools, dose) makes a data set, five pictures of each course, each with its own view.
# Sets with the same seed, scenes and tools have the same courses, and differ in the dose alone.
data() {
    # shellcheck disable=SC2086
    make_in cournand.factory --frames "$2" --seed "$3" --scenes "$4" --tools "$5" --dose $6 \
        --shard-frames 5 --block-frames 1 --out "$out/data/$1" --quiet
}
data train "$frames" 1 "$scenes" "$tools" "$dose"
data valid 500 21 "$valid_scenes" "$valid_tools" "$high_dose"
data valid_noisy 500 21 "$valid_scenes" "$valid_tools" "$low_dose"
data held_out 600 31 "$rare_scenes" "$rare_tools" "$high_dose"
data held_out_noisy 600 31 "$rare_scenes" "$rare_tools" "$low_dose"
data same 300 32 "$scenes" "$tools" "$dose"
data anatomy 300 33 "$rare_scenes" "$tools" "$dose"
data instrument 300 34 "$scenes" "$rare_tools" "$dose"
data noise 300 35 "$scenes" "$tools" "$low_dose"
doses=()
for one in 5 10 20 40 80 160; do
    data "dose_$one" 300 31 "$rare_scenes" "$rare_tools" "$one $one"
    doses+=("$one=$out/data/dose_$one")
done

# The second part of the training goes on with whole pictures at a lower rate.
[ -e "$out/first/tracker.pt" ] || tracker train "$out/data/train" --out "$out/first"
[ -e "$out/tracker.pt" ] || tracker train "$out/data/train" --out "$out" --from "$out/first" \
    --crop-epochs 0 --whole-epochs 2 --rate 0.001
sets=()
for name in held_out held_out_noisy valid valid_noisy same anatomy instrument noise; do
    sets+=("$name=$out/data/$name")
done
tracker judge "$out" "${sets[@]}" --out "$out"
tracker judge "$out" "${sets[@]:0:2}" --out "$out/turned" --turned
tracker doses "$out" "${doses[@]}" --out "$out"
