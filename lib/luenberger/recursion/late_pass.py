"""One pass of a filter over a record whose readings may arrive late."""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix, Vector
from . import late_state
from .late_state import LateState, Row
from .late_step import step as joint_step
from .settings import Settings
from .state import History, State, start, step
