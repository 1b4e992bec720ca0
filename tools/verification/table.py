"""The table of what came out."""


def shown(value):
    return f"{value:.5g}"


def expected(row):
    low, high = row.expected
    return shown(low) if low == high else f"{shown(low)} to {shown(high)}"


def line(row):
    values = ", ".join(f"{shown(value)} ({mesh})" for mesh, value in row.values.items())
    finest = list(row.values.values())[-1]
    deviation = row.deviation(finest)
    verdict = "within" if row.is_within else "BEYOND"
    return (f"| {row.benchmark} | {row.name} | {expected(row)} | {values} | {100 * deviation:.2f} % | "
            f"{verdict} {100 * row.tolerance:g} % |")


def write(rows, path):
    head = ["| benchmark | value | expected | ours (mesh) | deviation | |", "|---|---|---|---|---|---|"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(head + [line(row) for row in rows]) + "\n")
