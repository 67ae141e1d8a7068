# SPDX-License-Identifier: Apache-2.0
# A control of a video node obeys as a light would, and ends off.
. /vm/guest/rig.bash
load_vivid
is() { v4l2-ctl -C boolean | grep -q "boolean: $1"; }

v4l2-ctl -c boolean=1
in_background out capture_probe device=/dev/video0 light=boolean seconds=2
probe=$!
until_line 20 out 'lit'
is 1 || fail "the light is not on"
wait $probe
is 0 || fail "the light is not off"
