"""Where the filter of a noisy plant ends: a step of its covariance, the steady gain.

What every steady design needs enters here.  It uses the kernels, `numeric` and the
certificate; it returns gains, not observers.
"""
