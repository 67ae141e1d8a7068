# SPDX-License-Identifier: Apache-2.0
# Rates and capture times are right: every image comes, in time, with the time it was taken.
. /vm/guest/rig.bash
# The greatest age that an image had when it was read, by its capture time; ms.
oldest() { grep -oE 'age_ms=.*' "$1" | tail -n 1 | sed 's/.*\.\.//'; }

echo "-- v4l2loopback at 30, 60 and 120 images a second"
modprobe v4l2loopback video_nr=20 exclusive_caps=1
udevadm settle
for fps in 30 60 120; do
    feed_loopback /dev/video20 320 240 $fps $((4 * fps)) &
    feeder=$!
    sleep 1
    capture_probe device=/dev/video20 fps=$fps pattern=1 frames=$((2 * fps)) >out
    wait $feeder
    cat out
    # The device numbers its first image 0, and the next with all those it was ever given.
    expect out 'damaged=0 lost=0 starts=1 torn=0 backwards=0'
    check "$(value out fps)" '>' "$((fps - 1))"
    check "$(value out fps)" '<' "$((fps + 1))"
    check "$(oldest out)" '<' 100
done

echo "-- a USB camera at 30"
plug_in 0 cam
capture_probe device="$(by_id cam)" pattern=1 frames=60 >out
cat out
expect out 'missed=0 damaged=0 lost=0 starts=1 torn=0 backwards=0'
check "$(value out fps)" '>' 29
check "$(value out fps)" '<' 31
check "$(oldest out)" '<' 100

echo "-- a slow reader gets new images, not old ones"
capture_probe device="$(by_id cam)" pattern=1 frames=15 slow_ms=200 >out
cat out
expect out 'damaged=0 lost=0 starts=1 torn=0 backwards=0'
check "$(value out missed)" '>' 40
