"""Labels of ticks in figures: plain text that says what matplotlib's mathematical labels say."""

import matplotlib.pyplot as plt
import pytest

from residual.figures.style import make_plain, plain


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        (r"$\mathdefault{10^{-3}}$", "10⁻³"),
        (r"$\mathdefault{10^{12}}$", "10¹²"),
        (r"$\mathdefault{2\times10^{-3}}$", "2×10⁻³"),
        ("1e−5", "×10⁻⁵"),
        ("1e6", "×10⁶"),
        ("", ""),
        ("0.25", "0.25"),
    ],
)
def test_powers_of_ten_are_raised_figures(label, expected):
    assert plain(label) == expected


def test_no_label_of_a_figure_needs_mathematics():
    figure, (left, right) = plt.subplots(1, 2)
    left.loglog([1e-9, 2e3], [3e-7, 5e2])
    right.plot([0.0, 1.0], [0.0, 3e-7])
    make_plain(figure)
    figure.draw_without_rendering()
    labels = [text.get_text() for axes in (left, right) for text in (*axes.get_xticklabels(), *axes.get_yticklabels())]
    labels.append(right.yaxis.get_offset_text().get_text())
    plt.close(figure)
    assert not any(mark in label for label in labels for mark in "$^\\")
    assert "10⁻⁷" in labels[-1] and "10³" in labels
