#!/bin/sh
# Renders every case by the reference renderer. Takes some minutes. Needs Python 3, and for the cases with meshes, textures and maps
# `pip install numpy trimesh embreex pillow OpenEXR`; PYTHON may name another Python, such as that of a virtual environment.
# For cases/NAME: pictures/NAME.pfm (linear floats) and pictures/NAME.mask (255 where the picture is stable under a shift of a hundredth
# of a pixel). For sampled/NAME, with noise: pictures/sampled/NAME.pfm, the limit of many passes by a grid of 8 x 8 rays for each pixel,
# each with 4 x 4 points of lights, and NAME.deviation.pfm, the standard deviation of one pass.
cd "$(dirname "$0")" || exit 1
set -f
render() { # FOLDER/NAME, options
    case=$1
    shift
    "${PYTHON:-python3}" reference.py --formula "$case.formula" --scene "$case.scene" $(cat "$case.args") "$@" || exit 1
}
for formula in $(set +f; echo cases/*.formula); do
    name=$(basename "$formula" .formula)
    render "cases/$name" --size 64x48 -o "pictures/$name.pfm" --stable "pictures/$name.mask"
done
for formula in $(set +f; echo sampled/*.formula); do
    name=$(basename "$formula" .formula)
    render "sampled/$name" --size 32x24 --samples 8 --points 4 -o "pictures/sampled/$name.pfm" --deviation "pictures/sampled/$name.deviation.pfm"
done
