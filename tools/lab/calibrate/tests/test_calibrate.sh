#!/bin/sh
# Tests the program `calibrate` on a short insertion: the bits are the same for 1, 2 and 4 threads and for 1 to 4 ranks
# of MPI, also after it was killed at several moments; the simulator loads the fitted file; messages for bad input.
# Prints TAP.
programs="calibrate bake cournand"
. "$(dirname "$0")/../../../check/tool.sh"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1

# A bent tube of 8 mm diameter, and a case in it. Its scans are the insertion with numbers that differ from the file's.
python3 - "$work" <<'END'
import math, sys
folder = sys.argv[1]
with open(folder + "/tube.csv", "w", encoding="utf-8") as out:
    out.write("branch,name,parent,parent_sphere,sphere,x_mm,y_mm,z_mm,radius_mm,speed_mm_s,manual\n")
    for i in range(31):
        angle = i * 0.05
        out.write("0,tube,,,%d,%.3f,%.3f,0,4,0,0\n" % (i, 40 * math.sin(angle), 40 * (1 - math.cos(angle))))
END
printf '%s\n' '[scene]' 'name = "tube"' '[lumen]' 'centrelines = ["tube.csv"]' '[entry]' 'position_mm = [6, 0.5, 0]' \
    'direction = [0.98, 0.2, 0]' >"$work/scene.toml"
"$BUILD/bin/bake" "$work/scene.toml" -o "$work/tube.scene" --points 500 --poses 0 >"$work/said" 2>&1
report "the tube is baked" $?
make_case() { # make_case FOLDER
    mkdir -p "$1"
    {
        printf 'format = 1\nname = "tube"\ninstrument = "%s/shared/examples/instruments/bentson.toml"\n' "$PWD"
        printf 'scene = "%s/tube.scene"\nmouth_mm = [6, 0.5, 0]\ndirection = [0.979796, 0.2, 0]\n' "$work"
        printf 'friction_kinetic = 0.1\nfriction_static = 0.12\nspeed_mm_per_s = 100\n'
        for i in 1 2 3; do
            printf '[[depth]]\nname = "depth %d"\ninserted_mm = %d\nturn_deg = 0\ncentreline = "depth_%d.csv"\n' $i \
                $((i * 10 + 5)) $i
        done
    } >"$1/case.toml"
    for i in 1 2 3; do printf 'x_mm,y_mm,z_mm\n0,0,0\n1,0,0\n' >"$1/depth_$i.csv"; done
}
make_case "$work/case"
"$tool" "$work/case" --evaluate alpha=0.05 -o "$work/scan" >"$work/said" 2>&1 &&
    cp "$work"/scan/depth_?.csv "$work/case"
report "one insertion writes shapes that serve as a scan" $?

short="--population 8 --generations 4 --no-ranges --no-page --quiet"
fit() { # fit FOLDER ARGUMENTS...
    folder=$1
    shift
    # shellcheck disable=SC2086
    $launch "$tool" "$work/case" -o "$work/$folder" $short "$@" >"$work/said" 2>&1
}
launch=
fit one --threads 1
report "a search ends" $?
for threads in 2 4; do
    fit "threads_$threads" --threads $threads &&
        cmp "$work/one/result.json" "$work/threads_$threads/result.json" >>"$work/said" 2>&1
    report "the same bits from $threads threads" $?
done
for ranks in 1 2 3 4; do
    launch="mpirun -n $ranks"
    fit "ranks_$ranks" && cmp "$work/one/result.json" "$work/ranks_$ranks/result.json" >>"$work/said" 2>&1
    report "the same bits from $ranks ranks" $?
done
launch=
"$BUILD/bin/cournand" instruments "$work/one/instrument.toml" >"$work/said" 2>&1 && grep -q "fitted" "$work/said"
report "the simulator loads the fitted instrument" $?

