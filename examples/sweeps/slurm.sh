#!/bin/bash
# A sweep on a cluster: a job for each part of the cases, on all cores of a machine.
#   sbatch slurm.sh sweep.toml
# Submitted again it goes on where the last jobs ended, so a time limit loses only the cases that were under way. When all
# have ended, `viscobar sweep sweep.toml -o sweep.out` puts their rows together, and runs what is missing.
#SBATCH --job-name=viscobar-sweep
#SBATCH --array=1-4
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=64
#SBATCH --time=24:00:00
#SBATCH --signal=B:TERM@60

set -euo pipefail
sweep=${1:?usage: sbatch slurm.sh SWEEP.toml}

# Where the file system knows no locks (some Lustre mounts), HDF5 has to be told:
# export HDF5_USE_FILE_LOCKING=FALSE
exec viscobar sweep "$sweep" --part "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --quiet -o "$(basename "$sweep" .toml).out"
