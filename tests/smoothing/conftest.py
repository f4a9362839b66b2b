"""The ways in which many records run: NumPy, generated code as Python, compiled."""

from as_python import backend as backend
