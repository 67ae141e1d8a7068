# SPDX-License-Identifier: Apache-2.0
# A USB camera of 1280x720 and a depth node, Z16 of 320x240, show one room at the same moments: each
# image and each map is one of its recording, and both have the number that is due.
. /vm/guest/rig.bash
# So slow that the emulated processor keeps up with ease.
record_room color 6 500 1280 720
record_room tof 6 500 320 240
recording=$PWD/color plug_in 0 color
recording=$PWD/tof plug_in 1 tof depth

in_background color.out capture_probe device="$(by_id color)" width=1280 height=720 fps=5 \
    recording=color frames=12
color=$!
in_background tof.out capture_probe device="$(by_id tof)" width=320 height=240 fps=5 tof=1 \
    format=Z16 recording=tof frames=12
wait $! $color || { cat color.out tof.out; fail "both give frames"; }
cat color.out tof.out
for camera in color tof; do
    expect $camera.out 'frames=12 .*damaged=0 lost=0 starts=1 torn=0 backwards=0 strange=0'
done
# A map belongs to the image of its number, taken within half a frame.
awk '/^shown/ && NR == FNR { t[$2, ++n[$2]] = $3; next }
     /^shown/ {
         for (i = 1; i <= n[$2]; ++i)
             if ($3 - t[$2, i] < 250 && t[$2, i] - $3 < 250) ++together
     }
     END { exit !(together >= 8) }' color.out tof.out || fail "both show the same moments"
