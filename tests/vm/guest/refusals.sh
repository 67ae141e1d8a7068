# SPDX-License-Identifier: Apache-2.0
# What cannot work is refused in a sentence that says why.
. /vm/guest/rig.bash
load_vivid

refused() {
    ! capture_probe fps=25 seconds=20 "${@:2}" >out || { cat out; fail "it worked: ${*:2}"; }
    expect out "$1"
}

refused 'is not there' device=/dev/video9
refused 'is not there' device=usb-none
refused 'is no V4L2 device' device=/dev/null
refused 'is no V4L2 device' device=/etc/passwd
refused 'no usable format of 333x200 \(it offers .*YUYV' width=333 height=200
refused 'not one that can be read' format=H264
refused 'no usable format' tof=1 format=Z16 width=640 height=360
refused 'no control' light=torch device=/dev/video0

echo "-- in use by another program"
v4l2-ctl --stream-mmap --stream-count=0 >/dev/null 2>&1 &
other=$!
until_true 20 sh -c '! v4l2-ctl --set-fmt-video=width=320,height=180'
in_background out capture_probe width=640 height=360 fps=25 frames=5 retry=1 seconds=60
probe=$!
until_line 20 out 'in use by another program'
kill $other
wait $probe
expect out 'frames=5 .*starts=1'
