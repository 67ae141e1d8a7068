# SPDX-License-Identifier: Apache-2.0
# As daemon_faults, with the USB camera used through libcamera.
modprobe -a vhci_hcd firmware_node
color_driver=libcamera
camera=VHCI
. /vm/guest/daemon_faults.sh
