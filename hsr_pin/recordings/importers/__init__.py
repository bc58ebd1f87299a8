"""Import of recordings from tracking systems: one reader for each format, and their conversion to a dataset."""

from hsr_pin.recordings.importers.assemble import Imported, import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.capture import Capture
from hsr_pin.recordings.importers.declared import declared_settings
from hsr_pin.recordings.importers.detect import read_capture
from hsr_pin.recordings.importers.settings import ImportSettings

__all__ = ["Body", "Capture", "ImportSettings", "Imported", "declared_settings", "import_recordings", "read_capture"]
