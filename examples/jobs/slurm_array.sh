#!/bin/sh
# One job of a sweep in each task of an array of Slurm: task n runs line n of what --list-jobs printed.
#   thrum experiments -o results --list-jobs > jobs.txt
#   sbatch --array=1-"$(wc -l < jobs.txt)" slurm_array.sh jobs.txt
#   thrum experiments -o results --collect      (when all have ended)
# The folder must be one that all nodes see. A task that was stopped is started again by its number.
# SPDX-License-Identifier: Apache-2.0
#SBATCH --job-name=thrum
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --output=thrum-%A-%a.log
set -eu
jobs=${1:?usage: sbatch --array=1-N slurm_array.sh JOBS.txt}
number=${SLURM_ARRAY_TASK_ID:?this is a task of an array: sbatch --array=1-N slurm_array.sh JOBS.txt}

line=$(sed -n "${number}p" "$jobs")
if [ -z "$line" ]; then
  echo "slurm_array.sh: $jobs has no line $number" >&2
  exit 1
fi
exec sh -c "$line"
