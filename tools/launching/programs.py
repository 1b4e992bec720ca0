"""Where the programs are."""
import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]  # of the source, or share/heartbus


def command():
    """What is typed for tools/heartbus here: in the source, or where it is installed."""
    if not (ROOT / "run").exists():
        return "heartbus"
    return "tools/heartbus" if Path.cwd() == ROOT else str(ROOT / "tools/heartbus")


def programs():
    """The folder of the coupler and the others: as told, as built, or as installed."""
    built, installed = ROOT / "build/release/bin", ROOT.parents[1] / "bin"
    return Path(os.environ.get("HEARTBUS_BIN", built if built.exists() else installed))
