"""How the figures look: fonts, lines and colours as matplotlib's settings, and what several figures draw alike."""

# Okabe and Ito's colours (2008), which most colour-blind people can tell apart.
BLUE, ORANGE, GREEN, RED, SKY, BLACK, GREY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#56b4e9", "black", "0.55"

SETTINGS = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.alpha": 0.35,
    "lines.linewidth": 0.8,
    "legend.fontsize": 8.0,
    "legend.framealpha": 0.9,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "savefig.dpi": 200,
    "figure.constrained_layout.use": True,
    "path.simplify": True,
    "agg.path.chunksize": 20000,
}


def mark(panel, words, corner="upper right"):
    """Write ``words`` into a corner of a panel, on a pale ground."""
    vertical, horizontal = corner.split()
    panel.text(
        0.985 if horizontal == "right" else 0.015,
        0.95 if vertical == "upper" else 0.05,
        words,
        transform=panel.transAxes,
        ha=horizontal,
        va="top" if vertical == "upper" else "bottom",
        fontsize=8.0,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5},
    )
