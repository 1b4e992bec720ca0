"""seeds.py CORPUS: good units, manifests and recordings, from which fuzzing begins."""
import json
import sys
from pathlib import Path

import h5py
import numpy as np

corpus = Path(sys.argv[1])
for i, text in enumerate(["1 m", "0.2 ms", "5000 kg/(m^2 s)", "10 mmHg", "1.3e7 kg/(s m^4)", "-85 mV", "1 (m/(s kg))^1", "7 um^2/(s A)",
                          "1e3 1/ms", "0.5", "20 kPa s/m", "1 %"]):
    (corpus / f"units/seed{i}").write_text(text)
manifest = {"step": 40, "time": 0.008, "step_size": 0.0002, "model": {"geometry.shape": "piston"},
            "files": {"mech.h5": {"bytes": 3, "checksum": "0123456789abcdef"}}}
(corpus / "checkpoint/seed").write_text(json.dumps(manifest))
(corpus / "checkpoint/empty").write_text(json.dumps({**manifest, "files": {}}))
with h5py.File(corpus / "recording/seed", "w", libver=("v108", "v108")) as file:  # as recordings are written
    kept = {"fletcher32": True, "compression": "gzip", "compression_opts": 0}
    points = file.create_dataset("points", data=np.arange(6.0).reshape(2, 3), chunks=(2, 3), **kept)
    points.attrs["field"], points.attrs["unit"] = np.bytes_("calcium"), np.bytes_("uM")
    file.create_dataset("values", data=np.ones((2, 2, 1)), chunks=(1, 2, 1), **kept, maxshape=(None, 2, 1))
    file.create_dataset("step", data=np.array([1, 2], dtype="i4"), chunks=(1,), **kept, maxshape=(None,))
    file.create_dataset("time", data=np.array([2e-4, 4e-4]), chunks=(1,), **kept, maxshape=(None,))
