"""The mesh file: HDF5, SI, groups `solid` and `fluid` (docs/meshes.md). Read by common/geometry/mesh_file.cpp."""
import os

import h5py
import numpy as np

from .model import VERTICES, Part, Refusal

FORMAT = "heartbus mesh 1"


def write(path, parts):
    """`parts`: {"solid": Part, "fluid": Part}, one of them at least. Written aside and renamed."""
    aside = path.with_name(path.name + ".part")
    try:
        with h5py.File(aside, "w") as file:
            file.attrs["format"] = np.bytes_(FORMAT)
            for name, part in parts.items():
                write_part(file.create_group(name), part)
        os.replace(aside, path)
    except OSError as error:
        aside.unlink(missing_ok=True)
        raise Refusal(f"{path}: cannot be written: {error}") from None


def write_part(group, part):
    group.attrs["cell_kind"] = np.bytes_(part.kind)
    group.attrs["label_names"] = np.bytes_("\n".join(part.label_names).encode())
    group.attrs["region_names"] = np.bytes_("\n".join(part.region_names).encode())
    tables = {"points": part.points.astype("<f8"), "cells": part.cells.astype("<u4"), "regions": part.regions.astype("<u4"),
              "faces": part.faces.astype("<u4"), "face_labels": part.face_labels.astype("<u4")}
    if part.fibres is not None:
        tables["fibres"] = part.fibres.reshape(-1, 6).astype("<f8")
    for name, values in tables.items():
        group.create_dataset(name, data=values, compression="gzip", compression_opts=9, shuffle=True, fletcher32=True,
                             track_times=False)


def read(path):
    """{"solid": Part, "fluid": Part}."""
    try:
        with h5py.File(path, "r") as file:
            found = file.attrs["format"].decode() if "format" in file.attrs else "unknown"
            if found != FORMAT:
                raise Refusal(f"{path}: its format is '{found}', not '{FORMAT}': is it a mesh file?")
            parts = {name: read_part(file[name]) for name in ("solid", "fluid") if name in file}
    except Refusal:
        raise
    except Exception as error:  # of whatever class: h5py has many for damage
        raise Refusal(f"{path}: is no mesh file, or damaged: {error}") from None
    if not parts:
        raise Refusal(f"{path}: has neither a solid nor a fluid")
    return parts


def read_part(group):
    def table(name, kind):
        data = group[name]
        if data.size > 1100 * max(data.id.get_storage_size(), 1):
            raise ValueError(f"table {name} claims {data.size} values, more than its file holds")
        return data[()].astype(kind)

    def names(attribute):
        return group.attrs[attribute].decode().split("\n")
    kind = group.attrs["cell_kind"].decode()
    fibres = table("fibres", float).reshape(-1, 2, 3) if "fibres" in group else None
    part = Part(table("points", float), kind, table("cells", np.int64), table("regions", np.int64), names("region_names"),
                table("faces", np.int64), table("face_labels", np.int64), names("label_names"), fibres)
    n = len(part.points)
    if part.cells.shape[1] != VERTICES[kind] or part.cells.max() >= n or part.faces.max() >= n or \
            part.face_labels.max() >= len(part.label_names) or part.regions.max() >= len(part.region_names):
        raise ValueError("indices beyond what they count")
    return part
