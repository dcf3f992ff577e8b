"""Sliders in a notebook. Needs ipywidgets: ``pip install "illuminator[widgets]"``."""

from __future__ import annotations

from typing import Any, Iterable, Optional

from . import Parameter, Session


def sliders(session: Session, names: Optional[Iterable[str]] = None) -> Any:
    """The picture of a session with a slider for each value of these names.

    By default there is one for each number that the author of the formula marked as a slider. The picture follows the
    sliders.
    """
    import ipywidgets  # type: ignore[import-untyped]

    if isinstance(names, str):
        names = [names]
    names = _marked(session) if names is None else list(names)
    image = ipywidgets.Image(value=session._repr_png_(), format="png")
    rows = [_slider(ipywidgets, session, name) for name in names]
    show = _Show(session, image, rows)
    for row in rows:
        row.observe(show.moved, "value")
    return ipywidgets.HBox([image, ipywidgets.VBox(rows)])


def _marked(session: Session) -> list[str]:
    marked = {parameter.name for parameter in session.formula.parameters if parameter.slider and _has_slider(parameter)}
    return [name for name in session.values if name.split(".")[-1] in marked]


def _has_slider(parameter: Parameter) -> bool:
    return parameter.type == "scalar" and parameter.range is not None and not parameter.choices and not parameter.switch


def _slider(ipywidgets: Any, session: Session, name: str) -> Any:
    own = next((own for own in session.formula.parameters if own.name == name.split(".")[-1]), None)
    if own is None or own.range is None or not _has_slider(own):
        raise ValueError(f"`{name}` is not a number with a range, so it has no slider")
    low, high = own.range
    return ipywidgets.FloatSlider(session[name], min=low, max=high, step=(high - low) / 200, description=name)


class _Show:
    """Draws the picture when a slider moves. Values that follow from others move their sliders."""

    def __init__(self, session: Session, image: Any, rows: list[Any]) -> None:
        self.session, self.image, self.rows = session, image, rows
        self.busy = False

    def moved(self, change: Any) -> None:
        if self.busy:
            return
        self.busy = True
        try:
            self.session.move(change["owner"].description, change["new"])
            self.image.value = self.session._repr_png_()
            for row in self.rows:
                row.value = self.session[row.description]
        finally:
            self.busy = False
