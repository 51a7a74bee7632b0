#!/bin/sh
# Makes figure 5.10 of the thesis from a recording of an angioplasty (docs/thesis.md). Above it shows the balloon under
# fluoroscopy: positioned, inflated, deflated and released. Below it shows the polygons round the lesion at the same
# moments, from stenosed to healthier. FIGURE.obj receives these polygons too.
# usage: [CROP=WIDTH:HEIGHT:X:Y] figure_5_10.sh RECORDING FIGURE.png [BUILD]
set -eu
recording=$1 figure=$2 bin=${3:-build}/bin
base=${figure%.png}
crop=${CROP:-480:480:190:170} # of pictures of 1024: the place of the lesion of pci_lad.session
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$bin/cournand" surface "$recording" --stages --around 10 -o "$base.obj" --png "$work/walls.png" >"$work/stages"
positioned=$(awk '$1 == "positioned" {print $2}' "$work/stages")
inflated=$(awk '$1 == "inflated" {print $2}' "$work/stages")
released=$(awk '$1 == "released" {print $2}' "$work/stages")

# The film of a replay begins where the replay does; here that is before the first moment.
begin=$(awk -v a="$positioned" 'BEGIN { printf "%.3f", (a > 1) ? a - 1 : 0 }')
"$bin/cournand" replay "$recording" --from "$begin" --size 1024 --mp4 "$work/film.mp4" >"$work/said"
number=0
for moment in "$positioned" "$inflated" "$released"; do
    number=$((number + 1))
    after=$(awk -v a="$moment" -v b="$begin" 'BEGIN { printf "%.3f", a - b }')
    ffmpeg -v error -y -ss "$after" -i "$work/film.mp4" -frames:v 1 -vf "crop=$crop,scale=480:480" \
        "$work/xray$number.png"
done
ffmpeg -v error -y -i "$work/xray1.png" -i "$work/xray2.png" -i "$work/xray3.png" -i "$work/walls.png" \
    -filter_complex "[0][1][2]hstack=3[a];[a][3]vstack" "$figure"
echo "Written: $figure $base.obj"
