"""Illumination models typed as mathematics, with ray-traced pictures as NumPy arrays.

>>> import illuminator
>>> session = illuminator.Session("preset:studio", size=(320, 240))
>>> session["ball.kd"] = 0.3
>>> picture = session.render()          # float32, height x width x 3, linear RGB
"""

from ._illuminator import (
    Diagnostic,
    Drag,
    Formula,
    IlluminatorError,
    IlluminatorWarning,
    Parameter,
    Place,
    Scene,
    Session,
    Sweep,
    TextError,
    __version__,
    check,
    presets,
)

__all__ = [
    "Diagnostic",
    "Drag",
    "Formula",
    "IlluminatorError",
    "IlluminatorWarning",
    "Parameter",
    "Place",
    "Scene",
    "Session",
    "Sweep",
    "TextError",
    "__version__",
    "check",
    "presets",
]
