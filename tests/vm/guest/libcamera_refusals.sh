# SPDX-License-Identifier: Apache-2.0
# What cannot be had of libcamera is refused with a sentence, and is had as soon as it can be.
. /vm/guest/rig.bash
modprobe -a vhci_hcd firmware_node

# refused KEY=VALUE... REGEX
refused() {
    local regex=${*: -1}
    ! capture_probe libcamera=1 frames=5 "${@:1:$#-1}" >out || fail "it is refused"
    expect out "not started: .*$regex"
}
refused device=VHCI 'is not there \(libcamera has none\)'
plug_in 0 cam
refused device=elsewhere 'is not there \(libcamera has .*VHCI'
refused device=VHCI width=300 height=200 'no usable format of 300x200 \(it offers .*YUYV'
refused device=VHCI format=NV12 'no usable format'
for format in GREY YUYV; do
    capture_probe libcamera=1 device=VHCI pattern=1 format=$format frames=15 >out
    expect out 'frames=15 .*damaged=0 lost=0 starts=1 torn=0 backwards=0'
done

echo "-- two cameras"
plug_in 1 other
refused device=VHCI "may be any of these of libcamera: .*VHCI-1.*VHCI-2"
LD_LIBRARY_PATH=/vm/lib afterglowctl devices >out
expect out '^    device = "\\_SB_.VHCI-1:1.0-1d6b:0102"$'
expect out '^    device = "\\_SB_.VHCI-2:1.0-1d6b:0102"$'
capture_probe device="$(by_id cam)" pattern=1 frames=45 >one &
v4l2=$!
until_line 20 one 'first frame'
refused device=VHCI-1 'in use by another program'
capture_probe libcamera=1 device=VHCI-2 pattern=1 frames=15 >out
expect out 'frames=15 .*damaged=0 lost=0 starts=1 torn=0 backwards=0'
wait $v4l2
capture_probe libcamera=1 device=VHCI-1 pattern=1 frames=5 >out
expect out 'frames=5 '
