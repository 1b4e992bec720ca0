"""Folders of a launch for the shared memory and the sessions of Open MPI, so that what a run leaves that died hard is
known to be ours, and is cleared by the next one."""
import os
import re
import shutil
import tempfile
from pathlib import Path

NAME = re.compile(rf"heartbus\.{os.getuid()}\.(\d+)")


def places():
    return [Path(tempfile.gettempdir()), *(path for path in [Path("/dev/shm")] if os.access(path, os.W_OK))]


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # the number is another user's now
        pass
    return True


def clear_dead():
    """Removes what launches of this user have left whose launcher has ended; returns how many bytes of it there were."""
    n_bytes = 0
    for place in places():
        for folder in place.glob(f"heartbus.{os.getuid()}.*"):
            found = NAME.fullmatch(folder.name)
            if found and not is_alive(int(found[1])):
                n_bytes += sum(file.lstat().st_blocks * 512 for file in folder.rglob("*"))
                shutil.rmtree(folder, ignore_errors=True)
    return n_bytes


class Folders:
    """Of one launch on this machine; to be removed when it has ended."""

    def __init__(self):
        self.folders = [place / f"heartbus.{os.getuid()}.{os.getpid()}" for place in places()]
        for folder in self.folders:
            folder.mkdir(mode=0o700, exist_ok=True)

    def variables(self):
        session, memory = self.folders[0], self.folders[-1]
        return {"OMPI_MCA_orte_tmpdir_base": str(session), "OMPI_MCA_btl_vader_backing_directory": str(memory),
                "OMPI_MCA_osc_sm_backing_directory": str(memory), "OMPI_MCA_osc_rdma_backing_directory": str(memory)}

    def remove(self):
        for folder in self.folders:
            shutil.rmtree(folder, ignore_errors=True)
