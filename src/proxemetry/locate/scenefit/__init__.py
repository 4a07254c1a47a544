"""The scene fit: camera height, pitch and all people's places, sizes and postures at once."""

from .fit import PITCH_SD_RAD, ROLL_SD_RAD, locate, shared_prior

__all__ = ["PITCH_SD_RAD", "ROLL_SD_RAD", "locate", "shared_prior"]
