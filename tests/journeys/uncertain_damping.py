"""An oscillator whose damping is known to 30 %: which filter is the safest?

Filters for several dampings, and one for noise that multiplies the speed, are judged on
the plants that there may be; the one whose worst case is least is taken.
"""

import dataclasses

import numpy as np

import luenberger as lb
from luenberger.analysis.constant_parameter import white_noise_factor


def oscillator(damping: float) -> lb.Plant:
    return lb.Plant(
        [[0, 1], [-25, -damping]], None, [[1, 0]], Q=np.diag([1e-6, 0.02]),
        R=[[0.01]], P0=np.diag([8e-4, 0.02]),
        state_names=["position (m)", "speed (m/s)"],
    )  # fmt: skip


nominal = oscillator(0.5)
plant = nominal.sampled(0.05)
filters = {
    f"for {share} %": lb.kalman_filter(oscillator(0.5 * share / 100).sampled(0.05))
    for share in (70, 95, 100, 130)
}
slope = (oscillator(0.501).sampled(0.05).A - oscillator(0.499).sampled(0.05).A) / 2e-3
factor = white_noise_factor(filters["for 100 %"], plant, slope)
for name, stronger in (("white", 1.0), ("white, scaled", factor)):
    noise = np.sqrt(stronger / 3) * 0.15 * slope  # even between -0.15 and 0.15
    noisy = dataclasses.replace(plant, multiplicative=[(noise, 0 * plant.C)])
    filters[name] = lb.fixed_order_filter(noisy, 2)

plants = lb.vary(nominal, {"A[1,1]": "30 %"}, samples=20)
found = lb.compare(plant, filters, plants=plants)
safest = found.recommended(0)

# -- the same by simulations of the true plants

assert safest.name == "for 95 %"
ends = [*plants][:2]  # the corners, 130 % and 70 %
for name in (safest.name, "for 130 %"):
    for end in ends:
        one, true = found.find(name).cases[end], -plants[end].A[1, 1]
        runs = dict(runs=2000, steps=150, seed=4)
        true = oscillator(true).sampled(0.05)
        seen = lb.monte_carlo(true, filters[name], **runs).covariance[-1]
        np.testing.assert_allclose(seen.diagonal(), one.covariance.diagonal(), rtol=0.1)
        own = lb.monte_carlo(true, lb.kalman_filter(true), **runs).covariance[-1]
        ratio = np.sqrt(seen.diagonal() / own.diagonal()).max()  # on the same noise
        np.testing.assert_allclose(ratio, one.error, atol=0.006)

# -- white noise of the same variance buys nothing, scaled a little, a choice more

worst = {one.name: one.error - 1 for one in found}
assert factor > 30
assert abs(worst["white"] / worst["for 100 %"] - 1) < 0.02
assert 0.9 < worst["white, scaled"] / worst["for 100 %"] < 0.97
assert worst["for 95 %"] < 0.8 * worst["for 100 %"]
