# SPDX-License-Identifier: Apache-2.0
# No image that a USB camera has spoilt comes out as good, whether uvcvideo drops it or marks it.
. /vm/guest/rig.bash

for nodrop in 0 1; do
    echo "-- uvcvideo nodrop=$nodrop"
    [ ! -d /sys/module/uvcvideo ] || modprobe -r uvcvideo
    modprobe uvcvideo nodrop=$nodrop
    check "$(cat /sys/module/uvcvideo/parameters/nodrop)" == "$nodrop"
    plug_in 0 cam
    in_background out capture_probe device="$(by_id cam)" pattern=1 retry=1 seconds=12
    probe=$!
    until_line 20 out 'first frame'
    faults cam 0.7 'bad 2' 'short 2' 'drop 3' 'eproto 30' 'stall 300'
    wait $probe
    cat out
    expect out 'torn=0 backwards=0'
    expect out 'lost=0'
    check "$(value out frames)" '>' 20
    if [ $nodrop = 1 ]; then
        check "$(value out damaged)" '>=' 4
    else
        check "$(value out missed)" '>=' 4
    fi
    fault cam unplug
    until_true 20 test ! -e "$(by_id cam)"
done
