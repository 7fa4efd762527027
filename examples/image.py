#!/usr/bin/python3
"""A glTF scene to an image, and its pixels as arrays: image.py SCENE.glb OUT.exr|OUT.png"""
import sys

import sheen

if len(sys.argv) != 3:
    sys.exit(__doc__)
frame = sheen.render(sys.argv[1], width=96, height=96, accuracy=1.0)
frame.write(sys.argv[2])
beauty = frame["beauty"]  # numpy, [row][column][R, G, B], nits
print(f"brightest {beauty.max():.3g} nits; error about {100 * frame.figures['estimated_rel_rmse']:.1f}%")
