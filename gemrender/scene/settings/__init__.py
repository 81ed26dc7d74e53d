"""Settings made from a stone's own outline: solitaire and bezel rings, pendants."""

from gemrender.scene.settings.making import MadeSetting, make_setting
from gemrender.scene.settings.setting import FINISHES, SETTINGS, Setting

__all__ = ["FINISHES", "SETTINGS", "MadeSetting", "Setting", "make_setting"]
