"""Labels of ticks as plain text: matplotlib's own mathematical ones take most of a figure's time."""

import re

from matplotlib.ticker import LogFormatterSciNotation, ScalarFormatter

RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def plain(label: str) -> str:
    r"""A label without marks of mathematics: "$\mathdefault{2\times10^{-3}}$" -> "2×10⁻³", "1e−5" -> "×10⁻⁵"."""
    label = label.replace(r"\times", "×").replace(r"\mathdefault", "")
    label = re.sub(r"10\^\{([-−]?\d+)\}", lambda found: "10" + found[1].translate(RAISED), label)
    label = re.sub(r"^1e([-−]?)\+?(\d+)$", lambda found: "×10" + (found[1] + found[2]).translate(RAISED), label)
    return re.sub(r"[${}\\]", "", label)


class PlainScalar(ScalarFormatter):
    """Numbers with one power of ten for all."""

    def get_offset(self) -> str:
        return plain(super().get_offset())


class PlainLog(LogFormatterSciNotation):
    """Powers of ten."""

    def __call__(self, x, pos=None) -> str:
        return plain(super().__call__(x, pos))


def make_plain(figure) -> None:
    """Give every axis of a figure plain labels, but those with labels of their own."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if type(axis.get_major_formatter()) is ScalarFormatter:
                axis.set_major_formatter(PlainScalar())
            for name in ("major", "minor"):
                if type(getattr(axis, f"get_{name}_formatter")()) is LogFormatterSciNotation:
                    getattr(axis, f"set_{name}_formatter")(PlainLog(labelOnlyBase=name == "major"))
