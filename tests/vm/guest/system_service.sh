# SPDX-License-Identifier: Apache-2.0
# What packages install, on a system: systemd's own unit, the system bus, users and their groups.
# limit: 900
. /vm/guest/rig.bash
export PATH=/usr/bin:/usr/sbin:/vm/bin
trap '[ $? -eq 0 ] || journalctl -q -u afterglowd -o short-monotonic -n 30' EXIT

config=/etc/afterglow/afterglowd.toml
depth1=(org.afterglow.Depth1 /org/afterglow/Depth1 org.afterglow.Depth1)

# as USER COMMAND...
as() { setpriv --reuid="$1" --regid="$1" --init-groups env HOME=/ "${@:2}"; }

property() { busctl get-property "${depth1[@]}" "$1" | cut -d' ' -f2-; }
property_is() { [ "$(property "$1")" = "$2" ]; }
name_is_owned() { busctl status org.afterglow.Depth1; }
main_pid() { systemctl show -P MainPID afterglowd; }

# refused ERROR REGEX USER COMMAND...: a call of busctl by that user fails with that D-Bus error, and
# a message that matches.
refused() {
    ! as "$3" env SYSTEMD_LOG_LEVEL=debug busctl "${@:4}" >answer 2>&1 || fail "refused to ${*:3}"
    expect answer "error-name=$1 .*error-message=.*$2"
}

# mark, logged REGEX: what the daemon has said since.
mark() {
    marked=$(now_ms)
    cursor=$(journalctl -q -n 1 --show-cursor | sed -n 's/^-- cursor: //p')
}
logged() { journalctl -q -u afterglowd -o cat --after-cursor "$cursor" | grep -E "$1"; }

# frame_after MS [FILE]: when the first frame came after that time.
frame_after() {
    awk -v t="$1" '$1 > t && $2 == "frame" { print $1; found = 1; exit } END { exit !found }' \
        "${2:-frames.log}"
}
# goes_on: frames come.
goes_on() { (until_true 5 frame_after "$(now_ms)") || { tail -n 5 frames.log; exit 1; }; }
# comes_back [MS]: the daemon has ended since the mark, and within two seconds of that, or so long,
# the stream is one of the next daemon and gives frames.
comes_back() {
    until_true 20 awk -v t="$marked" '$1 > t && $2 == "reconnected" { back = 1 }
        back && $2 == "frame" { found = 1 } END { exit !found }' frames.log
    awk -v t="$marked" -v most="${1:-2000}" '$1 > t && $2 == "away" && !gone { gone = $1 }
        $1 > t && $2 == "frame" && back { print "back after", $1 - gone, "ms"
                                          exit !gone || $1 - gone >= most }
        $1 > t && $2 == "reconnected" { back = 1 }' frames.log ||
        { grep -v ' frame ' frames.log; fail "back in time"; }
}
# without_gap: between two openings every frame has been read.
without_gap() {
    awk '$2 == "open" || $2 == "reconnected" { last = "" }
         $2 == "frame" { if (last != "" && $3 != last + 1) { print "before:", $0; gap = 1 }
                         last = $3 }
         END { exit gap }' frames.log || fail "no frame is missed"
}

# recorded_room [LINE...]: the configuration. A recording, because to make up the synthetic room takes
# the emulated processor a second at each start.
recorded_room() {
    cat >$config <<TOML
color.driver = "replay"
tof.driver = "replay"
illuminator.driver = "replay"
[replay]
path = "/var/lib/room"
loop = true
[daemon]
workers = 1
$(printf '%s\n' "$@")
TOML
}

echo "-- installed, and not yet running"
cp -a /vm/installed/. /
cat >accounts <<'END'
u outsider -
u reader -
m reader afterglow-readers
u viewer -
m viewer afterglow-readers
m viewer afterglow-images
u controller -
m controller afterglow
END
systemd-sysusers
systemd-sysusers "$PWD/accounts"
record_room /var/lib/room 20 100 160 120
recorded_room
systemctl daemon-reload
systemctl reload dbus
! systemctl -q is-active afterglowd || fail "it runs before anybody wants it"

