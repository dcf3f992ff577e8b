#!/bin/sh
# Renders every case by the reference renderer: pictures/NAME.pfm (linear floats) and pictures/NAME.mask (255 where the picture is
# stable under a shift of a hundredth of a pixel). Takes about a minute. Needs Python 3, and for the cases with meshes and textures
# `pip install numpy trimesh embreex pillow OpenEXR`; PYTHON may name another Python, such as that of a virtual environment.
cd "$(dirname "$0")" || exit 1
set -f
for formula in $(set +f; echo cases/*.formula); do
    name=$(basename "$formula" .formula)
    "${PYTHON:-python3}" reference.py --formula "$formula" --scene "cases/$name.scene" --size 64x48 $(cat "cases/$name.args") \
        -o "pictures/$name.pfm" --stable "pictures/$name.mask" || exit 1
done