# We kill the search as soon as it has completed this many generations, and prolong it later; the moment within the
# next generation is random.
killed() { # killed FOLDER GENERATIONS COMMAND... stops the command's last process group
    folder=$1 wanted=$2
    shift 2
    "$@" "$tool" "$work/case" -o "$work/$folder" --population 8 --generations 400 --no-ranges --no-page \
        --quiet >"$work/said" 2>&1 &
    process=$!
    while ! grep -q "^generation \($wanted\|[1-9][0-9]\)$" "$work/$folder/checkpoint_cmaes.txt" 2>/dev/null; do
        kill -0 $process 2>/dev/null || return 1
        sleep 0.02
    done
    victim=$process
    [ $# = 0 ] || victim=$(pgrep -P $process | tail -n 1) # a rank
    kill -KILL "$victim"
    wait $process 2>/dev/null
    [ $? != 0 ]
}
done_generations() { sed -n 's/^generation //p' "$work/$1/checkpoint_cmaes.txt"; }
for wanted in 1 3; do
    killed "killed_$wanted" $wanted
    made=$(done_generations "killed_$wanted")
    goal=$((made + 2))
    short="--population 8 --generations $goal --no-ranges --no-page --quiet"
    fit "killed_$wanted" --resume --threads 2 && fit "whole_$wanted" --threads 1 &&
        cmp "$work/killed_$wanted/result.json" "$work/whole_$wanted/result.json" >>"$work/said" 2>&1
    report "killed in generation $wanted or later, resumed: the same bits" $?
done
killed killed_rank 2 mpirun -n 3
report "an MPI job ends when a rank dies" $?
goal=$(($(done_generations killed_rank) + 1))
short="--population 8 --generations $goal --no-ranges --no-page --quiet"
launch="mpirun -n 2"
fit killed_rank --resume
launch=
fit whole_rank --threads 2 && cmp "$work/killed_rank/result.json" "$work/whole_rank/result.json" >>"$work/said" 2>&1
report "and the job that is started again gives the same bits" $?

short="--population 8 --generations 2 --no-ranges --quiet"
fit page --method genetic cmaes differential && [ -s "$work/page/shapes.png" ] && [ -s "$work/page/curves.png" ] &&
    grep -q "undetermined" "$work/page/index.html"
report "three methods are compared on a page, EI without a force trace undetermined" $?

fit corde --rod corde && grep -q '"rod": "corde"' "$work/corde/result.json" &&
    grep -q '"name": "kp"' "$work/corde/result.json" && [ ! -e "$work/corde/instrument.toml" ]
report "the thesis' rod is fitted by the same search, without an instrument file" $?
refuses "a checkpoint of the other rod is refused" 1 "other settings" "$work/case" -o "$work/corde" --resume --quiet
refuses "an unknown rod is a usage error" 2 "core,corde\|corde" "$work/case" -o "$work/x" --rod elastica

refuses "a folder without a case is named" 1 "case.toml\|no such file" "$work/nowhere" -o "$work/x"
refuses "an output folder is needed" 2 "--output" "$work/case"
refuses "an unknown method is a usage error" 2 "no method" "$work/case" -o "$work/x" --method simplex
refuses "an unknown parameter is a usage error that lists them" 2 "bend_shaft, alpha, radius, density" "$work/case" \
    --evaluate young=1
refuses "bounds without the file's value are refused" 1 "between them" "$work/case" -o "$work/x" --bounds alpha=0.5..0.6
refuses "a checkpoint of another seed is refused" 1 "other settings" "$work/case" -o "$work/one" --resume --seed 9 \
    --quiet
sed 's/^scene.*/scene = "none.scene"/' "$work/case/case.toml" >"$work/scan/case.toml"
refuses "a missing scene is named with its remedy" 1 "none.scene: no such scene" "$work/scan" -o "$work/x"
refuses "help shows examples" 0 "mpirun" --help

echo "1..$number"
exit $failed
