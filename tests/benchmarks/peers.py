"""The same work by other libraries, as their users would ask for it.

A plant is anything with A, C, Q, R, P0; x0 is zero, and no input acts.  Each function
imports its library itself, so that a new process pays for that one alone.
"""

import numpy as np


def first_prior(plant):
    """The covariance of x[1] before y[1], where most filters start."""
    return plant.A @ plant.P0 @ plant.A.T + plant.Q


# -- statsmodels: compiled; it stops its recursion of the covariance as well ----------


def _model(plant, y):
    from statsmodels.tsa.statespace.kalman_smoother import KalmanSmoother

    n, p = len(plant.A), len(plant.C)
    model = KalmanSmoother(k_endog=p, k_states=n, k_posdef=n)
    model.bind(np.ascontiguousarray(y))
    model["design"], model["transition"] = plant.C, plant.A
    model["state_cov"], model["obs_cov"] = plant.Q, plant.R
    model["selection"] = np.eye(n)
    model.initialize_known(np.zeros(n), first_prior(plant))
    return model


def statsmodels(plant, y):
    """Estimates; it is told to keep no more than these."""
    model = _model(plant, y)
    for what in ("forecast", "predicted", "smoothing", "likelihood", "gain"):
        setattr(model, f"memory_no_{what}", True)
    return model.filter().filtered_state.T


def statsmodels_smoothed(plant, y):
    return _model(plant, y).smooth().smoothed_state.T


def statsmodels_likelihood(plant, y):
    return _model(plant, y).loglike()


def statsmodels_fit(plant, y):
    """The log likelihood that it reaches, by L-BFGS with differences.

    The parameters are the deviations of a diagonal Q and of one output's noise, and the
    start is not known.  With its default tolerances it stops short of the optimum.
    """
    from statsmodels.tsa.statespace.mlemodel import MLEModel

    class Model(MLEModel):
        param_names = [f"s{k}" for k in range(plant.n + 1)]
        start_params = np.full(plant.n + 1, np.sqrt(np.mean(np.diff(y, axis=0) ** 2)))

        def update(self, params, **options):
            params = super().update(params, **options)
            self["state_cov"] = np.diag(params[:-1] ** 2)
            self["obs_cov"] = params[-1:, None] ** 2

    model = Model(y, k_states=plant.n)
    model["design"], model["transition"] = plant.C, plant.A
    model["selection"] = np.eye(plant.n)
    model.ssm.initialize_diffuse()
    found = model.fit(disp=0, maxiter=500, factr=10, pgtol=1e-9)
    return found.llf + plant.n / 2 * np.log(2 * np.pi)  # it counts n more factors


# -- FilterPy: NumPy, row by row ------------------------------------------------------


def _filterpy(plant, y):
    from filterpy.kalman import KalmanFilter

    n, p = len(plant.A), len(plant.C)
    filter_ = KalmanFilter(dim_x=n, dim_z=p)
    filter_.F, filter_.H, filter_.Q, filter_.R = plant.A, plant.C, plant.Q, plant.R
    filter_.x, filter_.P = np.zeros((n, 1)), plant.P0
    return filter_, filter_.batch_filter(y[:, :, None])[:2]


def filterpy(plant, y):
    return _filterpy(plant, y)[1][0][:, :, 0]


def filterpy_smoothed(plant, y):
    filter_, (x, P) = _filterpy(plant, y)
    return filter_.rts_smoother(x, P)[0][:, :, 0]


# -- simdkalman: NumPy, many records at once ------------------------------------------


def simdkalman(plant, y, smoothed=False, covariances=False):
    """Estimates of a record (N, p), or of many (M, N, p) side by side."""
    from simdkalman import KalmanFilter

    found = KalmanFilter(plant.A, plant.Q, plant.C, plant.R).compute(
        y.reshape(-1, *y.shape[-2:]), 0,
        initial_value=np.zeros(len(plant.A)), initial_covariance=first_prior(plant),
        filtered=not smoothed, smoothed=smoothed, observations=False,
        covariances=covariances,
    )  # fmt: skip
    states = (found.smoothed if smoothed else found.filtered).states
    if covariances:
        return states.mean, states.cov
    return states.mean.reshape(*y.shape[:-1], -1)


def simdkalman_smoothed(plant, y):
    return simdkalman(plant, y, smoothed=True)


def simdkalman_errors(plant, runs, steps):
    """A Monte Carlo run: covariances of the errors, standard errors, NEES.

    It does not simulate; NumPy does, for all runs at once.
    """
    n, p = len(plant.A), len(plant.C)
    rng = np.random.default_rng(1)
    start, w, v = (
        rng.standard_normal((runs, *shape)) @ np.linalg.cholesky(X).T
        for X, shape in ((plant.P0, (n,)), (plant.Q, (steps, n)), (plant.R, (steps, p)))
    )
    x, state = np.empty((runs, steps, n)), start
    for k in range(steps):
        x[:, k] = state = state @ plant.A.T + w[:, k]
    mean, P = simdkalman(plant, x @ plant.C.T + v, covariances=True)
    e = mean - x
    products = e[..., :, None] * e[..., None, :]
    nees = (e[..., None, :] @ np.linalg.solve(P, e[..., None]))[..., 0, 0]
    spread = products.std(axis=0) / np.sqrt(runs)
    return products.mean(axis=0), spread, nees.mean(axis=0)
