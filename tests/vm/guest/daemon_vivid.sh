# SPDX-License-Identifier: Apache-2.0
# The daemon on vivid, whose times can be made to wrap, and which can be told to fail in
# ways that a USB camera cannot. Its picture is not the TOF camera's room: only that maps are
# measured and that times are right is of interest.
. /vm/guest/rig.bash
record_room room 20 200 320 180
load_vivid
camera=/dev/video0
tolerance=110 # of any phase

# watch FRAMES: what the daemon publishes, in the file `frames`.
watch() { afterglowctl --bus "$bus" monitor --frames "$1" >frames || { cat frames daemon.log; exit 1; }; }
# times_are_right: every frame is from 0 to 600 ms old, and one of the last ten is measured.
times_are_right() {
    awk '$1 ~ /^[0-9]+$/ { ++n; if ($NF < 0 || $NF > 600) bad = 1 }
         END { exit bad || n < 10 }' frames || { cat frames daemon.log; fail "times are right"; }
    tail -n 10 frames | grep -q measured || { cat frames daemon.log; fail "it measures"; }
}

for wrap in 1 2; do
    echo "-- times that wrap after 16 seconds: to below 0, or beyond 32 bits ($wrap)"
    v4l2-ctl -c wrap_timestamp=$wrap
    [ $wrap = 2 ] || run_daemon
    until_true 5 state_is idle
    missed=$(statistic FramesMissed)
    watch 100
    times_are_right
    check "$(($(statistic FramesMissed) - missed))" '<' 20
done
v4l2-ctl -c wrap_timestamp=0
until_true 5 state_is idle

echo "-- a driver that marks, drops and stops"
in_background frames afterglowctl --bus "$bus" monitor
until_true 10 grep -q measured frames
v4l2-ctl -c inject_v4l2_buf_flag_error=1
until_line 5 daemon.log 'corrupt'
missed=$(statistic FramesMissed)
more_missed() { [ "$(statistic FramesMissed)" -gt "$missed" ]; }
# So few that six in a row, a silent camera that is restarted, are not to be expected.
v4l2-ctl -c percentage_of_dropped_buffers=20
until_true 20 more_missed
v4l2-ctl -c percentage_of_dropped_buffers=0
v4l2-ctl -c inject_fatal_streaming_error=1
until_line 5 daemon.log "'/dev/video0' stopped"
until_true 5 state_is running
v4l2-ctl -c disconnect=1
until_line 5 daemon.log 'was unplugged'
until_true 5 state_is running
check "$(statistic FramesDamaged)" == 1
seen=$(wc -l <frames)
ten_more() { [ "$(wc -l <frames)" -ge $((seen + 10)) ]; }
until_true 10 ten_more
times_are_right
kill -0 $daemon
cat daemon.log
