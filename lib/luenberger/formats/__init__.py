"""Files and tables from outside: read within limits, written whole or not at all.

What knows a file format or another package's table enters here, as plain data; no
plant and no observer does.  It uses `errors` alone.
"""
