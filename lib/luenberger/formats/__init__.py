"""Files and tables from outside: read with errors that help, written whole.

What knows a file format or another package's table enters here, as plain data; no
plant and no observer does.  It uses `errors` alone.
"""
