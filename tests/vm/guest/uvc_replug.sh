# SPDX-License-Identifier: Apache-2.0
# A camera that goes in the middle of a frame, or freezes, is named, and gives images again within
# two seconds of its return, also under another node.
. /vm/guest/rig.bash
plug_in 0 cam
camera=$(by_id cam)
in_background out capture_probe device="$(basename "$camera")" pattern=1 retry=1 seconds=45
probe=$!
until_line 10 out 'first frame'

echo "-- unplugged, and back after three seconds"
fault cam unplug
until_line 2 out 'lost: .*unplugged'
until_true 5 test ! -e "$camera"
sleep 3
back=$(now_ms)
plug_in 0 cam
back_within_two_seconds "$back"

echo "-- unplugged, and back in another port, behind another camera"
fault cam unplug
until_true 5 test ! -e "$camera"
plug_in 0 other
back=$(now_ms)
plug_in 1 cam
back_within_two_seconds "$back"

echo "-- frozen for five seconds"
fault cam freeze
until_line 3 out 'lost: .*gives no images'
sleep 4
back=$(now_ms)
fault cam go
back_within_two_seconds "$back"

wait $probe
cat out
expect out 'torn=0'
