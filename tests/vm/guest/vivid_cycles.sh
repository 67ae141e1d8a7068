# SPDX-License-Identifier: Apache-2.0
# Opening, streaming and closing leaves nothing behind.
# limit: 2000
. /vm/guest/rig.bash
load_vivid

capture_probe width=320 height=180 fps=50 cycles=10000 >out
cat out
expect out 'descriptors=\+0 mappings=\+0'
check "$(value out heap_bytes)" '<' 4096
