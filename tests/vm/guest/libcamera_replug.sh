# SPDX-License-Identifier: Apache-2.0
# A camera of libcamera's that goes in the middle of a frame, freezes, or takes its process with it
# is named, and gives images again within two seconds of its return.
. /vm/guest/rig.bash
modprobe -a vhci_hcd firmware_node
plug_in 0 cam
in_background out capture_probe libcamera=1 device=VHCI pattern=1 retry=1 seconds=28
probe=$!
until_line 10 out 'first frame'

echo "-- unplugged, and back after three seconds"
fault cam unplug
until_line 2 out 'lost: .*unplugged'
sleep 3
back=$(now_ms)
plug_in 0 cam
back_within_two_seconds "$back"

echo "-- frozen for four seconds"
fault cam freeze
until_line 3 out 'lost: .*gives no images'
sleep 3
back=$(now_ms)
fault cam go
back_within_two_seconds "$back"

echo "-- libcamera hangs"
pkill -STOP -f 'afterglow-libcamera capture'
back=$(now_ms)
back_within_two_seconds "$back"

echo "-- libcamera dies"
back=$(now_ms)
pkill -KILL -f 'afterglow-libcamera capture'
until_line 2 out "lost: .*process ended"
back_within_two_seconds "$back"

wait $probe
cat out
expect out 'torn=0'
[ -z "$(pgrep -f 'afterglow-libcamera capture')" ] || fail "no process is left behind"
