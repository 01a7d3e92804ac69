#!/bin/sh
# Shares the jobs of a sweep among the processes that a launcher of MPI starts: process r of n runs the
# lines r + 1, r + 1 + n, and so on, of what --list-jobs printed. The jobs themselves need no MPI.
#   thrum experiments -o results --list-jobs > jobs.txt
#   mpirun -n 8 sh share_jobs.sh jobs.txt       (Open MPI, MPICH; or srun -n 8 in Slurm)
#   thrum experiments -o results --collect
# A job that fails is said and the others go on; the script ends with 0, since a launcher would stop the
# other processes, and --collect names the jobs that are missing.
# SPDX-License-Identifier: Apache-2.0
set -eu
jobs=${1:?usage: mpirun -n N sh share_jobs.sh JOBS.txt}
rank=${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-${SLURM_PROCID:-}}}
size=${OMPI_COMM_WORLD_SIZE:-${PMI_SIZE:-${SLURM_NTASKS:-}}}
if [ -z "$rank" ] || [ -z "$size" ]; then
  echo "share_jobs.sh: start it by mpirun or srun, which say how many processes there are" >&2
  exit 2
fi

awk -v rank="$rank" -v size="$size" '(NR - 1) % size == rank' "$jobs" | while IFS= read -r line; do
  sh -c "$line" </dev/null || echo "share_jobs.sh: failed: $line" >&2
done