echo "-- the first reader starts it"
mark
in_background frames.log as reader follow_stream
until_line 20 frames.log ' frame '
systemctl -q is-active afterglowd || fail "it is active"
check "$(ps -o euid= -p "$(main_pid)")" == "$(id -u afterglow)"
! journalctl -q -u afterglowd -p warning | grep . || fail "a start without warnings"

echo "-- introspection is what is installed"
members() {
    sed -n '/<interface name="org.afterglow.Depth1">/,/<\/interface>/p' |
        grep -oE '<(interface|method|signal|property|arg|annotation)[^>]*>' | sed 's,/>,>,'
}
members </usr/share/dbus-1/interfaces/org.afterglow.Depth1.xml >installed.xml
busctl introspect --xml-interface org.afterglow.Depth1 /org/afterglow/Depth1 | members >running.xml
grep -q OpenStream installed.xml
diff installed.xml running.xml || fail "the same interface"

echo "-- its exposure"
systemd-analyze security --no-pager afterglowd >exposure
tail -n 1 exposure
check "$(tail -n 1 exposure | grep -oE '[0-9]+\.[0-9]+')" '<=' 1.5

echo "-- who may do what"
denied=org.freedesktop.DBus.Error.AccessDenied
open=(call "${depth1[@]}" OpenStream 'a{sv}')
refused $denied afterglow-readers outsider "${open[@]}" 0
refused $denied afterglow-images reader "${open[@]}" 1 images b true
refused $denied afterglow-images controller "${open[@]}" 1 images b true
refused org.freedesktop.DBus.Error.InvalidArgs pictures viewer "${open[@]}" 1 pictures b true
for user in reader controller root; do
    as $user busctl "${open[@]}" 0 >/dev/null
done
for user in viewer root; do
    as $user busctl "${open[@]}" 1 images b true >/dev/null
done
for user in outsider reader viewer; do
    refused $denied '' $user set-property "${depth1[@]}" Mode s off
    refused $denied '' $user call "${depth1[@]}" Measure
    refused $denied '' $user call "${depth1[@]}" RequestAccuracy dus 1 0 test
    refused $denied '' $user call "${depth1[@]}" HoldMode ss off test
    for method in SavePolicy Reload ResetStatistics; do
        refused $denied '' $user call "${depth1[@]}" $method
    done
    refused $denied '' $user set-property org.afterglow.Depth1 /org/freedesktop/LogControl1 \
        org.freedesktop.LogControl1 LogLevel s debug
    as $user busctl get-property "${depth1[@]}" Mode >/dev/null
    as $user busctl call "${depth1[@]}" ListRequests >/dev/null
done
as controller busctl set-property "${depth1[@]}" Mode s always-on
property_is Mode '"always-on"'
as controller busctl call "${depth1[@]}" Measure >/dev/null
as controller busctl set-property "${depth1[@]}" Mode s auto
refused org.afterglow.Error.OutOfRange '100' controller set-property "${depth1[@]}" TargetError d 1000
refused org.freedesktop.DBus.Error.InvalidArgs '' controller set-property "${depth1[@]}" Mode s bright
as controller busctl set-property org.afterglow.Depth1 /org/freedesktop/LogControl1 \
    org.freedesktop.LogControl1 LogLevel s info

echo "-- polkit may allow what groups do not"
cat >/etc/polkit-1/rules.d/50-test.rules <<'END'
polkit.addRule(function(action, subject) {
    if (action.id == "org.afterglow.depth1.read-depth" && subject.user == "outsider")
        return polkit.Result.YES;
});
END
systemctl start polkit
as outsider busctl "${open[@]}" 0 >/dev/null
refused $denied '' outsider "${open[@]}" 1 images b true
refused $denied '' outsider set-property "${depth1[@]}" Mode s off
systemctl stop polkit

echo "-- reload"
pid=$(main_pid)
recorded_room '[gate]' 'target_mre = 3.5'
systemctl reload afterglowd
until_true 5 property_is TargetError 3.5
mark
recorded_room '[gate]' 'target_mre = -1'
! systemctl reload afterglowd || fail "reloads a wrong configuration"
until_true 5 logged 'target_mre'
property_is TargetError 3.5
check "$(main_pid)" == "$pid"
goes_on
without_gap

