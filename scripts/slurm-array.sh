#!/usr/bin/env bash
# Runs an experiment as a Slurm array, in shards; then merges them, writes the report and gates.
#
#   scripts/slurm-array.sh SHARDS CONFIG [key=value …]      for example: scripts/slurm-array.sh 32 quickstart repeats=10
#
# Submit it from a folder that all nodes see. What a site must set, docs/cluster.md says:
#   LIGHTBENCH       the program; default: lightbench
#   LIGHTBENCH_OUT   the results folder; default: results/<last part of CONFIG>
#   SBATCH_OPTIONS   for every job, such as "--partition=cpu --account=light --time=02:00:00"
#   THREADS          processors of a shard; default: 8
# A shard that is killed, or whose node is lost, is requeued and goes on with the jobs that it has not finished.
set -euo pipefail

if [ $# -lt 2 ] || ! [[ $1 =~ ^[1-9][0-9]*$ ]]; then
    sed -n '2,11s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
shards=$1
config=$2
shift 2
program=${LIGHTBENCH:-lightbench}
threads=${THREADS:-8}
name=$(basename "$config" .toml)
out=${LIGHTBENCH_OUT:-results/$name}
parts=$out.shards
read -r -a options <<<"${SBATCH_OPTIONS:-}"

# Everything is wrong now or not at all: a plan casts no ray.
"$program" plan "$config" "$@" >/dev/null

# All shards, and the merged results, share the references beside the results folder.
mkdir -p "$parts" "$(dirname "$out")/references"
ln -sfn ../references "$parts/references"

# Words that the shell of a batch job reads back as they are here.
quoted() { printf '%q ' "$@"; }
submit() { sbatch --parsable --requeue --open-mode=append "${options[@]}" "$@" | cut -d';' -f1; }

# A shard without jobs (exit code 3) is no failure; nor are jobs that failed (4): they are rows, and merging tells.
part=$(printf '%q' "$parts")
shard="$(quoted "$program" run "$config" "$@" --quiet --threads "$threads")"
shard+="--shard \$SLURM_ARRAY_TASK_ID/$shards --out $part/\$SLURM_ARRAY_TASK_ID"
array=$(submit --array="1-$shards" --job-name="$name" --cpus-per-task="$threads" --output="$parts/%a.log" \
    --wrap "$shard; code=\$?; [ \$code -eq 3 ] || [ \$code -eq 4 ] || exit \$code")

# Whatever became of the shards: the gate says which jobs have no result.
merge="$(quoted "$program")merge $part/[0-9]*/ --out $(quoted "$out")"
gate=$(quoted "$program" gate "$out")
last=$(submit --dependency="afterany:$array" --job-name="$name-merge" --output="$parts/merge.log" \
    --wrap "$merge && $gate")

echo "$shards shards: job $array; merge, report and gate: job $last; then: $out/report.html"
