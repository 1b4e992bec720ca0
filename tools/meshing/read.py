"""The reader of each format."""
from . import read_carp, read_gmsh, read_vtk, read_xdmf
from .model import Refusal

READERS = {".msh": read_gmsh.read, ".vtu": read_vtk.read, ".vtk": read_vtk.read, ".xdmf": read_xdmf.read,
           ".elem": read_carp.read, ".pts": read_carp.read}


def read(path):
    """A Foreign mesh of a file, or of a folder in svMultiPhysics' layout."""
    if path.is_dir():
        return read_vtk.read_folder(path)
    if not path.exists():
        raise Refusal(f"{path}: there is no such file or folder")
    if path.suffix.lower() not in READERS:
        raise Refusal(f"{path}: no reader for '{path.suffix}'; read are {', '.join(READERS)}, and folders with a .vtu and "
                      "its surfaces (.vtp)")
    return READERS[path.suffix.lower()](path)
