"""Calibrations of encoders, made up."""

from mapping.clip.evidence import fitted_weights
from mapping.clip.fitted.calibration import (
    LIST_OF_VIEWS,
    EncoderCalibration,
    ReliabilityBin,
    encoder_hash,
)


def calibration_for(encoder, **changes):
    """One for an encoder, with the weights that come along but for the last of `join`."""
    weights = fitted_weights()
    content = {
        "model_id": encoder.model_id,
        "encoder_hash": encoder_hash(encoder),
        "views": LIST_OF_VIEWS,
        "homes": ("916", "Studio"),
        "scale": 50.0,
        "bias": -45.0,
        "threshold": 0.9,
        "near": tuple(weights.near.tolist()),
        "far": tuple(weights.far.tolist()),
        "join": (*weights.join[:-1].tolist(), -1.0),
        "reliability": (ReliabilityBin(believed=0.1, true=0.125, places=40),),
        "calibration_error": 0.025,
    }
    return EncoderCalibration.model_validate(content | changes)
