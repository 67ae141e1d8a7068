# SPDX-License-Identifier: Apache-2.0
# A camera that goes in the middle of a frame, or freezes, is named, and gives images again within
# two seconds of its return, also under another node.
. /vm/guest/rig.bash
plug_in 0 cam
camera=$(by_id cam)
capture_probe device="$(basename "$camera")" pattern=1 retry=1 seconds=45 >out &
probe=$!
until_line 10 out 'first frame'

# first_frame_after MS: the time of the first "first frame" line after that.
first_frame_after() { awk -v t="$1" '/first frame/ && $1 >= t { print $1; exit }' out; }
is_back_after() { [ -n "$(first_frame_after "$1")" ]; }

echo "-- unplugged, and back after three seconds"
fault cam unplug
until_line 2 out 'lost: .*unplugged'
until_true 5 test ! -e "$camera"
sleep 3
back=$(now_ms)
plug_in 0 cam
until_true 5 is_back_after "$back"
check "$(($(first_frame_after "$back") - back))" '<' 2000

echo "-- unplugged, and back in another port, behind another camera"
fault cam unplug
until_true 5 test ! -e "$camera"
plug_in 0 other
back=$(now_ms)
plug_in 1 cam
until_true 5 is_back_after "$back"
check "$(($(first_frame_after "$back") - back))" '<' 2000

echo "-- frozen for five seconds"
fault cam freeze
until_line 3 out 'lost: .*gives no images'
sleep 4
back=$(now_ms)
fault cam go
until_true 5 is_back_after "$back"
check "$(($(first_frame_after "$back") - back))" '<' 2000

wait $probe
cat out
expect out 'torn=0'
