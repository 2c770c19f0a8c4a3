"""Curve sets, one publication a file: the registry. A new one is its file and one line here."""

from .curve_set import Curve, Curves, CurveSet, by_muscle, sampled
from .degroote_fregly2016 import DEGROOTE_FREGLY2016
from .millard2012 import MILLARD2012
from .nguyen2019 import NGUYEN2019, NGUYEN2019_PRINTED, PRINTED_TOE
from .thelen2003 import THELEN2003

CURVES = {
    curves.name: curves for curves in (NGUYEN2019, NGUYEN2019_PRINTED, DEGROOTE_FREGLY2016, MILLARD2012, THELEN2003)
}
# the printed toe jumps: it is for the errata study only
SIMULATED = tuple(name for name in CURVES if name != NGUYEN2019_PRINTED.name)

__all__ = [
    "CURVES",
    "DEGROOTE_FREGLY2016",
    "MILLARD2012",
    "NGUYEN2019",
    "NGUYEN2019_PRINTED",
    "PRINTED_TOE",
    "SIMULATED",
    "THELEN2003",
    "Curve",
    "CurveSet",
    "Curves",
    "by_muscle",
    "sampled",
]
