"""Two eyes: closed forms of what they see alike."""

from __future__ import annotations

import numpy as np
import pytest
from stone_cases import load_case  # noqa: F401  (fixtures of designs)

import gemrender
