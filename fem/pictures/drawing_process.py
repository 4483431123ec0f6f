"""Whether this machine can draw off-screen: where system libraries are missing, VTK ends its process without a word."""

import os
import subprocess
import sys

from lagrange.errors import UsageError

# VTK alone, since the libraries are what may be missing: importing pyvista would take most of the time
PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkWindowToImageFilter
sphere, mapper, actor = vtkSphereSource(), vtkPolyDataMapper(), vtkActor()
mapper.SetInputConnection(sphere.GetOutputPort())
actor.SetMapper(mapper)
renderer, window, image = vtkRenderer(), vtkRenderWindow(), vtkWindowToImageFilter()
renderer.AddActor(actor)
window.SetOffScreenRendering(True)
window.SetSize(32, 32)
window.AddRenderer(renderer)
window.Render()
image.SetInput(window)
image.Update()
low, high = image.GetOutput().GetPointData().GetScalars().GetRange(0)
assert high > low, "the picture is blank"
"""
CURE = "apt-get install --no-install-recommends libgl1 libegl1"
PATIENCE = 60.0  # s


def check_rendering() -> None:
    """Draw a small picture in a process of its own. UsageError: it failed, with what cures it."""
    environment = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow", **os.environ}
    try:
        probe = [sys.executable, "-P", "-c", PROBE]  # -P: nothing is imported from the current folder
        done = subprocess.run(probe, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        raise UsageError(rendering_failure(f"a trial picture was not finished in {PATIENCE:.0f} s")) from None
    except OSError as error:
        raise UsageError(rendering_failure(f"a trial could not be started: {error.strerror}")) from None
    if done.returncode != 0:
        raise UsageError(rendering_failure(_reason(done)))


def _reason(done: subprocess.CompletedProcess) -> str:
    if done.returncode in (-11, 139):
        return "a trial picture crashed: OpenGL libraries are missing"
    said = [line for line in done.stderr.splitlines() if line.strip()]
    return f"a trial picture failed (exit {done.returncode})" + (f": {said[-1].strip()[:200]}" if said else "")


def rendering_failure(reason: str) -> str:
    """Say why nothing can be drawn, and what cures it."""
    return f"this machine can't draw off-screen ({reason}); install the system libraries:\n{CURE}"
