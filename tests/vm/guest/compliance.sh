# SPDX-License-Identifier: Apache-2.0
# Our calls are legal: drivers refuse none of them. And they leave a device as it was:
# `v4l2-compliance -s` finds the same with a device that we have streamed from as with one that nobody
# has, also after a reader was killed. Both are in the same format: what v4l2-compliance finds depends
# on it, since it knows vivid's list of formats only to the first whose name it does not like.
. /vm/guest/rig.bash

# verdict FILE [OPTION...]: the failures that v4l2-compliance finds, and the count of its tests.
verdict() {
    local file=$1 code=0
    shift
    v4l2-compliance "$@" >"$file.all" 2>&1 || code=$?
    [ $code -le 1 ] || { tail "$file.all"; fail "v4l2-compliance ended with $code"; } # 1: failures
    grep -E 'fail: |: FAIL|^Total ' "$file.all" | sed 's/ for [^,]* device [^:]*//' >"$file"
    grep -q '^Total' "$file" || { tail "$file.all"; fail "v4l2-compliance has ended"; }
}
# same_after DEVICE WIDTH HEIGHT FPS
same_after() {
    v4l2-ctl -d "$1" --set-fmt-video=width="$2",height="$3",pixelformat=GREY
    verdict untouched -d "$1" -s5
    cat untouched
    for end in normal killed; do
        capture_probe device="$1" width="$2" height="$3" fps="$4" format=GREY frames=20 >out
        if [ $end = killed ]; then
            in_background out capture_probe device="$1" width="$2" height="$3" \
                fps="$4" format=GREY seconds=60
            until_line 10 out 'first frame'
            end_by KILL $!
        fi
        verdict used -d "$1" -s5
        diff untouched used || fail "the same for $1 ($end)"
    done
}

# only_questions FILE: the driver refused the end of its formats (2), and nothing else but other
# enumerations' ends (sizes 74, intervals 75, controls 103) and controls that it does not have (28),
# all with EINVAL.
only_questions() {
    expect "$1" 'frames=20 '
    expect "$1" 'refused: ioctl 2: EINVAL$'
    grep refused "$1"
    ! grep refused "$1" | grep -vE 'ioctl (2|28|74|75|103): EINVAL$' || fail "only legal calls"
}

echo "-- vivid"
load_vivid
capture_probe device=/dev/video0 width=640 height=360 fps=25 frames=20 calls=1 >calls
only_questions calls
same_after /dev/video0 640 360 25
modprobe -r vivid
echo "-- uvcvideo"
plug_in 0 cam
capture_probe device="$(by_id cam)" frames=20 calls=1 >calls
only_questions calls
same_after "$(readlink -f "$(by_id cam)")" 320 240 30
