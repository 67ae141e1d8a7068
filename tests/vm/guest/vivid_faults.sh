# SPDX-License-Identifier: Apache-2.0
# What vivid can be told to do wrong is named, and survived.
. /vm/guest/rig.bash
load_vivid

# watch FRAMES: a probe in the background that starts again what is lost.
watch() {
    in_background out capture_probe width=640 height=360 fps=25 retry=1 seconds=60 frames="$1"
    probe=$!
    until_line 30 out 'first frame'
}

echo "-- a buffer marked as corrupt"
watch 40
v4l2-ctl -c inject_v4l2_buf_flag_error=1
wait $probe
expect out 'damaged: .*corrupt'
expect out 'frames=40 .*damaged=1 lost=0 starts=1 .*backwards=0'

echo "-- the driver stops"
watch 60
v4l2-ctl -c inject_fatal_streaming_error=1
wait $probe
expect out 'lost: '
expect out 'frames=60 .*starts=2'

echo "-- calls that fail while it starts"
for call in vidioc_streamon vidioc_reqbufs; do
    v4l2-ctl -c inject_${call}_error=1
    capture_probe width=640 height=360 fps=25 retry=1 frames=5 seconds=60 >out
    expect out 'not started: '
    expect out 'frames=5 .*starts=1'
done

echo "-- dropped buffers are a gap"
v4l2-ctl -c percentage_of_dropped_buffers=40
capture_probe width=640 height=360 fps=25 frames=40 >out
check "$(value out missed)" '>' 5
v4l2-ctl -c percentage_of_dropped_buffers=0

# Times wrap after 16 seconds: to below 0, or beyond 32 bits. Numbers wrap after 128 frames.
for wrap in 1 2; do
    echo "-- times and numbers that wrap ($wrap)"
    v4l2-ctl -c wrap_timestamp=$wrap,wrap_sequence_number=1
    capture_probe width=320 height=180 fps=10 frames=180 >out
    cat out
    expect out 'frames=180 .*backwards=0'
    check "$(value out missed)" '<' 60
    oldest=$(grep -oE 'age_ms=.*' out | sed 's/.*\.\.//')
    check "$oldest" '<' 200
done
v4l2-ctl -c wrap_timestamp=0,wrap_sequence_number=0

echo "-- the device disconnects, and is there again at once"
watch 60
v4l2-ctl -c disconnect=1
wait $probe
expect out 'lost: .*unplugged'
expect out 'frames=60 .*lost=1 starts=2'
