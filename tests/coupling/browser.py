#!/usr/bin/python3
"""What a browser makes of reports: exits with 1 where one of them has errors, lacks a picture or a chart, is wider than its window,
or cannot be read.

    tests/coupling/browser.py PAGE.html...
    tests/coupling/browser.py PAGE.html --picture FILE.png    # the whole page, too
"""
import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

BROWSER = next(filter(None, map(shutil.which, ("chromium-headless-shell", "chromium", "google-chrome"))), None)
WINDOWS = [(400, False), (1600, False), (400, True)]  # width, dark
PROBE = """<script>addEventListener("load", () => {
  const pictures = [...document.images], d = document.documentElement, slider = document.querySelector(".player input");
  if (slider) { slider.value = 1; slider.dispatchEvent(new Event("input")); }
  document.body.innerHTML = JSON.stringify({pictures: pictures.length, shown: pictures.filter(p => p.naturalWidth > 0).length,
    paper: getComputedStyle(document.body).backgroundColor, ink: getComputedStyle(document.body).color,
    charts: document.querySelectorAll("svg[viewBox]").length, wide: d.scrollWidth - innerWidth, tall: d.scrollHeight,
    told: slider ? document.querySelector(".player output").textContent : ""}); });</script>"""


def browse(folder, page, width, height, *words):
    """`folder`: for what the browser leaves."""
    return subprocess.run([BROWSER, "--no-sandbox", "--headless", "--disable-gpu", "--hide-scrollbars", *words,
                           f"--user-data-dir={folder}/browser", f"--window-size={width},{height}", f"file://{Path(page).resolve()}"],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300, check=False)


def picture(page, file, width=1200):
    """All of a page, in true colour."""
    with tempfile.TemporaryDirectory() as folder:
        browse(folder, page, width, look(page, width, False)["tall"], f"--screenshot={file}")
    Image.open(file).convert("RGB").save(file, optimize=True)


def look(page, width, dark):
    """What is seen of a page in a window: pictures and those shown, charts, pixels beyond the width, errors."""
    with tempfile.TemporaryDirectory() as folder:
        probe = Path(folder) / "page.html"
        probe.write_text(Path(page).read_text(encoding="utf-8") + PROBE, encoding="utf-8")
        scheme = ["--blink-settings=preferredColorScheme=0"] if dark else []
        result = browse(folder, probe, width, 900, "--enable-logging=stderr", *scheme, "--dump-dom")
    seen = json.loads(re.search(r"<body.*?(\{.*\})", result.stdout, re.S)[1])
    seen["errors"] = [line for line in result.stderr.splitlines() if "CONSOLE" in line]
    paper, ink = (sum(int(n) for n in re.findall(r"\d+", seen[what])[:3]) / 3 for what in ("paper", "ink"))
    seen["contrast"] = (ink - paper) * (1 if dark else -1)  # of 255: light on dark, or dark on light
    return seen


def faults(seen):
    return [text for is_wrong, text in (
        (seen["errors"], f"errors: {seen['errors']}"),
        (seen["shown"] < seen["pictures"], f"{seen['pictures'] - seen['shown']} of {seen['pictures']} pictures are not shown"),
        (seen["charts"] == 0, "there is no chart"),
        (seen["wide"] > 0, f"{seen['wide']} pixels wider than the window"),
        (seen["contrast"] < 120, "text and page hardly differ")) if is_wrong]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="+")
    parser.add_argument("--picture", metavar="FILE.png", help="of the first page")
    options = parser.parse_args()
    bad = 0
    for page in options.pages:
        for width, dark in WINDOWS:
            seen = look(page, width, dark)
            wrong = faults(seen)
            bad += bool(wrong)
            print(f"{page}, {width} pixels{', dark' if dark else ''}: {seen['pictures']} pictures, {seen['charts']} charts; "
                  f"{'; '.join(wrong) or 'right'}")
    if options.picture:
        picture(options.pages[0], options.picture)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
