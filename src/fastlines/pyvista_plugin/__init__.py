"""Entry points for PyVista: ``pyvista.read`` reads files of lines, and ``mesh.fastlines`` queries the lines of a mesh.

PyVista (0.48 or later) imports `readers` when it reads a file of one of our extensions, and `accessor` when
``mesh.fastlines`` is used for the first time. The table of both is in ``pyproject.toml``.
"""
