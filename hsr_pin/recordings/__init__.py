"""Motion-capture recordings: reading, importing, cleaning and writing."""

from hsr_pin.recordings.clean import clean
from hsr_pin.recordings.noise import noise_floor, noise_per_axis
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

__all__ = ["clean", "noise_floor", "noise_per_axis", "read_dataset", "write_dataset"]
