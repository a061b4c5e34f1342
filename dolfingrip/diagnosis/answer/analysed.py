"""What an answer is about."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core.case import Case
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.data.measurement import Measurement


class Analysed(Protocol):
    """Readings with all that could explain them: coupons, or fingers."""

    @property
    def case(self) -> Case: ...
    @property
    def errors(self) -> Errors: ...
    @property
    def measurement(self) -> Measurement: ...
    @property
    def unseen(self) -> Sequence[str]: ...

    def exact(self, fit: Fit) -> np.ndarray:
        """(n,) readings at a fit's numbers, linear nuisances left out."""
        ...
