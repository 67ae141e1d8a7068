# SPDX-License-Identifier: Apache-2.0
# A camera of another format or size than the configured one is refused in a sentence, and the
# daemon waits for the right one.
. /vm/guest/rig.bash
record_room room 20 200
modprobe v4l2loopback video_nr=20 exclusive_caps=1
udevadm settle
camera=/dev/video20

# in_its_place [COMMAND...]: what feeds the device from now on; nothing if there is no command.
feeder=
in_its_place() {
    [ -z "$feeder" ] || end_by TERM $feeder
    feeder=
    if [ $# -gt 0 ]; then
        "$@" &
        feeder=$!
    fi
}

echo "-- another size"
in_its_place feed_loopback $camera 320 240 5 100000
sleep 1
run_daemon
watch_depth "$bus" room 1000000 >frames.log &
watcher=$!
until_true 5 state_is color-lost
until_line 5 daemon.log 'no usable format of 160x120 \(it offers GREY'

echo "-- no luma"
in_its_place feed_loopback $camera 160 120 5 100000 H264
until_line 5 daemon.log 'no usable format of 160x120 \(it offers H264'

echo "-- the right one"
in_its_place afterglow-feed $camera room
back_within 2000
until_true 5 state_is running

echo "-- another size in its place"
in_its_place
until_true 5 state_is color-lost
in_its_place feed_loopback $camera 320 240 5 100000
(until_true 5 sh -c "[ \$(grep -c 'no usable format .*GREY' daemon.log) -ge 2 ]") || { cat daemon.log; exit 1; }
in_its_place afterglow-feed $camera room
back_within 2000
until_true 5 state_is running

kill -0 $daemon || fail "the daemon is up"
kill -0 $watcher || { cat frames.log; fail "only right frames"; }
cat daemon.log
