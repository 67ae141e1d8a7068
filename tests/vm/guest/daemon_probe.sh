# SPDX-License-Identifier: Apache-2.0
# The configuration that `afterglowctl probe` writes for a USB camera and an OpenNI2 device is one with
# which the daemon measures, estimates and gates the light.
. /vm/guest/rig.bash
# So slow that the emulated processor keeps up with ease.
record_room room 20 500 640 480
recording=$PWD/room plug_in 0 cam
plug_in_testcam
afterglowctl devices
afterglowctl probe daemon.toml
cat daemon.toml
expect daemon.toml '^device = ".*Afterglow_Test_Camera_cam'
expect daemon.toml '^driver = "openni2-emitter"'
start_daemon
watch_depth "$bus" room 12 >frames.log || { cat frames.log daemon.log; fail "right frames"; }
cat frames.log daemon.log
expect frames.log '^[0-9]+ 1 1 '
expect frames.log '^[0-9]+ 2 0 '
kill $daemon
wait $daemon
tail -n 1 emitter | grep -q ' off$' || fail "the emitter is off"
