# SPDX-License-Identifier: Apache-2.0
# Through libcamera too no image that a USB camera has spoilt comes out as good, and none after a
# newer one: libcamera hands them out in another order when uvcvideo drops some.
. /vm/guest/rig.bash
modprobe -a vhci_hcd firmware_node
plug_in 0 cam
in_background out capture_probe libcamera=1 device=VHCI pattern=1 retry=1 seconds=9
probe=$!
until_line 20 out 'first frame'
faults cam 1 'bad 2' 'short 2' 'drop 3' 'eproto 30' 'stall 300'
wait $probe
cat out
expect out 'lost=0 .*torn=0 backwards=0'
check "$(value out frames)" '>' 150
check "$(value out missed)" '>=' 4
