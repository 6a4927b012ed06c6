"""Texts of a figure that a study, or a results folder, brings along."""

from io import BytesIO

from matplotlib.figure import Figure

from bearingsim.plots.style import disable_invalid_math, drawing


def test_text_that_is_no_formula_is_drawn_literally() -> None:
    with drawing():
        canvas = Figure()
        ax = canvas.subplots()
        ax.set_xscale("log")
        ax.plot([1.0, 1e4], [1.0, 2.0], label=r"$\frac$")
        ax.legend()
        title, formula = canvas.suptitle(r"5 $ and \x$"), ax.set_title(r"$v_\mathrm{rms}$")
        disable_invalid_math(canvas)
        canvas.savefig(BytesIO(), format="svg")
    assert not title.get_parse_math()
    assert formula.get_parse_math()
    assert all(label.get_parse_math() for label in ax.get_xticklabels())
