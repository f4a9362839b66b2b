"""What any observer is worth, by formula: error covariance, moments, optimality.

A question about any plant and observer that a formula answers enters here; how an
observer was designed does not matter.  It uses the kernels, `numeric`, the certificate.
"""
