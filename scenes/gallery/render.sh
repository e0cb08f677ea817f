#!/bin/sh
# Makes the pictures of this folder again: scenes/gallery/render.sh [path of glimt]
# The program renders; gallery.py and terminal.py (Python with Pillow) only make the files small, put the sheet together
# and draw the captured screen.
set -eu
cd "$(dirname "$0")/.."
glimt=${1:-../target/release/glimt}
python=${PYTHON:-python3}
raw=$(mktemp -d)
trap 'rm -rf "$raw"' EXIT

for scene in demo whitted refraction mesh sphereflake lighting/media lighting/falloff lighting/depth; do
    name=$(basename "$scene")
    "$glimt" render "$scene.toml" -o "$raw/$name.png" --size 640x360 --samples 32
    "$python" gallery/gallery.py small "$raw/$name.png" "gallery/$name.png"
done

for scene in shapes/*.toml lighting/*.toml; do
    "$glimt" render "$scene" -o "$raw/$(basename "$scene" .toml).png" --size 480x270 --samples 16 --quiet
done
"$python" gallery/gallery.py sheet gallery/sheet.png \
    $(for scene in shapes/*.toml lighting/*.toml; do echo "$raw/$(basename "$scene" .toml).png"; done)

# The interface itself, some seconds into the demo, on a terminal of 120 x 36 cells.
if command -v tmux > /dev/null; then
    screen="tmux -L glimt-gallery"
    here=$(pwd)
    $screen -f /dev/null new-session -d -x 120 -y 36 -s screen -c "$raw" \
        "COLORTERM=truecolor '$(realpath "$glimt")' '$here/demo.toml'"
    sleep 4
    $screen capture-pane -e -p -N -t screen > "$raw/screen.txt"
    $screen kill-server
    "$python" gallery/terminal.py "$raw/screen.txt" gallery/tui.png 120 36
fi
