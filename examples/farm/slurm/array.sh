#!/usr/bin/env bash
# Bakes the shards of a build as an array of Slurm jobs.
#
#   sbatch --array=0-63 array.sh MESHES PACKS [OPTIONS of bake build]
#
# Afterwards, run what is missing, for instance because a node was lost. Give the same OPTIONS:
#
#   bake farm status MESHES --out PACKS --shards 64 [OPTIONS]
#   sbatch --array=3,17 --export=ALL,SHARDS=64 array.sh MESHES PACKS [OPTIONS]
#
#SBATCH --job-name=bake
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
#SBATCH --requeue
set -euo pipefail

# The size of the whole array, also if only some of its shards run again.
shards=${SHARDS:-$SLURM_ARRAY_TASK_COUNT}
exec bake farm build "$1" --out "$2" --shard "$SLURM_ARRAY_TASK_ID/$shards" \
    --jobs "${SLURM_CPUS_PER_TASK:-1}" --memory 3G --quiet "${@:3}"
