# SPDX-License-Identifier: Apache-2.0
# The daemon on a v4l2loopback device into which afterglow-feed plays, and an OpenNI2 device,
# publishes what afterglow-eval does offline.
. /vm/guest/rig.bash
# So slow that the emulated processor keeps up with ease.
record_room room 20 400
fps=2.5
modprobe v4l2loopback video_nr=20 exclusive_caps=1
udevadm settle
afterglow-feed /dev/video20 room &
feeder=$!
sleep 1
camera=/dev/video20
run_daemon
mkdir published
watch_depth "$bus" room 20 published >frames.log || { cat frames.log daemon.log; fail "right frames"; }
cat frames.log
kill $daemon $feeder
wait $daemon
as_offline
lit_as_told
