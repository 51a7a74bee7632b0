#!/usr/bin/env bash
# Trains and judges the deep baselines of the named tasks (docs/tasks.md, "The deep baseline"). What exists already is
# not made again. The bits of a training depend on the processor, because PyTorch chooses its routines by it.
# usage: deep_baseline.sh [FOLDER]     results: FOLDER/TASK_SEED.npz, .tsv, .json, and curves.png (out/deep)
# BUILD names the build folder; TASKS the tasks (all).
set -euo pipefail
cd "$(dirname "$0")/../../.."
build=${BUILD:-build} out=${1:-out/deep} scenes=$out/anatomies
tasks=${TASKS:-iliac subclavian brachiocephalic left_carotid shipped_arch coronary arch_variety two_devices}
python3 host/python/tests/prepare.py >/dev/null
python=$(PYTHONPATH=host/python/tests /usr/bin/python3 -c 'import prepare; print(prepare.deep())')
export PYTHONPATH=$build/python/site:host/python/examples OMP_NUM_THREADS=1
mkdir -p "$out"

# The words with which each task learns. Two tasks go on with the network of another task, which is therefore trained
# before them.
words() {
    case $1 in
    iliac) echo "--steps 40000" ;;
    subclavian) echo "--steps 20000 --push 0.6" ;;
    shipped_arch) echo "--steps 25000 --demonstrations 30" ;;
    brachiocephalic) echo "--steps 40000 --demonstrations 30" ;;
    left_carotid) echo "--steps 20000 --from $out/brachiocephalic_1.npz" ;;
    coronary) echo "--steps 8000 --demonstrations 24 --worlds 8" ;;
    arch_variety) echo "--steps 8000 --scenes 3 --from $out/shipped_arch_1.npz" ;;
    two_devices) echo "--steps 15000 --push 0.6" ;;
    esac
}
episodes() {
    case $1 in
    iliac | subclavian | shipped_arch | coronary) echo 20 ;;
    *) echo 10 ;;
    esac
}

for task in $tasks; do
    for split in train judge; do
        count=$(episodes "$task")
        [ $split = judge ] || count=3
        [ "$task" = shipped_arch ] || "$python" -m cournand.anatomies --task "$task" --split $split \
            --episodes "$count" --out "$scenes" --programs "$build/bin"
    done
    seeds=1
    [ "$task" != iliac ] || seeds="1 2 3"
    for seed in $seeds; do
        name=$out/${task}_$seed
        # shellcheck disable=SC2046
        [ -e "$name.npz" ] || "$python" -m deep_baseline train "$task" --seed "$seed" $(words "$task") \
            --anatomies "$scenes" --out "$name.npz"
        [ -e "$name.json" ] || "$python" -m cournand.judge "$task" --policy "$name.npz" --threads 1 \
            --episodes "$(episodes "$task")" --anatomies "$scenes" --json "$name.json"
    done
done
"$python" -m deep_baseline curves "$out"/*_[0-9].tsv --out "$out/curves.png"
