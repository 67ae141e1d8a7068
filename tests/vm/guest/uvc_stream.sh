# SPDX-License-Identifier: Apache-2.0
# A USB camera gives whole images in each of its formats, found by each of its names.
. /vm/guest/rig.bash
plug_in 0 first
camera=$(by_id first)

for format in GREY YUYV; do
    capture_probe device="$camera" pattern=1 format=$format frames=15 >out
    expect out 'frames=15 .*damaged=0 lost=0 starts=1 torn=0 backwards=0'
done
capture_probe device="$camera" pattern=1 tof=1 frames=15 >out
expect out 'frames=15 .*damaged=0 lost=0 starts=1 torn=0 backwards=0'
capture_probe device="$camera" width=640 height=480 fps=15 pattern=1 frames=15 >out
expect out 'frames=15 .*damaged=0 lost=0 starts=1 torn=0 backwards=0'

# The other names: that in by-id, and the bus, which a metadata node has as well.
bus=$(v4l2-ctl -d "$camera" --info | awk '/Bus info/ { print $4; exit }')
for name in "$(basename "$camera")" "$bus"; do
    capture_probe device="$name" frames=5 >out
    expect out 'frames=5 '
done

echo "-- exposure is not allowed to lengthen the frames"
v4l2-ctl -d "$camera" -C exposure_dynamic_framerate | grep -q ': 0' || fail "it is"

echo "-- two cameras at once"
plug_in 1 second
capture_probe device="$camera" pattern=1 frames=30 >one &
one=$!
capture_probe device="$(by_id second)" pattern=1 frames=30 >two
wait $one
expect one 'frames=30 .*torn=0'
expect two 'frames=30 .*torn=0'
