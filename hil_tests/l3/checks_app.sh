#!/bin/sh
# Runs inside the guest of level L3: a session with the whole app.
exec "${HIL:-build/hil}/app_check"
