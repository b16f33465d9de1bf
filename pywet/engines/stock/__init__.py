"""The bridge laws that stock programs ship, measured from their binaries as they are: two bodies, one gap, one force."""

from pywet.engines.stock.liggghts import LIGGGHTS_MODELS, liggghts_force
from pywet.engines.stock.yade import YADE_LAWS, yade_force

__all__ = ["LIGGGHTS_MODELS", "YADE_LAWS", "liggghts_force", "yade_force"]
