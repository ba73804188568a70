#!/bin/bash
# Opens the built-in place in a window of a virtual X server, drags and scrolls with a real pointer and
# quits by key; then asks that the pictures differ as they must. Exit code 77: nothing to run it with.
set -euo pipefail
gnomon=$1
for tool in Xvfb xdotool; do
    command -v $tool >/dev/null || { echo "skipped: $tool is not installed"; exit 77; }
done

work=$(mktemp -d)
exec 3< <(Xvfb -displayfd 1 -screen 0 800x600x24 -nolisten tcp 2>"$work/xvfb.log" & echo "pid $!" >"$work/pid"; wait)
cleanup() {
    kill "$(sed 's/pid //' "$work/pid")" 2>/dev/null || true
    rm -rf "$work"
}
trap cleanup EXIT
read -r display <&3
export DISPLAY=:$display

"$gnomon" demo "$work/place" --size 60 2>/dev/null

# shoot NAME [xdotool arguments…]: what the window shows after these.
shoot() {
    local name=$1
    shift
    "$gnomon" view "$work/place" --size 320x240 --screenshot "$work/$name.png" --quit-after 60 \
        2>"$work/$name.log" &
    local viewer=$!
    local window
    window=$(timeout 60 xdotool search --sync --onlyvisible --name '^gnomon$' | head -n 1)
    sleep 3 # tiles stream in; the picture asked for is the last one
    xdotool mousemove --window "$window" 160 120 "$@" sleep 0.5 key --window "$window" q
    local started=$SECONDS code=0
    wait $viewer || code=$?
    [ $code -eq 0 ] || { cat "$work/$name.log"; echo "view ended with $code"; exit 1; }
    [ $((SECONDS - started)) -lt 20 ] || { echo "q did not quit"; exit 1; }
    [ -s "$work/$name.png" ] || { echo "no screenshot $name"; exit 1; }
}
differ() { ! cmp -s "$work/$1.png" "$work/$2.png" || { echo "$1 and $2 show the same"; exit 1; }; }

shoot still
shoot again
shoot turned mousedown 3 sleep 0.2 mousemove_relative --sync 60 0 sleep 0.2 mouseup 3
shoot zoomed click 4 sleep 0.2 click 4
shoot panned mousedown 1 sleep 0.2 mousemove_relative --sync 40 20 sleep 0.2 mouseup 1
cmp -s "$work/still.png" "$work/again.png" || { echo "the same view is not the same picture"; exit 1; }
differ still turned
differ still zoomed
differ still panned
differ turned panned
echo "the window turns, zooms, pans and quits"
