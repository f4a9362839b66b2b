"""What a plant and an observer look like in JSON, and who reads them."""

import luenberger as lb

PLANT_DATA = dict(
    luenberger="plant", format=1, name="cart", A=[[1, 0.5], [0, 1]], B=[[0.125], [0.5]],
    C=[[1, 0]], dt=0.5, Q=[[0.0625, 0.125], [0.125, 0.25]], R=[[0.5]], x0=[1, 2],
    P0=[[1, 0], [0, 1]], multiplicative=[[[[0, 0], [0, 0.25]], [[0, 0.125]]]],
    state_names=["position", "speed"], output_names=["radar"], description="text",
)  # fmt: skip
OBSERVER_DATA = dict(
    luenberger="observer", format=1, F=[[0.5]], G=[[1]], D=[[0.25]], P=[[0], [1]],
    V=[[1], [2]], T=[[0.5, -1]], L=[[1, 0], [0, 1]], W=[[0], [0]], z0=[0.5], dt=0.5,
    output_names=["radar"], input_names=["push"],
)  # fmt: skip
READERS = {
    "plant": (lb.Plant.from_json, PLANT_DATA),
    "observer": (lb.Observer.from_json, OBSERVER_DATA),
}