echo "-- a right that is taken away"
recorded_room '[access]' 'image_group = "afterglow"'
in_background images.log as viewer follow_stream images
until_true 10 frame_after 0 images.log
systemctl reload afterglowd
until_line 5 images.log ' end EACCES'
goes_on
recorded_room

echo "-- policy that is saved outlives a restart"
as controller busctl set-property "${depth1[@]}" TargetError d 4.25
as controller busctl call "${depth1[@]}" SavePolicy >saved
expect saved /var/lib/afterglow/policy.toml
mark
systemctl restart afterglowd
comes_back
property_is TargetError 4.25
rm /var/lib/afterglow/policy.toml

echo "-- killed"
mark
systemctl kill -s KILL afterglowd
comes_back

echo "-- stopped: the watchdog ends it"
mark
kill -STOP "$(main_pid)"
until_true 30 logged 'Watchdog timeout'
comes_back

echo "-- the bus dies"
pid=$(main_pid)
begin=$(now_ms)
systemctl kill -s KILL dbus
goes_on
until_true 10 name_is_owned
goes_on
awk -v t="$begin" '$1 > t && $2 != "frame" { print; bad = 1 } END { exit bad }' frames.log ||
    fail "the stream goes on"
check "$(main_pid)" == "$pid"
as reader busctl "${open[@]}" 0 >/dev/null
without_gap

echo "-- a wrong configuration waits for a person"
pkill -x follow_stream # who would have the bus start it again
echo 'nonsense = 1' >>$config
! systemctl restart afterglowd || fail "it starts with a wrong configuration"
check "$(systemctl show -P ExecMainStatus afterglowd)" == 78
sleep 3
check "$(systemctl show -P NRestarts afterglowd)" == 0
systemctl reset-failed afterglowd

echo "-- a light is dark at once, however the daemon ends"
load_vivid
lit() { v4l2-ctl -C boolean | grep -q 'boolean: 1'; }
dark() { ! lit; }
cat >$config <<'TOML'
[color]
driver = "replay"
[replay]
path = "/var/lib/room"
in_step = true
loop = true
[tof]
driver = "openni2"
warmup_maps = 0
pairing_tolerance_ms = 40
[illuminator]
driver = "v4l2-control"
device = "/dev/video0"
control = "boolean"
[gate]
mode = "always-on"
[daemon]
workers = 1
TOML
mkdir -p /etc/systemd/system/afterglowd.service.d
cat >/etc/systemd/system/afterglowd.service.d/testcam.conf <<'END'
[Service]
Environment=LD_LIBRARY_PATH=/usr/lib/afterglow/testcam AFTERGLOW_TESTCAM_RECORDING=/var/lib/room
END
systemctl daemon-reload
in_background frames.log as reader follow_stream
until_line 20 frames.log ' frame '
until_true 5 lit
mark
systemctl kill -s KILL afterglowd
until_true 1 dark
echo "dark after $(($(now_ms) - marked)) ms at most"
comes_back 6000 # OpenNI2 takes its time to start in this machine
until_true 5 lit

# hang_threads: of the daemon's threads only the main one goes on.
hang_threads() {
    local group pid thread
    pid=$(main_pid)
    group=/sys/fs/cgroup$(systemctl show -P ControlGroup afterglowd)/hung
    mkdir "$group"
    echo threaded >"$group/cgroup.type"
    for thread in /proc/"$pid"/task/*; do
        [ "${thread##*/}" = "$pid" ] || echo "${thread##*/}" >"$group/cgroup.threads"
    done
    echo 1 >"$group/cgroup.freeze"
}
mark
hang_threads
until_true 30 logged 'Watchdog timeout'
until_true 1 dark
comes_back 6000
systemctl stop afterglowd
sleep 3
! systemctl -q is-active afterglowd || fail "a reader that waits leaves a stopped daemon alone"
dark || fail "dark in the end"
