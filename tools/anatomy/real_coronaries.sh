#!/bin/sh
# Makes centrelines of the Human Reference Atlas' coronary arteries for shared/examples/real_coronaries.toml
# (make coronary-real). They are fitted into the atlas' meshes and named after their side. They are also widened,
# because the atlas draws its arteries too thin for a lumen.
#   real_coronaries.sh CENTRELINE ATLAS.glb FOLDER      writes FOLDER/real_left.csv and FOLDER/real_right.csv
set -eu
if [ $# -ne 3 ]; then
    echo "usage: $0 CENTRELINE ATLAS.glb FOLDER" >&2
    exit 2
fi
program=$1 atlas=$2 folder=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# artery SIDE WIDENING INLET(x y z, mm) PARTS...
artery()
{
    side=$1 widening=$2 x=$3 y=$4 z=$5
    shift 5
    for part; do set -- "$@" --part "VH_M_$part"; shift; done
    echo "Making $folder/real_$side.csv"
    "$program" auto "$atlas" --unit m "$@" --inlet "$x" "$y" "$z" --shortest-mm 8 -o "$work/thin.csv" \
        > "$work/log" 2>&1 ||
        { cat "$work/log" >&2; exit 1; }
    "$program" convert "$work/thin.csv" --as-is --radii-times "$widening" -o "$work/wide.csv" > "$work/log" 2>&1 ||
        { cat "$work/log" >&2; exit 1; }
    sed -E "s/^([0-9]+),/\\1,${side}_/" "$work/wide.csv" > "$work/named.csv"
    mv "$work/named.csv" "$folder/real_$side.csv"
}

artery left 2.8 14.5 506.9 23.4 left_coronary_artery left_anterior_descending_artery 'diagonal_*' left_marginal_branch
artery right 2.4 0.2 500.9 40.3 right_coronary_artery right_marginal_artery right_posterior_descending_artery
