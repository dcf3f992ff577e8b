#!/usr/bin/env bash
# Takes the pictures of the README anew. Needs a release build, and: apt-get install xvfb xdotool imagemagick
set -euo pipefail
cd "$(dirname "$0")/../.."
program=$PWD/target/release/illuminator
images=$PWD/docs/images
"$program" render -o "$images/default.png"

export DISPLAY=:97
Xvfb $DISPLAY -screen 0 1280x800x24 -noreset >/dev/null 2>&1 &
display=$!
trap 'kill $display; rm -rf "$home"' EXIT
home=$(mktemp -d)
sleep 1

# take NAME SESSION COMMAND…: opens the session, runs the commands of xdotool, and takes a screenshot.
take() {
    local name=$1 session=$2
    shift 2
    # Settings and drafts of the user, and those of the last picture, stay out of it.
    local own=$home/$name
    export HOME=$own XDG_CONFIG_HOME=$own/config XDG_DATA_HOME=$own/data XDG_STATE_HOME=$own/state
    mkdir -p "$XDG_CONFIG_HOME/illuminator"
    printf 'version = 1\n[window]\ntheme = "dark"\nscale = 1.0\nsize = [1280, 800]\n' \
        > "$XDG_CONFIG_HOME/illuminator/settings.toml"
    "$program" preview "$session" >/dev/null 2>&1 &
    local window=$!
    sleep 6
    for command in "$@"; do
        # shellcheck disable=SC2086
        xdotool $command
        sleep 0.7
    done
    sleep 2
    import -window root "$images/$name.png"
    kill $window
    wait $window || true
}

take window preset:default "mousemove 690 360 click 1" "mousemove 690 120"
take window-error preset:studio "mousemove 300 336 click 1" "key End" "key BackSpace" "type  + ks;" "key ctrl+Return" \
    "mousemove 690 120"
take window-inspector preset:glass "key F5" "sleep 1" "mousemove 690 260 click 1" "mousemove 690 120"
