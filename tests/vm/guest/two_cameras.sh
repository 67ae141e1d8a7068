# SPDX-License-Identifier: Apache-2.0
# A USB camera of 1280x720 and a depth node, Z16 of 320x240, show one room at the same moments: each
# image and each map is one of its recording, and both have the number that is due. The daemon makes
# of them what afterglow-eval makes of the recording, in the view of either camera.
. /vm/guest/rig.bash
# So slow that the emulated processor keeps up with ease.
record_room room 6 500 rig
recording=$PWD/room plug_in 0 color
recording=$PWD/room plug_in 1 tof depth

echo "-- both alone"
in_background color.out capture_probe device="$(by_id color)" width=1280 height=720 fps=5 \
    recording=room frames=12
color=$!
in_background tof.out capture_probe device="$(by_id tof)" width=320 height=240 fps=5 tof=1 \
    format=Z16 recording=room frames=12
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

for view in tof color; do
    echo "-- the daemon, view of the camera: $view"
    cat >daemon.toml <<TOML
[color]
driver = "v4l2"
device = "$(by_id color)"
fps = 2
[tof]
driver = "v4l2"
device = "$(by_id tof)"
format = "Z16"
fps = 2
warmup_maps = 0
pairing_tolerance_ms = 100
pairing_wait_ms = 400
[illuminator]
driver = "none"
[rig]
calibration = "room/calibration.toml"
[published]
camera = "$view"
[gate]
mode = "interval"
interval_frames = 12
[daemon]
workers = 1
TOML
    start_daemon
    rm -rf published played offline
    mkdir published
    watch_depth "$bus" room 12 published | tee frames.log || { cat daemon.log; fail "right frames"; }
    # One map is measured, for the first image or for the one after, and all later ones are estimated
    # of it. A second one would come an image later than offline: what the driver's queue held while
    # the map was not wanted is read first.
    awk '$2 == 1 { ++measured } measured && $2 == 2 { ++estimated }
         END { exit !(measured == 1 && estimated >= 10 && measured + estimated >= NR - 1) }' \
        frames.log || { cat daemon.log; fail "one map is measured, and the rest follow from it"; }
    kill $daemon
    wait $daemon
    as_offline --published "$view" --set gate.interval_frames=12
done
