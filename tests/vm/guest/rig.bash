# SPDX-License-Identifier: Apache-2.0
# What the tests in this folder are written with. Source it first.
set -Eeuo pipefail
trap 'echo "failed in line $LINENO: $BASH_COMMAND"' ERR

fail() {
    echo "not so: $*"
    exit 1
}

# expect FILE REGEX: some line of FILE matches. reject FILE REGEX: none does.
expect() { grep -Eq -- "$2" "$1" || { cat "$1"; fail "$1 has no '$2'"; }; }
reject() { ! grep -Eq -- "$2" "$1" || { cat "$1"; fail "$1 has '$2'"; }; }

# value FILE KEY: the number after KEY= in the last line that has it.
value() { grep -oE "\b$2=[-+]?[0-9.]+" "$1" | tail -n 1 | cut -d= -f2; }

# check A OP B: a comparison of numbers, with fractions.
check() { awk "BEGIN { exit !($1 $2 $3) }" || fail "$1 $2 $3"; }

# until_true SECONDS COMMAND...: waits for the command to succeed.
until_true() {
    local tries=$(($1 * 20))
    shift
    while ! "$@" >/dev/null 2>&1; do
        [ $((tries -= 1)) -gt 0 ] || fail "in time: $*"
        sleep 0.05
    done
}

# until_line SECONDS FILE REGEX: waits for a line that matches.
until_line() { (until_true "$1" grep -Eq -- "$3" "$2") || { cat "$2"; exit 1; }; }

# Milliseconds of CLOCK_MONOTONIC, to the next ten, as capture_probe prints them.
now_ms() { awk '{ print int($1 * 1000) }' /proc/uptime; }

# load_vivid [OPTION...]: a camera at /dev/video0.
load_vivid() {
    modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0 "$@"
    udevadm settle
}

# plug_in PORT SERIAL: a USB camera; its faults are lines written to the file SERIAL.fifo.
plug_in() {
    modprobe -a vhci_hcd uvcvideo
    [ -p "$2.fifo" ] || mkfifo "$2.fifo"
    uvc_camera "$1" "$2" "$2.fifo" &
    until_true 20 test -e "$(by_id "$2")"
}
fault() { echo "$2" >"$1.fifo"; }
# The stable name of a camera's video node.
by_id() { echo "/dev/v4l/by-id/usb-Afterglow_Test_Camera_$1-video-index0"; }
