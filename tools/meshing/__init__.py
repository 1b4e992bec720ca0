"""Meshes of other programs, their checks, and the mesh file that the solvers read (docs/meshes.md)."""
