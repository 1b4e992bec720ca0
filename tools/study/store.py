"""The runs of all studies, once each: results/studies/runs/<fingerprint>/ holds scene, results and run.json with how it
ended. A run is done when run.json says so, indicators.json is there, and no default of the program that it relied on has
changed since."""
import json
import os
from pathlib import Path

from results import flat


class Store:
    def __init__(self, folder, defaults):
        self.folder, self.defaults = Path(folder).resolve(), flat(defaults)
        self.retried = set()

    def of(self, case):
        return self.folder / case.fingerprint

    def note(self, case):
        """run.json, or nothing."""
        try:
            note = json.loads((self.of(case) / "run.json").read_text())
        except (OSError, ValueError):
            return {}
        own = flat(case.tree)
        stale = [key for key, value in note.get("defaults", {}).items()
                 if key not in own and self.defaults.get(key) != value]
        return {} if stale else note

    def state(self, case):
        """'done', 'failed' (for good) or 'missing'."""
        state = self.note(case).get("state", "missing")
        if state == "done" and not (self.of(case) / "indicators.json").exists():
            return "missing"
        return "missing" if state == "failed" and case.fingerprint in self.retried else state

    def reason(self, case):
        return self.note(case).get("reason", "")

    def retry(self, case):
        """The failure of this case does not count any more."""
        if self.state(case) == "failed":
            self.retried.add(case.fingerprint)

    def begin(self, case):
        folder = self.of(case)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "run.json").unlink(missing_ok=True)
        return folder

    def end(self, case, state, **more):
        """Written aside and renamed: half a note is none."""
        self.retried.discard(case.fingerprint)
        aside = self.of(case) / "run.json.part"
        aside.write_text(json.dumps({"state": state, **more, "defaults": self.defaults}, indent=1))
        aside.rename(self.of(case) / "run.json")

    def link(self, case, name, folder):
        """The run under its name in a study: a link, since studies share runs."""
        link = Path(folder) / name
        link.parent.mkdir(parents=True, exist_ok=True)
        target = os.path.relpath(self.of(case), link.parent)
        if not link.is_symlink() or os.readlink(link) != target:
            link.unlink(missing_ok=True)
            link.symlink_to(target)
