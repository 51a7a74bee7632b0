# Sourced after program.sh: it starts a virtual display for this test alone, in DISPLAY until the end. The
# server chooses its own number, so that parallel tests never share one. It does not restart when its last
# window closes (-noreset): a window that opens in that moment would find no display. (Start a program that
# must receive Ctrl-C as `env --default-signal=INT PROGRAM &`: the shell makes programs started with & ignore
# it.)
exec {display_number}< <(exec Xvfb -displayfd 1 -screen 0 1280x1024x24 -nolisten tcp -noreset 2>"$work/display")
display_server=$!
trap 'kill "$display_server" 2>/dev/null; rm -rf "$work"' EXIT
if ! read -r -t 30 -u "$display_number" DISPLAY; then
    cat "$work/display" >&2
    echo "Bail out! Xvfb did not start"
    exit 1
fi
export DISPLAY=":$DISPLAY"

# A test that acts like a person waits for what the program has done, never for the clock, because a machine
# may be slow for seconds. The function waits until $2 more pieces of 500 ticks are in a window's recording
# $1; the unfinished piece counts. By then the window receives keys, and a key that is down through N pieces
# is held for more than 500 (N - 1) ticks. All other parts of the recording are smaller.
recorded() { cat "$1".part* "$1" 2>/dev/null | wc -c; }
ticks_pass() {
    local until patience=2000 # 100 s
    for _ in $(seq "$2"); do
        until=$(($(recorded "$1") + 10000))
        while [ "$(recorded "$1")" -lt "$until" ]; do
            patience=$((patience - 1))
            [ $patience -gt 0 ] || return 1
            sleep 0.05
        done
    done
}
# A tool that talks to the display gets an answer within seconds, or it asks again: a server that is busy must not end
# the test.
keys() { timeout 10 xdotool "$@" >/dev/null 2>&1 || timeout 10 xdotool "$@"; }
# The window has the keyboard: it is on the screen, and the server says that keys go to it. Before that, keys go
# nowhere.
focus() {
    local id
    for _ in $(seq 600); do # 30 s
        id=$(timeout 10 xdotool search --onlyvisible --name Cournand 2>/dev/null | tail -n 1)
        if [ -n "$id" ] && timeout 10 xdotool windowfocus "$id" 2>/dev/null &&
            [ "$(timeout 10 xdotool getwindowfocus 2>/dev/null)" = "$id" ]; then return 0; fi
        sleep 0.05
    done
    return 1
}
# What every process of this display waits for, when a test has waited in vain: `keys.sh` failed || stuck.
stuck() {
    local status
    for status in /proc/[0-9]*/status; do
        grep -zq "DISPLAY=$DISPLAY" "${status%/status}/environ" 2>/dev/null || continue
        echo "$(tr '\0' ' ' <"${status%/status}/cmdline" | cut -c1-60): $(sed -n 's/^State:\t//p' "$status")," \
            "$(cat "${status%/status}/wchan" 2>/dev/null)," \
            "call $(cut -d' ' -f1 "${status%/status}/syscall" 2>/dev/null)"
    done
}
export -f recorded ticks_pass keys focus stuck
