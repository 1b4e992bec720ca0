"""Convergence of a benchmark's values."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def convergence(benchmark, rows, folder):
    """One panel for each value: ours from coarse to fine, the expected range as a band."""
    figure, axes = plt.subplots(1, len(rows), figsize=(3.6 * len(rows), 3), squeeze=False, layout="constrained")
    for axis, row in zip(axes[0], rows):
        low, high = row.expected
        axis.axhspan(low, high, color="#f7dfa5", ec="#c9a227", label="expected")
        axis.plot(list(row.values), list(row.values.values()), "o-", color="#3b6ea5", label="heartbus")
        axis.set_title(row.name, fontsize=9)
        axis.tick_params(labelsize=8)
        axis.margins(y=0.2)
    axes[0][0].legend(fontsize=8)
    figure.suptitle(f"{benchmark.name}: {benchmark.plan['source']}", fontsize=9)
    figure.savefig(folder / f"{benchmark.name}.png", dpi=110)
    plt.close(figure)
