#!/usr/bin/env bash
# Takes the pictures of the manual and the README again, but for the gallery, which `tests/program/manual.rs` makes.
# Needs a release build, and: apt-get install xvfb xdotool imagemagick
# ILLUMINATOR names another program than that of the release build. Names of pictures as arguments take only these.
set -euo pipefail
cd "$(dirname "$0")/../.."
program=${ILLUMINATOR:-$PWD/target/release/illuminator}
images=$PWD/docs/manual/src/images
only=("$@")

wanted() {
    [ ${#only[@]} -eq 0 ] || [[ " ${only[*]} " == *" $1 "* ]]
}

# picture NAME ARGUMENTS…: a picture in the chapter about the first model or scenes.
picture() {
    local name=$1
    shift
    wanted "$name" || return 0
    "$program" render "$@" --size 400x225 --samples "${passes:-16}" -o "$images/$name.png"
}

home=$(mktemp -d)
trap 'rm -rf "$home"' EXIT
if wanted default; then "$program" render -o "$images/default.png"; fi

# block CHAPTER KIND N: the text of the Nth block of a kind. Formulas and scenes of pictures are those of the chapters.
block() {
    awk -v fence="^\`\`\`$2" -v number="$3" '$0 ~ fence {n++; inside = n == number; next} /^```/ {inside = 0} inside' \
        "docs/manual/src/$1.md"
}
block first-model formula 1 > "$home/matte.formula"
block first-model formula 2 > "$home/gloss.formula"
block scenes scene 1 > "$home/first.scene"
block scenes scene 5 > "$home/lamps.scene"
block ray-weights formula 1 > "$home/fresnel.formula"
block ray-weights formula 3 > "$home/lamp.formula"
picture first-matte preset:studio --formula "$home/matte.formula"
picture first-gloss preset:studio --formula "$home/gloss.formula"
picture first-values preset:studio --formula "$home/gloss.formula" --set '*.gloss=8' --set ball.Cd='<0.05, 0.15, 0.6>'
picture first-mirror preset:studio --formula "$home/gloss.formula" --set ball.kr=0.6
picture weights-fresnel preset:glass --formula "$home/fresnel.formula" --set glass.kr=1 --set glass.kt=1 \
    --set bubble.kr=1 --set bubble.kt=1 --set pane.kr=1 --set pane.kt=1
picture weights-lamp preset:studio --formula "$home/lamp.formula" --set ball.glow='<0.9, 0.5, 0.1>'
picture first-scene --scene "$home/first.scene" --formula preset:phong --background '#405a80' \
    --set 'ball.Cd=<0.8,0.1,0.05>' --set 'glass.Cd=<0,0,0>' --set glass.kr=0.1 --set glass.kt=0.9 --srgb
passes=128 picture scene-lights --scene "$home/lamps.scene" --formula preset:phong --set ka=0.02 --set sun.ki=0.25 \
    --set 'sun.IL=<1,0.95,0.85>' --set beam.ki=0.6 --set bulb.ki=0.3 --set 'bulb.IL=<1,0.75,0.45>' --set window.ki=0.3 \
    --set 'window.IL=<0.5,0.75,1>' --set 'ball.Cd=<0.8,0.15,0.1>' --srgb

# chart NAME ARGUMENTS…: a chart in the chapter about instruments.
chart() {
    local name=$1
    shift
    wanted "$name" || return 0
    "$program" plot "$@" -o "$images/$name.svg"
}
chart instruments-polar --formula preset:ggx --view polar --theta 0,30,60 --size 640x420
chart instruments-albedo --formula preset:phong --view albedo --size 640x400

export DISPLAY=:${SCREEN:-97}
Xvfb "$DISPLAY" -screen 0 1280x800x24 -noreset >/dev/null 2>&1 &
display=$!
trap 'kill $display; rm -rf "$home"' EXIT
sleep 1

# take NAME SESSION COMMAND…: opens the session, runs the commands of xdotool, and takes a screenshot. Without a session
# the gallery opens.
take() {
    local name=$1 session=$2
    shift 2
    wanted "$name" || return 0
    # Settings and drafts of the user, and those of the last picture, stay out of it.
    export ILLUMINATOR_HOME=$home/$name
    mkdir -p "$ILLUMINATOR_HOME/configuration"
    printf 'version = 1\n[window]\ntheme = "dark"\nscale = 1.0\nsize = [1280, 800]\n' \
        > "$ILLUMINATOR_HOME/configuration/settings.toml"
    # shellcheck disable=SC2086
    "$program" preview $session >/dev/null 2>&1 &
    local window=$!
    sleep "${WAIT:-12}"
    for command in "$@"; do
        # shellcheck disable=SC2086
        xdotool $command
        sleep 0.7
    done
    sleep 2
    # 256 colours, so that all images of the manual together stay small.
    import -window root -dither FloydSteinberg -colors 256 "PNG8:$images/$name.png"
    kill $window
    wait $window || true
}

take window preset:default "mousemove 690 360 click 1" "mousemove 690 120"
take window-error preset:studio "mousemove 300 336 click 1" "key End" "key BackSpace" "type  + ks;" "key ctrl+Return" \
    "mousemove 690 120"
take window-inspector preset:glass "key F5" "sleep 1" "mousemove 690 260 click 1" "mousemove 690 120"
take window-gallery "" "sleep 30" "mousemove 20 790"
# The ball is selected, and its list of materials opened.
ball="mousemove 1016 249 click 1"
list="mousemove 1012 311 click 1"
take window-materials preset:studio "$ball" "$list"
take window-compare preset:studio "$ball" "mousemove 214 13 click 1" "mousemove 240 44 click 1" "$list" \
    "mousemove 1010 477 click 1" "sleep 1" "mousemove 214 13 click 1" "mousemove 240 276 click 1" \
    "mousemove 680 500 mousedown 1" "mousemove 650 500" "mousemove 622 500" "mouseup 1" "mousemove 690 650"
take window-log preset:studio "$ball" "key F11" "key F12" "mousemove 1135 557 mousedown 1" "mousemove 1120 557" \
    "mousemove 1100 557" "mousemove 1140 557" "mouseup 1" "mousemove 690 60"
take window-settings preset:studio "mousemove 20 13 click 1" "mousemove 60 551 click 1" "mousemove 690 780"
# A box that is being rotated by its green ring.
cat > "$home/handles.scene" <<'SCENE'
bodies;
 floor: rectangle, <-8, 0, -8>, <8, 0, -8>, <8, 0, 8>;
 crate: box, <-1.9, 0, -0.6>, <-0.5, 1.4, 0.8>;
 gem: mesh, "preset:gem", fit <0.9, 0.8, 0> 1.6;
 pin: cone, <2.3, 0, 1>, <2.3, 1.2, 1>, radius 0.4;
lights;
 key: point, <4, 6, 5>;
camera;
 position <0, 2.6, 7>; gaze <0, -0.27, -1>; up <0, 1, 0>; fov 36;
SCENE
cat > "$home/handles.toml" <<'SESSION'
version = 1
formula = "preset:phong"
scene = "handles.scene"
size = [1280, 800]
srgb = true
[global]
ka = 0.05
Ia = [0.448, 0.692, 1.0]
background = [0.014, 0.02, 0.032]
[bodies.floor]
Cd = [0.3, 0.33, 0.4]
ks = 0.0
[bodies.crate]
Cd = [0.8, 0.2, 0.05]
[bodies.gem]
Cd = [0.05, 0.4, 0.5]
[bodies.pin]
Cd = [0.6, 0.5, 0.1]
SESSION
take window-handles "$home/handles.toml" "mousemove 160 40 click 1" "mousemove 580 420 click 1" "key e" \
    "mousemove 580 408 mousedown 1" "mousemove 600 409" "mousemove 640 409" "sleep 1"
