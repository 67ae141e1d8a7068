# SPDX-License-Identifier: Apache-2.0
# Every kind of format of the kernel's test camera gives images, and the cheapest is found.
. /vm/guest/rig.bash
load_vivid

capture_probe width=640 height=360 fps=25 frames=10 >cheapest
expect cheapest 'frames=10 .*damaged=0 lost=0 starts=1 .*backwards=0'

for format in GREY Y16 NV16 YU12 YUYV UYVY YVYU VYUY BGR3 RGB3 BA81; do
    capture_probe width=640 height=360 fps=25 frames=4 format=$format >$format || { cat $format; fail $format; }
    expect $format 'frames=4 .*damaged=0'
done

capture_probe width=640 height=360 fps=25 frames=4 tof=0.5 format=Y16 >depth
expect depth 'frames=4 .*damaged=0'
