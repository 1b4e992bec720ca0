"""All fields of a run in ParaView, at all of its times: paraview --script=paraview_state.py

Wall and blood are moved, meet at the interface and are cut open; potential and activation are there, hidden. Units stand
with the names of the fields.
"""
import os

from paraview.simple import (AnnotateTimeFilter, Clip, ColorBy, GetActiveViewOrCreate, GetAnimationScene, GetColorTransferFunction, Hide,
                             Render, ResetCamera, Show, WarpByVector, XDMFReader)

RESULTS = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else "."
# File, name, the field by which it is moved, the one by which it is coloured, whether it is seen at first.
SERIES = (("mech", "wall", "displacement [m]", "active_tension [Pa]", True), ("fluid", "blood", "motion [m]", "velocity [m/s]", True),
          ("ep", "electrophysiology", "", "potential [V]", False), ("activation", "activation", "", "activation_time [s]", False))
INSTANTS = 5  # that are looked at for the range of the colours


def half(source, name):
    """What lies behind the middle, seen from the front."""
    low, high = source.GetDataInformation().GetBounds()[2:4]
    clip = Clip(registrationName=f"half of the {name}", Input=source)
    clip.ClipType.Normal = [0, 1, 0]
    clip.ClipType.Origin = [0, 0 if low * high < 0 else (low + high) / 2, 0]
    clip.Invert = 0
    return clip


def opened(file, name, motion):
    """The series, moved and cut open, and its times."""
    reader = source = XDMFReader(registrationName=name, FileNames=[file])
    if motion:
        source = WarpByVector(registrationName=f"moved {name}", Input=reader, Vectors=["POINTS", motion])
    source.UpdatePipeline()
    return half(source, name), list(reader.TimestepValues)


def span(source, field, times):
    """Range of a field, of a vector its length, over some of the times."""
    ranges = []
    for k in {len(times) * i // INSTANTS for i in range(INSTANTS)}:
        source.UpdatePipeline(*times[k:k + 1])
        ranges.append(source.PointData[field].GetRange(-1 if source.PointData[field].GetNumberOfComponents() > 1 else 0))
    return min(low for low, _ in ranges), max(high for _, high in ranges)


def main():
    view, scene = GetActiveViewOrCreate("RenderView"), GetAnimationScene()
    series = [(os.path.join(RESULTS, "fields", f"{file}.xdmf"), *about) for file, *about in SERIES]
    series = [each for each in series if os.path.exists(each[0])]
    for k, (file, name, motion, field, is_seen) in enumerate(series):
        source, times = opened(file, name, motion)
        if k == 0:
            Show(AnnotateTimeFilter(registrationName="time", Input=source, Format="t = {time:.4f} s"), view)
        display = Show(source, view)
        ColorBy(display, ("POINTS", field))
        GetColorTransferFunction(field).RescaleTransferFunction(*span(source, field, times))
        display.SetScalarBarVisibility(view, is_seen or k == 0)
        if k and not is_seen:
            Hide(source, view)
    scene.UpdateAnimationUsingDataTimeSteps()
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0, -1, 0], [0, 0, 0], [0, 0, 1]
    ResetCamera(view)
    Render(view)


main()
