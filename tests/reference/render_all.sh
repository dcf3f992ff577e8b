#!/bin/sh
# Renders every case by the reference renderer: pictures/NAME.pfm (linear floats) and pictures/NAME.mask (255 where the picture is
# stable under a shift of a hundredth of a pixel). Takes about half a minute; needs Python 3 and nothing else.
cd "$(dirname "$0")" || exit 1
set -f
for formula in $(set +f; echo cases/*.formula); do
    name=$(basename "$formula" .formula)
    python3 reference.py --formula "$formula" --scene "cases/$name.scene" --size 64x48 $(cat "cases/$name.args") \
        -o "pictures/$name.pfm" --stable "pictures/$name.mask" || exit 1
done
