"""The errors that vizbot raises on purpose.

Each message is one line that names the thing, the value and the remedy. Expected outcomes (no path,
tracking lost, nothing found) are values, not errors.
"""


class VizbotError(Exception):
    """Base of every error a caller may want to catch."""


class ConfigError(VizbotError):
    """A setting, argument or file given by the user cannot be used."""


class DeviceError(VizbotError):
    """A camera or a base is missing, gone, or not what it should be."""


class DeviceTimeoutError(DeviceError, TimeoutError):
    """A device is there but has not answered in time."""


class MapError(VizbotError):
    """A saved map is missing, torn, of another schema or of another encoder."""
