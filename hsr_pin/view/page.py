"""Interactive page with viser (B. Yi et al., Viser: imperative, web-based 3D visualization, 2025)."""

from __future__ import annotations

import contextlib
import io
import re
import threading
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from hsr_pin.errors import InputError, MissingDependencyError
from hsr_pin.loopback import HOST
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array
from hsr_pin.view.controls import Slider, arm_sliders, effect_sliders, effects_for, variants, with_value
from hsr_pin.view.served import viser_server
from hsr_pin.view.session import Answer, Session, overall
from hsr_pin.view.settings import Settings

if TYPE_CHECKING:
    from hsr_pin.identification.prepared import Run

#: Frame rate of the animation [Hz].
RATE = 15.0
#: Largest number of trials that are chosen by buttons; more trials are chosen from a list.
_BUTTONS = 12
#: Widths of the panels with the curves and with the sliders [px].
_LEFT, _RIGHT = 400, 330
_BLUE, _GREY, _ORANGE = "#0072B2", "#8a8a90", "#D55E00"


class Page:
    """Interactive page with trials, sliders, curves and the arm.

    One thread simulates and plays the motion. The other threads only store the wanted settings.

    Args:
        session: recordings and model.
        found: settings found by a fit or a diagnosis, by trial; empty if there are none.
        report: address of the report of a diagnosis; empty if there is none.
        port: port on this machine; 0: any free port.
    """

    def __init__(self, session: Session, *, found: Mapping[str, Settings] | None = None, report: str = "", port: int = 0) -> None:
        from hsr_pin.view.scene import Scene

        self.session, self._found = session, dict(found or {})
        self.settings, self.trial = Settings(), session.names[0]
        self.finished: tuple[Settings, str] | None = None  # settings and trial of all numbers on the page
        self._wanted, self._lock, self._ended = threading.Event(), threading.RLock(), threading.Event()
        self._handles: dict[str, Any] = {}
        self._folders: dict[str, Any] = {}
        try:
            self._server = viser_server(port, "Try what the model may lack")
        except ImportError as error:
            raise MissingDependencyError("viser", "view") from error
        if port and self._server.get_port() != port:
            self._close()
            raise InputError("--port", expected="a free port", received=port)
        self._gui = self._server.gui
        self._gui.configure_theme(show_logo=False, show_share_button=False)
        self._gui.main_panel.dock_right()
        self._gui.main_panel.set_width(_RIGHT)
        dataset = session.experiment.dataset
        along, count = mount_frame(dataset.mount)[0], len(session.experiment.markers)
        self._scene = Scene(self._server, dataset.length, along, count, space=session.space)
        self._run: Run = session.run(self.trial)
        self._declared = self._answer = session.answer(self._run, Settings())
        self._build(report)
        self._worker = threading.Thread(target=self._work, daemon=True)
        self._wanted.set()
        self._worker.start()

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self._server.get_port()}"

    def stop(self) -> None:
        """Stop the simulation and the server."""
        self._ended.set()
        self._wanted.set()
        self._worker.join()
        self._close()

    def _close(self) -> None:
        with contextlib.redirect_stdout(io.StringIO()):
            self._server.stop()

    def set(self, settings: Settings) -> None:
        """Set all sliders to the given settings."""
        with self._lock:
            self.settings = settings
            for name, (handle, neutral) in self._handles.items():
                given = settings.options if isinstance(neutral, str) else settings.values
                value = given.get(name, neutral)
                if handle.value != value:
                    handle.value = value
            self._mark()
        self._wanted.set()

    def _build(self, report: str) -> None:
        gui, run = self._gui, self._run
        panel = gui.add_panel()
        with panel.add_tab(self.session.experiment.dataset.name):
            self._facts = gui.add_markdown("simulating ...")
            self._trials()
            self._play: Any = gui.add_checkbox("play", True, hint="Repeat the motion in real time.")
            self._clock: Any = gui.add_slider("time [s]", 0.0, float(run.time[-1] - run.time[0]), 0.01, 0.0)
            self._clock.on_update(self._time_set)
            self._curves()
        panel.dock_left()
        panel.set_width(_LEFT)
        if report:
            gui.add_markdown(f"[The report of the diagnosis]({report})")
        self._button("As declared", lambda: Settings())
        if self._found:
            self._button("As found", lambda: self._found.get(self.trial, Settings()))
        with gui.add_folder("Arm, relative to the declared values"):
            for slider in arm_sliders():
                self._slider(slider)
        gui.add_markdown("**Effects** that the model may lack")
        for name, kind in effects_for(space=self.session.space).items():
            self._folders[name] = folder = gui.add_folder(name, expand_by_default=False)
            with folder:
                gui.add_markdown(f"{kind.lacks[0].upper()}{kind.lacks[1:]}: {kind.cause}.")
                for slider in effect_sliders(name):
                    self._slider(slider)
                for option, choices in variants(kind, space=self.session.space).items():
                    self._keep(f"{name}.{option}", gui.add_dropdown(option, choices), choices[0])

    def _trials(self) -> None:
        names = self.session.names
        many = len(names) > _BUTTONS
        chooser: Any = self._gui.add_dropdown("trial", names) if many else self._gui.add_button_group("trial", names)

        def chosen(_: object) -> None:
            with self._lock:
                self.trial = chooser.value
            self._wanted.set()

        chooser.on_update(chosen) if many else chooser.on_click(chosen)

    def _button(self, label: str, made: Callable[[], Settings]) -> None:
        button = self._gui.add_button(label)
        button.on_click(lambda _: self.set(made()))

    def _time_set(self, event: Any) -> None:
        """React to a change of the time; if the user changed it, the motion stops there."""
        if event.client is not None:
            self._play.value = False
        self._wanted.set()

    def _slider(self, slider: Slider) -> None:
        for settings in self._found.values():
            slider = with_value(slider, settings.values.get(slider.name, slider.neutral))
        handle = self._gui.add_slider(slider.label, slider.lower, slider.upper, slider.step, slider.neutral, hint=slider.hint)
        self._keep(slider.name, handle, slider.neutral)

    def _keep(self, name: str, handle: Any, neutral: float | str) -> None:
        self._handles[name] = handle, neutral

        def moved(_: object) -> None:
            with self._lock:
                self.settings = self.settings.changed(name, handle.value)
                self._mark()
            self._wanted.set()

        handle.on_update(moved)

    def _mark(self) -> None:
        """Mark the effects that are not neutral."""
        for name, folder in self._folders.items():
            label = f"{name} ●" if self.settings.acts(name) else name
            if folder.label != label:
                folder.label = label

    def _curves(self) -> None:
        from viser import uplot

        axes = uplot.Axis(label="time [s]", labelSize=18, size=32), uplot.Axis(label="mm", labelSize=18, size=46)
        scales = {"x": uplot.Scale(time=False, auto=True), "y": uplot.Scale(auto=True)}

        def plot(title: str, *curves: uplot.Series) -> Any:
            data = (np.array([0.0, 1.0]), *(np.zeros(2) for _ in curves))
            series = (uplot.Series(label="t"), *curves)
            padding = (14, 10, 0, 0)  # top and right, so that the highest number is not cut off
            height = 155 if self.session.space else 205  # of three plots in space, or two in a plane
            return self._gui.add_uplot(data, series, title=title, axes=axes, scales=scales, height=height, padding=padding)

        declared = uplot.Series(label="declared", stroke=_GREY, width=1.5)
        simulated = uplot.Series(label="simulated", stroke=_BLUE, width=2.0)
        measured = uplot.Series(label="measured", stroke=_ORANGE, width=1.5)
        noise = uplot.Series(label="noise", stroke=_ORANGE, width=1.0, dash=(4.0, 4.0))
        self._errors = plot("Distance of the markers from the measured ones", declared, simulated, noise)
        self._tips = [(plot(title, declared, measured, simulated), direction) for title, direction in self.session.across.items()]

    def _work(self) -> None:
        shown: tuple[object, object] = None, None
        begun, left, others = time.monotonic(), list[str](), list[Answer]()
        while not self._ended.is_set():
            playing = self._play.value
            if self._wanted.wait(1.0 / RATE if playing or left else None):
                self._wanted.clear()
            with self._lock:
                settings, trial = self.settings, self.trial
            if (settings, trial) != shown:
                if trial != shown[1]:
                    self._show_trial(trial)
                    begun = time.monotonic()
                self._answer = self.session.answer(self._run, settings)
                self._draw(self._answer)
                self._write_summary(None)
                shown, left, others = (settings, trial), list(self.session.names), []
            elif left:  # simulate the other trials one by one while no setting changes
                others.append(self.session.answer(self.session.run(left.pop()), settings))
                if not left:
                    self._write_summary(overall(others))
                    self.finished = settings, trial
            if playing:
                whole = float(self._run.time[-1] - self._run.time[0]) + 0.5  # the motion pauses before it repeats
                self._clock.value = min(round((time.monotonic() - begun) % whole, 2), self._clock.max)
            else:
                begun = time.monotonic() - self._clock.value
            self._pose()

    def _show_trial(self, trial: str) -> None:
        self._run = self.session.run(trial)
        self._declared = self.session.answer(self._run, Settings())
        self._clock.max = float(self._run.time[-1] - self._run.time[0])

    def _draw(self, answer: Answer) -> None:
        time_axis = np.asarray(self._run.time - self._run.time[0])
        noise = np.full(len(time_axis), self.session.noise)
        tip = int(np.argmax([marker.arc_length for marker in self.session.experiment.markers]))
        self._errors.data = (time_axis, *(1e3 * _drawn(part) for part in (self._declared.error, answer.error, noise)))
        for plot, direction in self._tips:
            on = np.flatnonzero(direction)
            tips = (places[:, tip, on] @ direction[on] for places in (self._declared.markers, self._run.measured, answer.markers))
            plot.data = (time_axis, *(1e3 * _drawn(part) for part in tips))

    def _write_summary(self, whole: float | None) -> None:
        answer, stopped = self._answer, ""
        if answer.stopped is not None:
            stopped = f"\n\nThe simulation stopped at {answer.stopped:.2f} s, as the arm exceeded its bending limit or diverged."
        trial, rest = _plain(self.trial), "..." if whole is None else _mm(whole)
        self._facts.content = (
            f"**{trial}: {_mm(answer.rms)}** RMS distance from the measured markers, {_mm(self._declared.rms)} as declared; "
            f"all trials {rest}; noise alone {_mm(self.session.noise)}. "
            f"Blue: simulated, grey: as declared, orange: measured.{stopped}"
        )

    def _pose(self) -> None:
        sample = int(np.searchsorted(self._run.time - self._run.time[0], self._clock.value - 1e-9))
        sample = min(sample, len(self._run.time) - 1)
        answer, declared = self._answer, self._declared
        with self._server.atomic():
            self._scene.show(
                answer.backbone[sample] if np.isfinite(answer.markers[sample]).all() else np.full((1, 3), np.nan),
                declared.backbone[sample],
                answer.markers[sample],
                self._run.measured[sample],
            )


def _plain(text: str) -> str:
    """Return a text with escaped Markdown and HTML characters, which viser would otherwise interpret."""
    return re.sub(r"[!-/:-@[-`{-~]", r"\\\g<0>", text)


def _drawn(curve: Array) -> Array:
    return np.ascontiguousarray(curve, dtype=float)


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f} mm" if np.isfinite(metres) else "no number"
