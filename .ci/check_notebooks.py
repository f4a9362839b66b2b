"""How notebooks are stored: python .ci/check_notebooks.py NOTEBOOK ...

Nothing is run.  The test named `as stored` asks the same of each notebook.
"""

import sys

from notebook_tests import stored

if __name__ == "__main__":
    sys.exit(stored.main(sys.argv[1:]))
