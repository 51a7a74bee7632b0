# Sourced after program.sh: a virtual display for this test alone, in DISPLAY until the end. The server chooses its own number, so that
# tests beside each other never meet, and does not start over when its last window closes (-noreset): a window that opens in that
# moment would find no display. (A program that is to hear Ctrl-C is started as `env --default-signal=INT PROGRAM &`: the shell lets
# what it starts with & ignore it.)
exec {display_number}< <(exec Xvfb -displayfd 1 -screen 0 1280x1024x24 -nolisten tcp -noreset 2>"$work/display")
display_server=$!
trap 'kill "$display_server" 2>/dev/null; rm -rf "$work"' EXIT
if ! read -r -t 30 -u "$display_number" DISPLAY; then
    cat "$work/display" >&2
    echo "Bail out! Xvfb did not start"
    exit 1
fi
export DISPLAY=":$DISPLAY"
