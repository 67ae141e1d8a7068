# SPDX-License-Identifier: Apache-2.0
# As daemon_uvc, with the USB camera used through libcamera.
modprobe -a vhci_hcd firmware_node
color_driver=libcamera
camera=VHCI # of its id, \_SB_.VHCI-1:1.0-1d6b:0102
. /vm/guest/daemon_uvc.sh
