# SPDX-License-Identifier: Apache-2.0
# A v4l2loopback device gives what is written into it; when its writer dies it is silent, and lost.
. /vm/guest/rig.bash
modprobe v4l2loopback video_nr=20
udevadm settle

echo "-- without a writer it is no camera"
! capture_probe device=/dev/video20 frames=5 >out || fail "it was"
expect out 'not started: '

echo "-- a writer that dies, and another"
feed_loopback /dev/video20 320 240 30 60 &
feeder=$!
sleep 0.5
in_background out capture_probe device=/dev/video20 pattern=1 retry=1 frames=90 seconds=60
probe=$!
wait $feeder
until_line 10 out 'lost: .*gives no images'
feed_loopback /dev/video20 320 240 30 150 &
wait $probe
cat out
expect out 'frames=90 .*damaged=0 .*torn=0 backwards=0'
