# SPDX-License-Identifier: Apache-2.0
# The daemon on a USB camera and an OpenNI2 device publishes what afterglow-eval does offline.
. /vm/guest/rig.bash
# So slow that the emulated processor keeps up with ease.
record_room room 20 400
fps=2.5
# The camera's emulation shows an image up to 32 ms late at times.
tolerance=100
recording=$PWD/room plug_in 0 cam
camera=${camera:-$(basename "$(by_id cam)")}
run_daemon
mkdir published
watch_depth "$bus" room 20 published >frames.log || { cat frames.log daemon.log; fail "right frames"; }
cat frames.log
check "$(statistic FramesMissed)" == 0
check "$(statistic PairingErrorP99)" '<' 50000000
kill $daemon
wait $daemon
as_offline
lit_as_told
