#!/bin/bash
# A flight drawn by a Slurm job array, and its video when all frames are there:
#
#   fly.sh -n TASKS -o VIDEO [-f FPS] [-s SBATCH_OPTION]... -- INPUT... --camera FILE [capture's options]
#
# Frames go to VIDEO.frames/ beside the video. To go on after a failure, run the same line again:
# frames that are there are kept. GNOMON names the program where it is not in PATH.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
usage() { sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2; }

tasks='' video='' fps=30 sbatch_options=()
while getopts n:o:f:s: option; do
    case $option in
        n) tasks=$OPTARG ;;
        o) video=$OPTARG ;;
        f) fps=$OPTARG ;;
        s) sbatch_options+=("$OPTARG") ;;
        *) usage ;;
    esac
done
shift $((OPTIND - 1))
[ -n "$tasks" ] && [ -n "$video" ] && [ $# -gt 0 ] || usage

frames=$video.frames
mkdir -p "$frames/log"
export GNOMON=${GNOMON:-gnomon}
drawing=$(sbatch --parsable "${sbatch_options[@]}" --array="1-$tasks" \
    --output="$frames/log/%A_%a.txt" --open-mode=append \
    "$here/frames.sbatch" "$frames" "$fps" "$@")
encoding=$(sbatch --parsable "${sbatch_options[@]}" --dependency="afterok:$drawing" \
    --kill-on-invalid-dep=yes --output="$frames/log/%A.txt" \
    "$here/video.sbatch" "$frames" "$fps" "$video" "$@")
echo "frames: job $drawing, $tasks tasks; video: job $encoding; what they say: $frames/log"
