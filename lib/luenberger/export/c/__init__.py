"""The C99 of an observer or a filter: body, header, self-test, names.

What says which functions and fields a device sees enters here; the statements are
printed by `kernels`.  It uses `kernels`, `recursion`, `run` and `formats`.
"""
