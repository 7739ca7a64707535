#!/bin/bash
# A sweep on a cluster: one rank hands out the cases and writes the rows, each of the others runs one case at a time.
#   sbatch slurm.sh sweep.toml
# Submitted again it goes on where the last job ended, so a time limit loses only the cases that were under way.
#SBATCH --job-name=viscobar-sweep
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=64
#SBATCH --cpus-per-task=1
#SBATCH --time=24:00:00
#SBATCH --signal=TERM@60

set -euo pipefail
sweep=${1:?usage: sbatch slurm.sh SWEEP.toml}

# Where the file system knows no locks (some Lustre mounts), HDF5 has to be told:
# export HDF5_USE_FILE_LOCKING=FALSE
srun viscobar sweep "$sweep" --quiet -o "$(basename "$sweep" .toml).out"
