# SPDX-License-Identifier: Apache-2.0
# What the tests in this folder are written with. Source it first.
set -Eeuo pipefail
trap 'echo "failed in line $LINENO: $BASH_COMMAND"' ERR

fail() {
    echo "not so: $*"
    exit 1
}

# skip WHY: what the test needs is not there.
skip() {
    echo "$*"
    exit 77
}

# expect FILE REGEX: some line of FILE matches. reject FILE REGEX: none does.
expect() { grep -Eq -- "$2" "$1" || { cat "$1"; fail "$1 has no '$2'"; }; }
reject() { ! grep -Eq -- "$2" "$1" || { cat "$1"; fail "$1 has '$2'"; }; }

# value FILE KEY: the number after KEY= in the last line that has it.
value() { grep -oE "\b$2=[-+]?[0-9.]+" "$1" | tail -n 1 | cut -d= -f2; }

# check A OP B: a comparison of numbers, with fractions.
check() { awk "BEGIN { exit !($1 $2 $3) }" || fail "$1 $2 $3"; }

# end_by SIGNAL PROCESS: ends a child that still runs, by that signal and nothing else.
end_by() {
    local code=0
    kill -"$1" "$2"
    wait "$2" || code=$?
    check $code == $((128 + $(kill -l "$1")))
}

# in_background FILE COMMAND...: its output goes to FILE, where nothing of an earlier command is left
# when this returns. The process is $!.
in_background() {
    : >"$1"
    "${@:2}" >>"$1" &
}

# until_true SECONDS COMMAND...: waits for the command to succeed.
until_true() {
    local tries=$(($1 * 10))
    shift
    while ! "$@" >/dev/null 2>&1; do
        [ $((tries -= 1)) -gt 0 ] || fail "in time: $*"
        sleep 0.1
    done
}

# until_line SECONDS FILE REGEX: waits for a line that matches.
until_line() { (until_true "$1" grep -Eq -- "$3" "$2") || { cat "$2"; exit 1; }; }

# Milliseconds of CLOCK_MONOTONIC, to the next ten, as capture_probe prints them.
now_ms() { awk '{ print int($1 * 1000) }' /proc/uptime; }

# back_within_two_seconds MS: capture_probe, which writes the file `out`, has its first frame after
# that time no later.
back_within_two_seconds() {
    until_true 5 first_frame_after "$1"
    check "$(($(first_frame_after "$1") - $1))" '<' 2000
}
first_frame_after() {
    awk -v t="$1" '/first frame/ && $1 >= t { print $1; found = 1; exit } END { exit !found }' out
}

# load_vivid [OPTION...]: a camera at /dev/video0.
load_vivid() {
    modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0 "$@"
    udevadm settle
}

# plug_in PORT SERIAL [depth]: a USB camera, which plays $recording if that is set, or its depth; its
# faults are lines written to the file SERIAL.fifo.
plug_in() {
    modprobe -a vhci_hcd uvcvideo
    [ -p "$2.fifo" ] || mkfifo "$2.fifo"
    uvc_camera "$1" "$2" "$2.fifo" ${recording:+"$recording"} ${3:+"$3"} &
    until_true 20 test -e "$(by_id "$2")"
}
fault() { echo "$2" >"$1.fifo"; }
# faults SERIAL SECONDS LINE...: one after the other, so far apart.
faults() {
    local serial=$1 pause=$2
    for what in "${@:3}"; do
        fault "$serial" "$what"
        sleep "$pause"
    done
}
# The stable name of a camera's video node.
by_id() { echo "/dev/v4l/by-id/usb-Afterglow_Test_Camera_$1-video-index0"; }

# run_daemon [KEY=VALUE...]: afterglowd on a bus of its own, with colour from the camera $camera and
# depth from afterglow-testcam, which plays the recording `room`; the log is the file daemon.log.
# Frames are measured one in five unless a line for the configuration says otherwise.
run_daemon() {
    local fx fy cx cy width height rest
    read -r fx fy cx cy width height rest < <(grep -v '^#' room/camera.txt)
    cat >daemon.toml <<TOML
[color]
driver = "${color_driver:-v4l2}"
device = "$camera"
width = $width
height = $height
fx = $fx
fy = $fy
cx = $cx
cy = $cy
fps = ${fps:-5}
[tof]
driver = "openni2"
warmup_maps = 0
pairing_tolerance_ms = ${tolerance:-15}
pairing_wait_ms = 100
[illuminator]
driver = "openni2-emitter"
[gate]
mode = "interval"
interval_frames = 5
[daemon]
workers = 1
TOML
    start_daemon
}

