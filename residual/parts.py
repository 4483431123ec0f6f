"""What a report is to hold beside the check itself."""

from dataclasses import dataclass
from typing import Literal

from residual.evaluation import Evaluation
from residual.fault_finding import FaultSearch

Export = Literal["csv", "curves", "mat", "wav"]


@dataclass(frozen=True, kw_only=True)
class Parts:
    """Of a report."""

    tolerance: float | None = None  # N, on the rms of both errors; None: no verdict
    search: FaultSearch | None = None  # for spalls; None: none was made
    figures: bool = True  # most of a report's time
    equations: bool = True  # False: of the run alone, without the error forces of (22) and (23)
    exports: tuple[Export, ...] = ()  # the data in other formats
    other: Evaluation | None = None  # what the run is compared with
