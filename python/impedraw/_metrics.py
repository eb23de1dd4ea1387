"""The metrics of a run. Written by setup/python_sources.py: change src/metrics/metric_definitions.cc."""

from __future__ import annotations

from collections.abc import Iterator, Mapping


class Metrics(Mapping[str, float | None]):
    """Numbers of a run, by attribute or by name. None: it could not be computed, and ``reasons`` says why."""

    def __init__(self, values: Mapping[str, float | None], reasons: Mapping[str, str]) -> None:
        self._values = dict(values)
        self.reasons: dict[str, str] = dict(reasons)

    def __getitem__(self, name: str) -> float | None:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return "Metrics(" + ", ".join(f"{k}={v!r}" for k, v in self._values.items()) + ")"

    @property
    def contact_fraction(self) -> float | None:
        """Pen-down samples with ink / all pen-down samples."""
        return self._values["contact_fraction"]

    @property
    def strokes_missed(self) -> int | None:
        """Strokes without any ink."""
        value = self._values["strokes_missed"]
        return None if value is None else int(value)

    @property
    def ink_error_rms(self) -> float | None:
        """Distance of the ink to its own target line, root mean square [mm]."""
        return self._values["ink_error_rms"]

    @property
    def ink_error_p95(self) -> float | None:
        """Distance of the ink to its own target line, 95th percentile [mm]."""
        return self._values["ink_error_p95"]

    @property
    def ink_error_max(self) -> float | None:
        """Distance of the ink to its own target line, largest [mm]."""
        return self._values["ink_error_max"]

    @property
    def ink_error_rms_to_45(self) -> float | None:
        """Ink_error_rms where the canvas leans by less than 45° from the drawing axis [mm]."""
        return self._values["ink_error_rms_to_45"]

    @property
    def tracking_error_rms(self) -> float | None:
        """Distance of the tip from where the controller wanted it at that instant, along the canvas, root mean square; a lag along the line counts [mm]."""
        return self._values["tracking_error_rms"]

    @property
    def tracking_error_max(self) -> float | None:
        """Distance of the tip from where the controller wanted it at that instant, largest [mm]."""
        return self._values["tracking_error_max"]

    @property
    def coverage(self) -> float | None:
        """Share of the target's length with ink within 0.5 mm."""
        return self._values["coverage"]

    @property
    def gaps(self) -> int | None:
        """Uncovered spans longer than 1 mm."""
        value = self._values["gaps"]
        return None if value is None else int(value)

    @property
    def longest_gap(self) -> float | None:
        """The longest of them [mm]."""
        return self._values["longest_gap"]

    @property
    def ink_outside(self) -> float | None:
        """Share of the ink's length further than 1 mm from its target."""
        return self._values["ink_outside"]

    @property
    def ink_up(self) -> float | None:
        """Ink while the pen had to be up [mm]."""
        return self._values["ink_up"]

    @property
    def force_mean(self) -> float | None:
        """Normal force, from 0.2 s after the first touch on [N]."""
        return self._values["force_mean"]

    @property
    def force_sd(self) -> float | None:
        """Normal force, standard deviation [N]."""
        return self._values["force_sd"]

    @property
    def force_rms_error(self) -> float | None:
        """Normal force against the force asked for, root mean square [N]."""
        return self._values["force_rms_error"]

    @property
    def force_peak(self) -> float | None:
        """Normal force, largest [N]."""
        return self._values["force_peak"]

    @property
    def touchdown_peak(self) -> float | None:
        """Largest normal force in the 0.2 s from a first touch [N]."""
        return self._values["touchdown_peak"]

    @property
    def width_error_rms(self) -> float | None:
        """Drawn width of the line against that of the force asked for, as a share of the latter, root mean square; from 0.2 s after the first touch on."""
        return self._values["width_error_rms"]

    @property
    def contact_force_max(self) -> float | None:
        """Largest normal force of all rows, also while the pen is up [N]."""
        return self._values["contact_force_max"]

    @property
    def tilt_mean(self) -> float | None:
        """Pen against the canvas's normal, mean [deg]."""
        return self._values["tilt_mean"]

    @property
    def tilt_p95(self) -> float | None:
        """Pen against the canvas's normal, 95th percentile [deg]."""
        return self._values["tilt_p95"]

    @property
    def tilt_max(self) -> float | None:
        """Pen against the canvas's normal, largest [deg]."""
        return self._values["tilt_max"]

    @property
    def normal_error_mean(self) -> float | None:
        """Estimated against true normal, mean [deg]."""
        return self._values["normal_error_mean"]

    @property
    def normal_error_p95(self) -> float | None:
        """Estimated against true normal, 95th percentile [deg]."""
        return self._values["normal_error_p95"]

    @property
    def cloud_bias_mean(self) -> float | None:
        """Cloud above the true canvas, mean [mm]."""
        return self._values["cloud_bias_mean"]

    @property
    def cloud_bias_sd(self) -> float | None:
        """Cloud above the true canvas, standard deviation [mm]."""
        return self._values["cloud_bias_sd"]

    @property
    def speed_mean(self) -> float | None:
        """Speed of the contact point along the ink, mean [mm/s]."""
        return self._values["speed_mean"]

    @property
    def speed_p95(self) -> float | None:
        """Speed of the contact point along the ink, 95th percentile [mm/s]."""
        return self._values["speed_p95"]

    @property
    def draw_time(self) -> float | None:
        """Pen-down time [s]."""
        return self._values["draw_time"]

    @property
    def time_scale_mean(self) -> float | None:
        """Speed of the plan's clock over pen-down samples, mean."""
        return self._values["time_scale_mean"]

    @property
    def drawn(self) -> float | None:
        """Share of the artwork's length that has ink, wherever it lies."""
        return self._values["drawn"]

    @property
    def length_asked(self) -> float | None:
        """Length of the artwork, in the drawing plane [mm]."""
        return self._values["length_asked"]

    @property
    def length_promised(self) -> float | None:
        """Of that, what the pre-flight promised [mm]."""
        return self._values["length_promised"]

    @property
    def length_undrawable(self) -> float | None:
        """Of that, what the pre-flight named as not drawable [mm]."""
        return self._values["length_undrawable"]

    @property
    def length_unnamed(self) -> float | None:
        """Of that, neither promised nor named; 0 but for a fault [mm]."""
        return self._values["length_unnamed"]

    @property
    def length_reachable(self) -> float | None:
        """Of the artwork, where the true canvas leans by less than 75°, within the arm's reach [mm]."""
        return self._values["length_reachable"]

    @property
    def slope_max(self) -> float | None:
        """Steepest slope of the canvas under the target, against the level [deg]."""
        return self._values["slope_max"]

    @property
    def planned_time(self) -> float | None:
        """Duration of the planned path [s]."""
        return self._values["planned_time"]

    @property
    def torque_saturated(self) -> float | None:
        """Share of steps in which a joint's torque was clipped."""
        return self._values["torque_saturated"]

    @property
    def joint_margin_min(self) -> float | None:
        """Smallest distance to a joint limit [rad]."""
        return self._values["joint_margin_min"]

    @property
    def joint_speed_share_max(self) -> float | None:
        """Largest joint speed as a share of its limit."""
        return self._values["joint_speed_share_max"]

    @property
    def step_time_p50(self) -> float | None:
        """Controller step, median [µs]."""
        return self._values["step_time_p50"]

    @property
    def step_time_p99(self) -> float | None:
        """Controller step, 99th percentile [µs]."""
        return self._values["step_time_p99"]

    @property
    def step_time_p999(self) -> float | None:
        """Controller step, 99.9th percentile [µs]."""
        return self._values["step_time_p999"]

    @property
    def real_time_factor(self) -> float | None:
        """Simulated seconds per wall second of the loop, logging included."""
        return self._values["real_time_factor"]
