"""Damage to checkpoints and recordings, and the checksums that let damaged content pass to who reads it."""
import json

import h5py


def checksum(data):
    """64-bit FNV-1a, as coupler/manifest.cpp."""
    total = 0xCBF29CE484222325
    for byte in data:
        total = (total ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{total:016x}"


def seal(folder, **changes):
    """Gives a set the checksums of what it holds now."""
    path = folder / "manifest.json"
    manifest = {**json.loads(path.read_text()), **changes}
    del manifest["checksum"]
    for name in manifest["files"]:
        data = (folder / name).read_bytes()
        manifest["files"][name] = {"bytes": len(data), "checksum": checksum(data)}
    text = json.dumps(manifest, separators=(",", ":"), ensure_ascii=False)
    manifest["checksum"] = checksum(text.encode())
    path.write_text(json.dumps(manifest, indent=2))


def truncate(path):
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 3])


def flip(path):
    """A byte of the last row of what is recorded or, of other files, in the middle."""
    data = bytearray(path.read_bytes())
    at = len(data) // 2
    if path.name == "calcium.h5":
        with h5py.File(path, "r") as file:
            table = file["values"].id
            at = table.get_chunk_info(table.get_num_chunks() - 1).byte_offset + 3
    data[at] ^= 1
    path.write_bytes(data)


def tables(file):
    found = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return found


def fill(path, value):
    """One value of each field; of a wall the one farthest from the blood, so that nobody hears of it in its place."""
    with h5py.File(path, "r+") as file:
        for name in tables(file):
            if name.split("/")[-1] not in ("points", "activation_time", "step", "time"):
                row = farthest(file) if name.startswith("tissue/displacement") else -1
                file[name][row] = value


def farthest(file):
    return abs(file["tissue/points"][:, 2] - file["interface/points"][0, 2]).argmax()


def turn_over(path):
    """Moves the point of the wall that is farthest from the blood through its cell."""
    with h5py.File(path, "r+") as file:
        height = file["interface/points"][0, 2]
        row = farthest(file)
        for name in file["tissue"]:
            if name.startswith("displacement"):
                file["tissue"][name][row, 2] = 2 * (height - file["tissue/points"][row, 2])


def drop_rank(path):
    """The points of the second half, which another rank held."""
    with h5py.File(path, "r+") as file:
        for name in tables(file):
            if name in ("step", "time"):
                continue
            axis = 1 if name == "values" else 0
            values, attributes = file[name][:], dict(file[name].attrs)
            half = values.take(range(values.shape[axis] // 2), axis)
            del file[name]
            file[name] = half
            file[name].attrs.update(attributes)
