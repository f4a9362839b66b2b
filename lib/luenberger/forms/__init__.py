"""An observer in other coordinates, on plain arrays: modal, balanced, companion.

`derivation` proves that a change of coordinates keeps the estimate and the certificate;
the other modules find coordinates.  A new form enters here, and its method in `Forms`.
"""

from .methods import Forms as Forms
