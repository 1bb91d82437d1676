#!/usr/bin/env bash
# Runs an experiment in shards with GNU parallel, on this machine or on several; then merges them, writes the report and gates.
#
#   scripts/parallel.sh SHARDS CONFIG [key=value …]      for example: scripts/parallel.sh 8 quickstart repeats=10
#
# The same command again runs what failed or was killed. What may be set (docs/cluster.md):
#   LIGHTBENCH         the program; default: lightbench
#   LIGHTBENCH_OUT     the results folder; default: results/<last part of CONFIG>
#   PARALLEL_OPTIONS   such as "--jobs 4", or "--sshloginfile nodes --workdir ." where nodes see the same folder
#   THREADS            processors of a shard; default: 2
set -euo pipefail

if [ $# -lt 2 ] || ! [[ $1 =~ ^[1-9][0-9]*$ ]]; then
    sed -n '2,10s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
shards=$1
config=$2
shift 2
program=${LIGHTBENCH:-lightbench}
threads=${THREADS:-2}
name=$(basename "$config" .toml)
out=${LIGHTBENCH_OUT:-results/$name}
parts=$out.shards
read -r -a options <<<"${PARALLEL_OPTIONS:-}"

# Everything is wrong now or not at all: a plan casts no ray.
"$program" plan "$config" "$@" >/dev/null

# All shards, and the merged results, share the references beside the results folder.
mkdir -p "$parts" "$(dirname "$out")/references"
ln -sfn ../references "$parts/references"

# A shard without jobs (exit code 3) is no failure. Words are quoted for the shell that parallel starts.
run=$(printf '%q ' "$program" run "$config" "$@" --quiet --threads "$threads")
status=0
parallel --joblog "$parts/log" --resume-failed "${options[@]}" \
    "$run --shard {}/$shards --out $(printf '%q' "$parts")/{} >$(printf '%q' "$parts")/{}.txt || [ \$? -eq 3 ]" \
    ::: $(seq "$shards") || status=$?
if [ "$status" -ne 0 ]; then
    echo "some shards failed: look at $parts/log, and run the same command again" >&2
fi

"$program" merge "$parts"/[0-9]*/ --out "$out"
"$program" gate "$out"
