# SPDX-License-Identifier: Apache-2.0
# The daemon publishes what afterglow-eval does offline also for a real sequence, 640x480: its
# images come from a v4l2loopback device, its depth from an OpenNI2 device.
. /vm/guest/rig.bash
[ -d /vm/recording ] || skip "the recording tum_fr1_rpy is not beside the project"
ln -s /vm/recording room
frames=$(wc -l <room/associations.txt)
# So slow that the emulated processor keeps up with ease. The sequence's intervals, which are not
# equal, spread with it, and an image seems to be off by as much as its own differs from the mean.
speed=0.033
fps=1
tolerance=300
export AFTERGLOW_TESTCAM_SPEED=$speed
modprobe v4l2loopback video_nr=20 exclusive_caps=1
udevadm settle
afterglow-feed /dev/video20 room --speed $speed &
feeder=$!
sleep 3
camera=/dev/video20
run_daemon
mkdir published
watch_depth "$bus" room "$frames" published >frames.log ||
    { cat frames.log daemon.log; fail "right frames"; }
cat frames.log
check "$(statistic FramesMissed)" == 0
kill $daemon $feeder
wait $daemon
as_offline
lit_as_told
