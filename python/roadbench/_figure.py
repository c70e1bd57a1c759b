"""A figure that notebooks show without pyplot; needs matplotlib."""

import io

from matplotlib.figure import Figure


class SessionFigure(Figure):
    """What :func:`roadbench.plot` draws where it is given no figure."""

    def _repr_png_(self) -> bytes:
        png = io.BytesIO()
        self.savefig(png, format="png")
        return png.getvalue()
