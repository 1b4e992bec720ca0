"""Convergence of a benchmark's values."""
from reporting.style import PALETTE, plt, tint


def convergence(benchmark, rows, folder):
    """One panel for each value: ours from coarse to fine, the expected range as a band."""
    figure, axes = plt.subplots(1, len(rows), figsize=(3.6 * len(rows), 3), squeeze=False, layout="constrained")
    for axis, row in zip(axes[0], rows):
        low, high = row.expected
        axis.axhspan(low, high, color=tint(PALETTE[4], 2), ec=PALETTE[4], label="expected")
        axis.plot(list(row.values), list(row.values.values()), "o-", color=PALETTE[0], label="heartbus")
        axis.set_title(row.name, fontsize=9)
        axis.tick_params(labelsize=8)
        axis.margins(y=0.2)
    axes[0][0].legend(fontsize=8)
    figure.suptitle(f"{benchmark.name}: {benchmark.plan['source']}", fontsize=9)
    figure.savefig(folder / f"{benchmark.name}.png", dpi=110)
    plt.close(figure)
