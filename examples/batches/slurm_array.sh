#!/bin/sh
#SBATCH --job-name=arcline
#SBATCH --array=0-99
#SBATCH --cpus-per-task=1
#SBATCH --requeue
# A batch as a Slurm job array: sbatch slurm_array.sh PROGRAM.st CASES.jsonl FOLDER. Each task runs CHUNK cases into a file of its own; a task that is
# requeued goes on behind the results that it has. At the end: cat FOLDER/results-*.jsonl > RESULTS.jsonl
set -eu
chunk="${CHUNK:-1000}"
from=$((SLURM_ARRAY_TASK_ID * chunk))
exec arcline-server simulate "$1" --cases "$2" --from "$from" --to $((from + chunk)) --jobs "${SLURM_CPUS_PER_TASK:-1}" \
    --output "$3/results-$(printf %05d "$SLURM_ARRAY_TASK_ID").jsonl" --resume
