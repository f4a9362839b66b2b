"""Figures.  Every function takes an optional Axes, draws on it and returns it.

Curves differ in line style and marker as well as in colour, so they can be told
apart in grey, and the colours are those of Okabe and Ito, told apart by most eyes.

What draws a figure enters here; it computes nothing.  It uses `compare`, and of the
rooms below what a figure is of: plants, observers and fits.
"""

from .charts import decision_chart as decision_chart
from .curves import error_variance as error_variance
from .curves import estimates as estimates
from .curves import sampled_response as sampled_response
from .designs import pareto as pareto
from .designs import poles as poles
from .diagrams import block_diagram as block_diagram
from .gains import gains as gains
from .records import innovations as innovations
from .robustness import robustness as robustness
from .style import COLOURS as COLOURS
from .style import MARKERS as MARKERS
from .style import panels as panels
from .style import style as style
