from benchmarks.slam.homes import AS_RECORDED
from benchmarks.slam.lap_scores import LapResult

LAP = LapResult(
    home=1000, fault=AS_RECORDED, frames=900, path_length=50.0, ate=0.02, ate_final=0.01,
    end_error=0.02, end_turn=0.4, tracked=0.9, lost=0.0, keyframes=120, closures=7,
    wrong_closures=0, nees=6.1, measured_in=100, ms_mean=30.0, ms_median=28.0, ms_p95=60.0,
)  # fmt: skip
