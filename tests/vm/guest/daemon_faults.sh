# SPDX-License-Identifier: Apache-2.0
# Whatever the cameras do, the daemon stays up, names the state, recovers within two seconds of a
# device's return, and publishes nothing wrong.
. /vm/guest/rig.bash
record_room room 20 200
# A map takes the emulated processor up to 20 ms from exposure to arrival, which it seems late by.
tolerance=40
recording=$PWD/room plug_in 0 cam
camera=${camera:-$(basename "$(by_id cam)")}
run_daemon
watch_depth "$bus" room 1000000 >frames.log &
watcher=$!
until_line 20 frames.log '^[0-9]+ 1 '

echo "-- the colour camera is unplugged, and comes back"
fault cam unplug
until_true 5 state_is color-lost
expect daemon.log 'was unplugged'
sleep 3
recording=$PWD/room plug_in 0 cam
back_within 2000

echo "-- it is unplugged in the middle of a frame"
fault cam cut
until_true 5 state_is color-lost
recording=$PWD/room plug_in 0 cam
back_within 2000

echo "-- it spoils, drops and stalls"
faults cam 1 'bad 2' 'short 2' 'drop 2' 'eproto 30' 'stall 500'
until_true 5 state_is running

echo "-- it freezes"
fault cam freeze
until_true 10 state_is color-lost
fault cam go
back_within 2000

echo "-- the TOF camera is unplugged while it is lit, and comes back"
afterglowctl --bus "$bus" mode always-on
until_true 5 state_is running
until_true 5 sh -c "grep -E ' (on|off)$' emitter | tail -n 1 | grep on"
echo unplug >testcam.fifo
until_true 5 state_is tof-lost
sleep 3
echo plug >testcam.fifo
back_within 2000 1

echo "-- it is lit, and gives no map for five seconds and 120 images"
echo freeze >testcam.fifo
until_line 40 daemon.log 'is lit and measures nothing'
until_true 5 state_is tof-lost
echo go >testcam.fifo
back_within 2000 1

echo "-- both cameras are unplugged at once, and come back"
fault cam unplug
echo unplug >testcam.fifo
until_true 5 state_is color-lost
sleep 3
recording=$PWD/room plug_in 0 cam
echo plug >testcam.fifo
back_within 2000 1
until_true 5 state_is running

echo "-- the colour camera is in use by another program when it is wanted"
kill $watcher
until_true 5 state_is idle
v4l2-ctl -d "$(by_id cam)" --stream-mmap --stream-count=0 >/dev/null 2>&1 &
other=$!
until_true 20 sh -c "! v4l2-ctl -d '$(by_id cam)' --set-fmt-video=width=640,height=480"
watch_depth "$bus" room 1000000 >>frames.log &
watcher=$!
until_true 5 state_is color-lost
expect daemon.log 'in use by another program'
kill $other
back_within 2000

kill -0 $daemon || fail "the daemon is up"
kill -0 $watcher || fail "the stream has gone on"
check "$(awk '$2 == 2' frames.log | wc -l)" '>' 50
awk '$2 == 2 && $5 > 5' frames.log >bad
[ ! -s bad ] || { cat frames.log daemon.log; fail "every estimate is within 5 % of the truth"; }
kill $watcher
kill $daemon
wait $daemon
tail -n 1 emitter | grep -q ' off$' || fail "the emitter is off"
cat daemon.log
