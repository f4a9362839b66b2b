"""The filter of a noisy plant, step by step: settings, states, passes, steady gain.

What every design or run that steps a covariance needs enters here.  It uses the
kernels, `numeric` and the certificate; it returns gains and states, not observers.
"""