# plug_in_testcam: the TOF camera of every program from now on.
plug_in_testcam() {
    export LD_LIBRARY_PATH=/vm/lib:/vm/lib/testcam
    export AFTERGLOW_TESTCAM_RECORDING=$PWD/room AFTERGLOW_TESTCAM_LOG=$PWD/emitter
    export AFTERGLOW_TESTCAM_COMMANDS=$PWD/testcam.fifo
    [ -p testcam.fifo ] || mkfifo testcam.fifo
}

# start_daemon: with the configuration daemon.toml.
start_daemon() {
    plug_in_testcam
    cat >bus.conf <<XML
<busconfig><type>session</type><listen>unix:path=$PWD/bus</listen><auth>EXTERNAL</auth>
<policy context="default"><allow send_destination="*" eavesdrop="true"/><allow eavesdrop="true"/>
<allow own="*"/></policy></busconfig>
XML
    bus=unix:path=$PWD/bus
    [ -S bus ] || dbus-daemon --config-file=bus.conf --fork
    afterglowd --bus "$bus" --config daemon.toml 2>daemon.log &
    daemon=$!
    (until_true 10 afterglowctl --bus "$bus" status) || { cat daemon.log; exit 1; }
}
state_is() { [ "$(statistic State)" = "$1" ]; }
statistic() { afterglowctl --bus "$bus" stats | awk -v name="$1" '$1 == name { print $2 }'; }

# back_within MS [SOURCE]: the next frame in frames.log (of that source, 1 = measured) is taken so
# soon from now. Told by the frames: to ask the daemon over and over would take the emulated
# processor's time.
back_within() {
    local begin
    begin=$(now_ms)
    until_true 20 frame_after "$begin" "${2:-}"
    echo "back after $(($(frame_after "$begin" "${2:-}") - begin)) ms"
    check "$(($(frame_after "$begin" "${2:-}") - begin))" '<=' "$1"
}
frame_after() {
    awk -v t="$1" -v source="$2" '$4 / 1e6 >= t && (!source || $2 == source) {
        print int($4 / 1e6); found = 1; exit } END { exit !found }' frames.log
}

# as_offline [OPTION...]: what watch_depth has read (frames.log, published/) is what afterglow-eval
# publishes for the same frames of a TOF camera that wakes as fast, pixel for pixel. A map of two
# cameras has its own time.
as_offline() {
    local latency delay_ms=none
    latency=$(awk '$2 == 1 { print NR - 1; exit }' frames.log)
    mkdir -p played
    cp -r room/rgb room/depth room/camera.txt played
    if [ -e room/calibration.toml ]; then
        cp room/calibration.toml played
        delay_ms=$(awk '$1 == "delay_ms" { print $3 }' room/calibration.toml)
    fi
    # The recording as it was seen: each frame when it was, by its number.
    grep -v '^#' room/associations.txt >lines
    awk -v delay_ms="$delay_ms" '
        function seconds(ns) { return sprintf("%d.%09d", int(ns / 1e9), ns % 1e9) }
        NR == FNR { color[NR - 1] = $2; depth[NR - 1] = $4; next }
        # The daemon takes maps of unmeasured images to be as late as the last measured one.
        delay_ms != "none" && $2 == 1 { late_ns = $6 - $4 - delay_ms * 1e6 }
        { map_ns = $4 + late_ns
          print seconds($4), color[$1], seconds(map_ns), depth[$1] }' lines frames.log \
        >played/associations.txt
    afterglow-eval run played --dump offline --wake-latency "$latency" --set gate.mode=interval \
        --set gate.interval_frames=5 "$@" >eval.log 2>&1 || { cat eval.log; fail "it is played"; }
    for map in published/*.png; do
        cmp "$map" "offline/$(basename "$map")" || { cat frames.log daemon.log; fail "as offline"; }
    done
}

# lit_as_told: the emitter of the OpenNI2 device was off whenever a frame says so.
lit_as_told() {
    awk 'NR == FNR { if ($2 == "on") from[++n] = $1; if ($2 == "off") to[n] = $1; next }
         $3 == 0 { for (i = 1; i <= n; ++i)
                       if ($4 >= from[i] && (!to[i] || $4 < to[i])) { print "lit:", $0; wrong = 1 } }
         $2 == 1 { ++measured }
         END { exit wrong || measured < 3 }' emitter frames.log ||
        { cat emitter frames.log; fail "the emitter is off when frames say so"; }
}
